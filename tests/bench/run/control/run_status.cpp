// A run's status: through the socket's JSON and back, kept by Control, and as the progress line.
#include "bench/run/control/run_status.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <nlohmann/json.hpp>

#include "bench/run/control/control.h"
#include "bench/run/control/progress.h"
#include "bench/run/control/status_board.h"
#include "bench/run/phase_words.h"
#include "tests/bench/monitor/status_example.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;
using namespace std::chrono_literals;

TEST_CASE("status: what a run tells is what a client reads, member by member") {
  RunStatus sent = example_status();
  sent.question_id = 4;
  sent.frames_void = 3;
  sent.answer = GivenAnswer{3, "mounted", "bob"};
  nlohmann::json told, bare, again;
  tell_status(told, sent);
  tell_status(bare, told_status(nlohmann::json::object()));
  CHECK(told.size() == 22);
  for (const auto& [key, value] : told.items()) {
    INFO(key);
    CHECK((!bare.contains(key) || bare.at(key) != value));  // no member of the example is what is read of nothing
  }
  tell_status(again, told_status(nlohmann::json::parse(told.dump())));
  CHECK(again == told);
  CHECK((told.at("readings").size() == 6 && told.at("answer").size() == 3));
  const RunStatus read = told_status(told);
  CHECK((read.run == 7 && read.step == 19 && read.steps == 217));
  CHECK((read.frames == 12 && read.frames_void == 3 && read.frames_planned == 211));
  CHECK((read.left_low_s == 630.0 && read.left_s == 645.0 && read.left_high_s == 680.0 && read.age_s == 0.25));
  CHECK((read.readings->feedback_psi == 39.98 && read.readings->reference_psi == 40.01 && read.target_n == 10.0));
  const RunStatus nothing = told_status(nlohmann::json::object());
  CHECK((nothing.run == 0 && nothing.state == RunState::kEnded && nothing.rate == 1.0));
  CHECK_FALSE((nothing.readings || nothing.target_n || nothing.answer));
  const nlohmann::json empty = nlohmann::json::object();
  const RunStatus hollow = told_status({{"readings", empty}, {"answer", empty}});
  REQUIRE((hollow.readings && hollow.answer));
  CHECK_FALSE((hollow.readings->settled || hollow.readings->force_n || hollow.answer->question != 0));
  for (int i = 0; i <= static_cast<int>(RunState::kEnded); ++i) {
    const auto state = static_cast<RunState>(i);
    CHECK(told_status({{"state", to_string(state)}}).state == state);
  }
  CHECK_THROWS_AS(told_status({{"readings", 3}}), nlohmann::json::exception);
}

TEST_CASE("status: an answer stays small and safe, however long a recipe's question is") {
  RunStatus status = example_status();
  status.question = "is\x1b[2J it \n" + std::string(100000, 'q');
  status.phase = status.reason = status.question;
  nlohmann::json told;
  tell_status(told, status);
  CHECK(told.dump().size() < 4000);
  CHECK_THAT(told["question"].get<std::string>(), Catch::StartsWith("is\\x1b[2J it \\x0a"));
}

TEST_CASE("status: Control keeps the readings when the step changes, and tells how old they are") {
  Control control;
  CHECK_FALSE(control.status().readings);
  control.see({1.0, 2.0, 3.0, 4.0, true, 5.0});
  RunStatus next;
  next.phase = "next";
  next.age_s = 99.0;
  control.publish(next);
  const RunStatus status = control.status();
  CHECK(status.phase == "next");
  REQUIRE(status.readings);
  CHECK((status.readings->reference_psi == 4.0 && status.readings->force_n == 5.0));
  CHECK(status.age_s >= 0.0);
  CHECK(status.age_s < 60.0);
}

TEST_CASE("progress: the first phase of a run in real time is due at once, of a simulation with its time only") {
  RunStatus status;
  status.phase = "opening the devices";
  for (const Progress::Mode mode : {Progress::Mode::kPlain, Progress::Mode::kTerminal}) {
    CHECK(Progress(mode).due(status));
    RunStatus turned = status;
    turned.rate = 0.0;
    if (mode == Progress::Mode::kPlain) CHECK_FALSE(Progress(mode).due(turned));
  }
  CHECK_FALSE(Progress(Progress::Mode::kQuiet).due(status));
}

