// Runs that wait for a person: what a client of the run is told meanwhile, what the person is told, what is done for
// --on-event, and what the run writes down of it. How long it waits differs from time to time, so no time is compared.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "bench/run/control/client_words.h"
#include "bench/run/control/run_connection.h"
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

// Asks a run until it ends, and acts once on each question and on each pause without one.
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
      if (status.state == RunState::kPaused && (status.question.empty() || status.question_id > answered)) {
        answered = std::max(answered, status.question_id);
        act(name, status);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }
  std::thread thread_;
};

std::string waiting_line(const bench::RunStatus& status) {
  return fmt::format(
      "{}: {} | {} | question {} | step {} of {}, {} frames, {:.1f} ({:.1f} to {:.1f}) s and {} prompts left",
      to_string(status.state), status.reason, status.phase, status.question_id, status.step, status.steps,
      status.frames, status.left_s, status.left_low_s, status.left_high_s, status.prompts_left);
}

// How long it waited, who asked and in which process differ.
std::string without_what_differs(const std::string& text) {
  const std::string same = std::regex_replace(text, std::regex("(after|for) [0-9]+ s"), "$1 N s");
  return std::regex_replace(same, std::regex("[^ ]+ \\(pid [0-9]+\\)"), "NAME (pid N)");
}

Texts lines_heard(const std::string& text) {
  Texts lines;
  std::istringstream rest(text);
  for (std::string line; std::getline(rest, line);) lines.push_back(without_what_differs(line));
  return lines;
}

Texts written_by(const db::RunStore& store) {
  Texts written;
  for (const db::EventRecord& event : store.events(1)) {
    if (event.kind != "state" && event.kind != "safe" && event.kind != "way-back" && event.kind != "prompt") continue;
    const std::string id = event.id.empty() ? "" : " " + event.id;
    const std::string detail = event.detail.substr(0, event.detail.find(", verified ("));  // its readings differ
    written.push_back(event.kind + id + ": " + without_what_differs(detail));
  }
  return written;
}

