// A run that pauses at the end of each branch, loaded as it is there, on the watchdog of the shipped bench: the module
// must be fed while the safe state is being proved.
#include <catch2/catch.hpp>
#include <thread>

#include "bench/rig/rig.h"
#include "bench/safety/safe_state.h"
#include "tests/bench/run/quick_store.h"
#include "tests/support/live_runs.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::Command;

namespace {

const std::string kLevels =
    "unit = \"psi\"\nturning_points = [0, 60, 50, 60, 0]\nstep = 10\ndwell_s = 2\nrepeats = 1\n"
    "[conditioning]\ncycles = 1\npeak = 60\n";

// Resumes each pause of the run, until the run ends.
void resume_each_pause(const std::string& socket) {
  for (auto live = bench::send_command(socket, Command::kStatus); live;
       live = bench::send_command(socket, Command::kStatus)) {
    if (live->status.state == bench::RunState::kPaused) (void)bench::send_command(socket, Command::kResume);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

}  // namespace

TEST_CASE("control: a run may pause at the end of every branch, whatever its load there") {
  const auto& [recipe, branches] = GENERATE(table<std::string, int>({{kLevels, 4}, {press_text(1), 2}}));
  INFO(recipe);
  QuickStore store;
  bench::RunRequest request = small_request();
  request.recipes = {recipe_of(recipe)};
  request.assume_yes = true;
  std::thread person;
  int asked = 0;
  request.on_step = [&](const sequences::Step& step) {
    if (step.kind == sequences::StepKind::kConditioning || step.branch < asked) return;
    const auto live = live_runs();
    REQUIRE(live.size() == 1);
    CHECK(bench::send_command(live.front().name, Command::kPause));
    ++asked;
    if (!person.joinable()) person = std::thread(resume_each_pause, live.front().name);
  };
  const bench::RunResult result = run_small(request, store);
  if (person.joinable()) person.join();
  CHECK(asked == branches);
  INFO((result.error ? result.error->what() : ""));
  CHECK(result.outcome == db::Outcome::kCompleted);
  int paused = 0;
  for (const db::EventRecord& event : store.events(1))
    paused += event.kind == "state" && event.detail.starts_with("pausing -> paused") ? 1 : 0;
  CHECK(paused == branches);
}

TEST_CASE("safe state: while the array is waited for, the module is fed") {
  bench::Rig rig(small_request().bench);
  rig.open();
  bench::Baseline baseline = bench::baseline_of(rig.array().read(8));
  for (double& counts : baseline) counts -= 20000.0;  // which it never comes down to
  const auto begun = rig.clock().now();
  CHECK(make_safe(rig, baseline).state == db::SafeState::kUnverified);
  CHECK(rig.clock().now() - begun > std::chrono::seconds(5));
  CHECK_NOTHROW(rig.source().keep_alive());
}
