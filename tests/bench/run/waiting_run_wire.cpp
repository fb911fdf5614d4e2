// Runs that wait for a person: what a client of the run is told meanwhile, what the person is told, what is done for
// --on-event, and what the run writes down of it. How long it waits differs from time to time, so no time is compared.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "bench/run/control/control_client.h"
#include "bench/run/time_estimate.h"
#include "db/sqlite.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/support/endless_run.h"
#include "tests/support/live_runs.h"
#include "tests/support/process.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::Command;
using bench::RunState;
using Texts = std::vector<std::string>;

namespace {

// Asks a run until it ends, and acts once on each question, and on each pause without one and each suspension that is
// seen.
class PersonAtTheRun {
 public:
  using Act = std::function<void(const std::string& name, const bench::RunStatus& status)>;
  PersonAtTheRun(std::string name, Act act)
      : thread_([asked = std::move(name), acts = std::move(act)] { watch(asked, acts); }) {}
  ~PersonAtTheRun() { thread_.join(); }
  PersonAtTheRun(const PersonAtTheRun&) = delete;
  PersonAtTheRun& operator=(const PersonAtTheRun&) = delete;

 private:
  static void watch(const std::string& name, const Act& act) {
    int answered = 0;
    for (auto live = bench::send_command(name, Command::kStatus); live;
         live = bench::send_command(name, Command::kStatus)) {
      const bench::RunStatus& status = live->status;
      const bool unanswered = status.question.empty() || status.question_id > answered;
      if (status.state == RunState::kSuspended || (status.state == RunState::kPaused && unanswered)) {
        answered = std::max(answered, status.question_id);
        act(name, status);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }
  std::thread thread_;
};

Texts lines_heard(const std::string& text) {
  Texts lines;
  std::istringstream rest(text);
  for (std::string line; std::getline(rest, line);) lines.push_back(line);
  return lines;
}

// Changes of state by their states; what was proved safe, a way back and a question without an answer by their kind.
Texts course_of(const db::RunStore& store) {
  Texts course;
  for (const db::EventRecord& event : store.events(1)) {
    if (event.kind == "state") course.push_back(event.detail.substr(0, event.detail.find(':')));
    if (event.kind == "safe" || event.kind == "way-back" || event.kind == "prompt") course.push_back(event.kind);
  }
  return course;
}

// Repeat, branch, attempt, and whether it is void.
Texts branches_of(const db::RunStore& store) {
  Texts branches;
  for (const db::BranchRecord& branch : store.branches(1))
    branches.push_back(
        fmt::format("{}.{}.{}{}", branch.repeat, branch.ordinal, branch.attempt, branch.is_void ? " void" : ""));
  return branches;
}

struct WaitingRun {
  bench::RunRequest request = small_request();
  // Runs it with a person at it; `act` of the person, `at_step` in the run itself.
  bench::RunResult carry_out(const PersonAtTheRun::Act& act,
                             const std::function<void(const std::string& name, const sequences::Step&)>& at_step) {
    request.on_event = "echo \"$TACTBENCH_EVENT $TACTBENCH_RUN $TACTBENCH_REASON\" >>" + folder.path("events");
    std::unique_ptr<PersonAtTheRun> person;
    std::string name;
    request.on_step = [&](const sequences::Step& step) {
      if (!person) {
        name = live_runs().at(0).name;
        person = std::make_unique<PersonAtTheRun>(name, act);
      }
      at_step(name, step);
    };
    Captured errors(stderr);
    bench::RunResult result = run_small(request, store);
    person.reset();
    notes = lines_heard(errors.text());
    return result;
  }
  // The commands for the events run in the background, in parallel.
  [[nodiscard]] Texts reported_events(std::size_t count) const {
    const auto told = [path = folder.path("events")] {
      return std::filesystem::exists(path) ? lines_heard(read_file(path)) : Texts();
    };
    CHECK(comes_true([&] { return told().size() >= count; }));
    Texts sorted = told();
    std::ranges::sort(sorted);
    return sorted;
  }
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  Texts notes;
};

}  // namespace

TEST_CASE("waiting run: two questions and a pause are asked, answered, reported and stored") {
  WaitingRun run;
  run.request.recipes = {
      recipe_of("unit = \"psi\"\nturning_points = [0, 8, 0]\nstep = 4\n[prompt]\nbefore = \"mount it\"\n"
                "[conditioning]\ncycles = 1\npeak = 8\n"),
      recipe_of("unit = \"psi\"\nturning_points = [0, 4]\nstep = 4\n[prompt]\nbefore = \"turn it\"\n")};
  const bench::TimeEstimate estimate(run.request.recipes, sequences::compile(run.request.recipes),
                                     time_model(run.request.bench));
  run.request.estimate = &estimate;
  std::vector<bench::RunStatus> seen;
  const bench::RunResult result = run.carry_out(
      [&](const std::string& name, const bench::RunStatus& status) {
        if (status.question.empty()) {
          (void)bench::send_command(name, Command::kResume);
          return;
        }
        seen.push_back(status);
        const std::string words = status.question_id == 1 ? bench::answer_packet(1, "all done", "bob") : "resume";
        bench::RunConnection connection(name, words);
        (void)comes_true([&] { return connection.newest().has_value() || !connection.open(); });
      },
      [&](const std::string& name, const sequences::Step& step) {
        if (step.kind == sequences::StepKind::kMeasure && step.sequence == 0 && step.ordinal == 0)
          (void)bench::send_command(name, Command::kPause);
      });
  CHECK(result.outcome == db::Outcome::kCompleted);
  CHECK(std::ranges::none_of(run.store.branches(1), &db::BranchRecord::is_void));  // a pause comes between branches
  CHECK(result.waiting_seconds > 0.5);                                             // three waits of at least 0.2 s
  REQUIRE(seen.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(seen[i].question == (i == 0 ? "mount it" : "turn it"));
    CHECK(seen[i].question_id == static_cast<int>(i) + 1);
    CHECK(seen[i].prompts_left == 2 - static_cast<int>(i));
    CHECK((seen[i].step == (i == 0 ? 0 : 8) && seen[i].steps == 11 && seen[i].frames == (i == 0 ? 0 : 5)));
    CHECK((seen[i].left_low_s < seen[i].left_s && seen[i].left_s < seen[i].left_high_s));
  }
  CHECK(seen[1].left_s < seen[0].left_s);
  CHECK(course_of(run.store) == Texts{"prepared -> running", "safe", "running -> pausing", "pausing -> paused",
                                      "paused -> running", "running -> pausing", "safe", "pausing -> paused",
                                      "paused -> running", "way-back", "safe", "running -> pausing",
                                      "pausing -> paused", "paused -> running", "running -> stopping", "safe"});
  const auto events = run.store.events(1);
  CHECK(std::ranges::any_of(events, [](const db::EventRecord& event) {  // whose answer it was, and which
    return event.kind == "state" && event.detail.find("bob") != std::string::npos &&
           event.detail.find("all done") != std::string::npos;
  }));
  for (const char* told : {"mount it", "turn it", "tactbench resume 1"}) {
    CHECK(
        std::ranges::any_of(run.notes, [&](const std::string& line) { return line.find(told) != std::string::npos; }));
  }
  const Texts told = run.reported_events(4);
  REQUIRE(told.size() == 4);
  CHECK(told[0].starts_with("done 1 "));
  for (std::size_t i = 1; i < 4; ++i) CHECK(told[i].starts_with("waiting 1 "));
  CHECK((told[1].ends_with("mount it") && told[3].ends_with("turn it")));
}

TEST_CASE("waiting run: after a rest longer than the recipe allows only the current repeat is measured again") {
  WaitingRun run;
  run.request.recipes = {
      recipe_of("unit = \"psi\"\nturning_points = [0, 4, 0]\nstep = 4\nrepeats = 2\nrest_restart_s = 0.1\n")};
  bool asked = false;
  const bench::RunResult result = run.carry_out(
      [](const std::string& name, const bench::RunStatus&) { (void)bench::send_command(name, Command::kResume); },
      [&](const std::string& name, const sequences::Step& step) {
        if (asked || step.repeat != 1 || step.branch != 0) return;
        asked = true;
        (void)bench::send_command(name, Command::kPause);
      });
  CHECK(result.outcome == db::Outcome::kCompleted);
  CHECK(branches_of(run.store) == Texts{"0.0.0", "0.1.0", "1.0.0 void", "1.0.1", "1.1.0"});
}

TEST_CASE("waiting run: after a long rest the branches of an earlier process are measured again, too") {
  WaitingRun run;
  run.request.recipes = {recipe_of("unit = \"psi\"\nturning_points = [0, 4, 0, 4]\nstep = 4\nrest_restart_s = 0.1\n")};
  run.request.on_step = [](const sequences::Step& step) {
    if (step.branch == 1) throw std::runtime_error("power cut");
  };
  CHECK(run_small(run.request, run.store).outcome == db::Outcome::kFailed);
  db::sqlite::Connection(run.store.path(), db::sqlite::Access::kReadWrite)
      .execute("UPDATE runs SET ended_utc = '2999-01-01T00:00:00Z'");  // between the processes it did not rest
  run.request.resume = 1;
  bool asked = false;
  const bench::RunResult result = run.carry_out(
      [](const std::string& name, const bench::RunStatus&) { (void)bench::send_command(name, Command::kResume); },
      [&](const std::string& name, const sequences::Step& step) {
        if (asked || step.branch != 1) return;
        asked = true;
        (void)bench::send_command(name, Command::kPause);
      });
  CHECK(result.outcome == db::Outcome::kCompleted);
  CHECK(branches_of(run.store) == Texts{"0.0.0 void", "0.1.0 void", "0.1.1 void", "0.0.1", "0.1.2", "0.2.0"});
}

TEST_CASE("waiting run: with --yes no question is asked, and that is recorded") {
  WaitingRun run;
  run.request.assume_yes = true;
  run.request.recipes = {
      recipe_of("unit = \"psi\"\nturning_points = [0, 4]\nstep = 4\n[prompt]\nbefore = \"mount it\"\n")};
  CHECK(run_small(run.request, run.store).outcome == db::Outcome::kCompleted);
  CHECK(course_of(run.store) == Texts{"prepared -> running", "prompt", "running -> stopping", "safe"});
}

TEST_CASE("waiting run: status and progress while the supply is missing, and until the run has ended") {
  WaitingRun run;
  run.request =
      small_request({{"environment.sensor", "[{quantity = 'supply_bar', unit = 9, address = 20, type = 'f32'}]"}});
  run.request.recipes = {small_recipe(
      "[[suspend]]\nquantity = \"supply_bar\"\ntrip_below = 6\nresume_above = 6.5\nhold_s = 2\ntimeout_s = 600\n")};
  run.request.bench.simulation->plant.faults = {planned_fault(bench::FaultKind::kSupplyLost, 45.0, 8.0, 0.001)};
  Texts seen;  // of the person's thread until it has ended
  const bench::RunResult result =
      run.carry_out([&](const std::string&, const bench::RunStatus& status) { seen.push_back(status.reason); },
                    [](const std::string&, const sequences::Step&) {});
  CHECK(result.outcome == db::Outcome::kCompleted);
  REQUIRE_FALSE(seen.empty());
  for (const std::string& reason : seen) CHECK_THAT(reason, Catch::Contains("supply_bar") && Catch::Contains("0.00"));
  REQUIRE(run.notes.size() == 1);
  CHECK_THAT(run.notes[0], Catch::Contains("run 1") && Catch::Contains("supply_bar"));
  const Texts told = run.reported_events(2);
  REQUIRE(told.size() == 2);
  CHECK((told[0].starts_with("done 1 ") && told[1].starts_with("waiting 1 supply_bar")));
}