// Repeat, branch, attempt, and why it is void.
Texts branches_of(const db::RunStore& store) {
  Texts branches;
  for (const db::BranchRecord& branch : store.branches(1))
    branches.push_back(fmt::format("{}.{}.{} {}", branch.repeat, branch.ordinal, branch.attempt,
                                   without_what_differs(branch.void_reason)));
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
  // The commands for the events run in the background, one beside the other.
  [[nodiscard]] Texts events_told(std::size_t count) const {
    const auto told = [&] { return lines_heard(read_file(folder.path("events"))); };
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

TEST_CASE("waiting run: two questions and a pause: what is asked, told, shown and written") {
  WaitingRun run;
  run.request.recipes = {
      recipe_of("unit = \"psi\"\nturning_points = [0, 8, 0]\nstep = 4\n[prompt]\nbefore = \"mount it\"\n"
                "[conditioning]\ncycles = 1\npeak = 8\n"),
      recipe_of("unit = \"psi\"\nturning_points = [0, 4]\nstep = 4\n[prompt]\nbefore = \"turn it\"\n")};
  const bench::TimeEstimate estimate(run.request.recipes, sequences::compile(run.request.recipes),
                                     time_model(run.request.bench));
  run.request.estimate = &estimate;
  Texts seen;
  const bench::RunResult result = run.carry_out(
      [&](const std::string& name, const bench::RunStatus& status) {
        if (status.question.empty()) {
          (void)bench::send_command(name, Command::kResume);
          return;
        }
        seen.push_back(waiting_line(status));
        const std::string words = status.question_id == 1 ? bench::answer_words(1, "all done", "bob") : "resume";
        bench::RunConnection connection(name, words);
        (void)comes_true([&] { return connection.newest().has_value() || !connection.open(); });
      },
      [&](const std::string& name, const sequences::Step& step) {
        if (step.kind == sequences::StepKind::kMeasure && step.sequence == 0 && step.ordinal == 0)
          (void)bench::send_command(name, Command::kPause);
      });
  CHECK(result.outcome == db::Outcome::kCompleted);
  CHECK(result.waiting_seconds > 0.5);  // three waits of at least 0.2 s
  CHECK(seen == Texts{"paused: operator: mount it | waiting for an answer: mount it | question 1 | step 0 of 11, 0 "
                      "frames, 25.7 (24.2 to 30.4) s and 2 prompts left",
                      "paused: operator: turn it | waiting for an answer: turn it | question 2 | step 8 of 11, 5 "
                      "frames, 5.5 (5.1 to 6.8) s and 1 prompts left"});
  CHECK(run.notes == Texts{"mount it", "  when done: `tactbench resume 1`",
                           "answered by bob, through NAME (pid N): all done",
                           "pausing at the end of this branch; Ctrl-C (or `tactbench stop`) ends the run now",
                           "run 1 is paused, vented: `tactbench resume 1` continues, `tactbench stop 1` ends it",
                           "turn it", "  when done: `tactbench resume 1`", "answered by NAME (pid N)"});
  CHECK(written_by(run.store) ==
        Texts{"state: prepared -> running: devices open, chamber unloaded", "safe verified: for the operator: vented",
              "state: running -> pausing: for the operator", "state: pausing -> paused: operator: mount it",
              "state: paused -> running: answered by bob, through NAME (pid N), \"all done\": mount it",
              "state: running -> pausing: asked by NAME (pid N)", "safe verified: to pause: vented",
              "state: pausing -> paused: asked by NAME (pid N)",
              "state: paused -> running: resumed by NAME (pid N) after N s",
              "way-back: conditioned again, then the turning points before branch 1 of repeat 0",
              "safe verified: for the operator: vented", "state: running -> pausing: for the operator",
              "state: pausing -> paused: operator: turn it",
              "state: paused -> running: answered by NAME (pid N): turn it",
              "state: running -> stopping: all steps done", "safe verified: vented"});
  CHECK(run.events_told(4) == Texts{"done 1 all steps done", "waiting 1 mount it",
                                    "waiting 1 paused: asked by NAME (pid N)", "waiting 1 turn it"});
}

TEST_CASE("waiting run: after a rest longer than its recipe allows the whole repeat is done again, no other") {
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
  CHECK(branches_of(run.store) ==
        Texts{"0.0.0 ", "0.1.0 ", "1.0.0 the sensor rested for N s: the repeat is done again", "1.0.1 ", "1.1.0 "});
}

TEST_CASE("waiting run: after a long rest also the branches that an earlier process has done are done again") {
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
  CHECK(branches_of(run.store) ==
        Texts{"0.0.0 the sensor rested for N s: the repeat is done again", "0.1.0 half done when the run ended",
              "0.1.1 the sensor rested for N s: the repeat is done again", "0.0.1 ", "0.1.2 ", "0.2.0 "});
}

TEST_CASE("waiting run: with --yes no question is asked, and that is written down") {
  WaitingRun run;
  run.request.assume_yes = true;
  run.request.recipes = {
      recipe_of("unit = \"psi\"\nturning_points = [0, 4]\nstep = 4\n[prompt]\nbefore = \"mount it\"\n")};
  CHECK(run_small(run.request, run.store).outcome == db::Outcome::kCompleted);
  CHECK(written_by(run.store) == Texts{"state: prepared -> running: devices open, chamber unloaded",
                                       "prompt: mount it (answered by --yes)",
                                       "state: running -> stopping: all steps done", "safe verified: vented"});
}

TEST_CASE("waiting run: what is told and shown while the supply is away, and that the run is done") {
  WaitingRun run;
  run.request =
      small_request({{"environment.sensor", "[{quantity = 'supply_bar', unit = 9, address = 20, type = 'f32'}]"}});
  run.request.recipes = {small_recipe(
      "[[suspend]]\nquantity = \"supply_bar\"\ntrip_below = 6\nresume_above = 6.5\nhold_s = 2\ntimeout_s = 600\n")};
  run.request.bench.simulation->plant.faults = {planned_fault(bench::FaultKind::kSupplyLost, 45.0, 8.0, 0.001)};
  Texts seen;  // of the thread until it has ended
  std::thread onlooker;
  const bench::RunResult result = run.carry_out([](const std::string&, const bench::RunStatus&) {},
                                                [&](const std::string& name, const sequences::Step&) {
                                                  if (onlooker.joinable()) return;
                                                  onlooker = std::thread([&seen, name] {
                                                    for (auto live = bench::send_command(name, Command::kStatus); live;
                                                         live = bench::send_command(name, Command::kStatus)) {
                                                      const bench::RunStatus& status = live->status;
                                                      if (status.state == RunState::kSuspended)
                                                        seen.push_back(status.reason + " | " + status.phase);
                                                      std::this_thread::sleep_for(std::chrono::milliseconds(2));
                                                    }
                                                  });
                                                });
  onlooker.join();
  CHECK(result.outcome == db::Outcome::kCompleted);
  const std::string away = "supply_bar is 0.00, below 6";
  CHECK(std::ranges::count(seen, away + " | waiting, vented: " + away) > 0);
  CHECK(run.notes == Texts{"run 1 waits, vented: " + away});
  CHECK(run.events_told(2) == Texts{"done 1 all steps done", "waiting 1 " + away});
}