TEST_CASE("progress: in plain lines a step is no phase of its own, a cycle of conditioning is") {
  CHECK(stage_of("small, step 7 of 22, repeat 1 of 2, loading") == "small");
  CHECK(stage_of("conditioning 2 of 6") == "conditioning 2 of 6");
  CHECK(stage_of("").empty());
}

TEST_CASE("status board: a phase reaches those who ask") {
  Control control;
  Progress progress(Progress::Mode::kQuiet);
  StatusBoard board(control, progress);
  board.now().run = 7;
  board.now().store = "/s.db";
  CHECK(control.status().run == 0);
  board.phase("warming up");
  CHECK(control.status().run == 7);
  CHECK(control.status().phase == "warming up");
  // Without an estimate the time left is by the pace so far; with one it stays.
  board.now().steps = 100;
  board.now().rate = 150.0;
  board.publish();
  CHECK(control.status().left_s == 0.0);
  board.now().step = 10;
  board.publish();
  CHECK((control.status().left_s > 0.0 && control.status().left_high_s == 0.0));
  board.now().left_s = 50.0;
  board.now().left_high_s = 60.0;
  board.publish();
  CHECK(control.status().left_s == 50.0);
}

TEST_CASE("pace: the time left by the pace so far, anew after a way back or a rest of more than a minute") {
  const auto start = Pace::Clock::now();
  Pace pace(start);
  CHECK(pace.left_s(start, 0, 100) < 0.0);
  CHECK(pace.left_s(start + 10s, 10, 100) == 90.0);
  CHECK(pace.left_s(start + 20s, 40, 100) == 30.0);
  CHECK(pace.left_s(start + 25s, 5, 100) < 0.0);  // the repeat is done again
  CHECK(pace.left_s(start + 35s, 10, 100) == 180.0);
  Pace rested(start);
  CHECK(rested.left_s(start + 60s, 10, 40) == 180.0);
  CHECK(rested.left_s(start + 120s, 10, 40) == 360.0);  // the same step again tells nothing more
  CHECK(rested.left_s(start + 180s + 1ns, 20, 40) < 0.0);
  CHECK(rested.left_s(start + 190s + 1ns, 20, 40) < 0.0);
  CHECK(rested.left_s(start + 200s + 1ns, 30, 40) == 20.0);
  CHECK(rested.left_s(start + 201s, 40, 40) == 0.0);
}

TEST_CASE("status: a step's phase has its number, its repeat, and where it goes") {
  sequences::Recipe recipe;
  recipe.name = "descending";
  recipe.repeats = 5;
  recipe.conditioning.cycles = 6;
  sequences::Step step;
  const auto has = [&](const std::vector<std::string>& parts) {
    const std::string phase = phase_of(step, recipe, 19, 217);
    INFO(phase);
    for (const std::string& part : parts) CHECK(phase.find(part) != std::string::npos);
  };
  step.kind = sequences::StepKind::kConditioning;
  step.branch = -1;
  step.repeat = 1;
  has({"2 of 6"});
  const std::string counted = phase_of(step, recipe, 3, 217);
  recipe.conditioning.change_percent = 0.1;  // fewer may do
  CHECK(phase_of(step, recipe, 3, 217) != counted);
  step.kind = sequences::StepKind::kApproach;  // of a conditioning press
  has({"2 of", "6"});
  step.branch = 0;
  CHECK(phase_of(step, recipe, 3, 217).find("6") == std::string::npos);
  step.kind = sequences::StepKind::kMeasure;
  step.branch_from = devices::Psi(60.0);
  has({"descending", "19 of 217", "2 of 5"});
  const std::string falling = phase_of(step, recipe, 19, 217);
  step.branch_to = devices::Psi(61.0);
  CHECK(phase_of(step, recipe, 19, 217) != falling);
  step.kind = sequences::StepKind::kConditioning;  // on the way back
  step.setpoint = devices::Psi(20.0);
  has({"20 psi"});
  step.kind = sequences::StepKind::kPress;
  step.force_n = 10.0;
  step.frame = false;
  has({"10 N"});
  step.kind = sequences::StepKind::kMoveXy;
  step.x_mm = 12.5;
  has({"x 12.5 mm", "y 0 mm"});
  step.kind = sequences::StepKind::kConditioning;
  recipe.conditioning.cycles = 0;  // conditioned once on the way back
  recipe.conditioning.change_percent = 0.0;
  step.branch = -1;
  step.repeat = 0;
  has({"1 of 1"});
}
