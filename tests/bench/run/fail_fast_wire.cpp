// A recipe's [limits]: a run that cannot be of use ends at the first frame of the highest level, and not later.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cstdint>
#include <vector>

#include "bench/rig/rig.h"
#include "bench/simulation/plant.h"
#include "tests/bench/run/finished_run.h"
#include "tests/bench/run/quick_store.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

struct Ended {
  bench::RunResult result;
  std::vector<double> levels;    // of its frames, psi
  std::vector<double> mean_v{};  // of all taxels, of each frame
};

double mean_counts(const db::FrameRecord& frame) {
  double sum = 0.0;
  for (const std::uint16_t counts : frame.counts) sum += counts;
  return sum / static_cast<double>(frame.counts.size());
}

Ended run_with(const std::string& limits, const std::string& defects) {
  QuickStore store;
  const std::vector<sequences::Override> defective = {{"simulation.defect", defects}};
  bench::RunRequest request = small_request(defects.empty() ? std::vector<sequences::Override>() : defective);
  request.overrides.clear();
  request.recipes = {
      recipe_of("unit = \"psi\"\nturning_points = [0, 60, 0]\nstep = 20\nrepeats = 2\n[limits]\n" + limits)};
  double volts_per_count = 0.0;
  request.on_rig = [&](bench::Rig& rig, bench::RigMoment) {
    if (rig.has_array()) volts_per_count = rig.array().volts_per_count().value();
  };
  Ended ended{run_small(request, store), {}};
  for (const db::FrameRecord& frame : store.frames(1)) {
    ended.levels.push_back(frame.setpoint_psi);
    ended.mean_v.push_back(mean_counts(frame) * volts_per_count);
  }
  return ended;
}

const std::string kSound;
const std::string kTwoDead = "[{kind=\"dead\",row=0,column=0},{kind=\"dead\",row=15,column=15}]";

void check_ends_at_the_peak(const Ended& ended, int dead) {
  REQUIRE(ended.result.error);
  CHECK(ended.result.error->id() == "TB-RUN-HOPELESS");
  CHECK(ended.result.error->code() == bench::ExitCode::kCriterionFailed);
  CHECK_THAT(ended.result.error->what(), Catch::Contains("60 psi") && Catch::Contains(fmt::format(" {} taxels", dead)));
  CHECK(ended.result.outcome == db::Outcome::kFailed);
  CHECK(ended.result.safe == db::SafeState::kVerified);
  CHECK(ended.levels == std::vector<double>{0, 20, 40, 60});
}

void check_goes_on(const Ended& ended) {
  INFO((ended.result.error ? ended.result.error->what() : ""));
  CHECK(ended.result.outcome == db::Outcome::kCompleted);
  CHECK(ended.levels.size() == 14);
}

}  // namespace

TEST_CASE("run: with more dead taxels than its recipe allows it ends at the first peak") {
  check_ends_at_the_peak(run_with("most_dead_taxels = 0\n", kTwoDead), 2);
  check_ends_at_the_peak(run_with("most_dead_taxels = 1\n", kTwoDead), 2);
  check_goes_on(run_with("most_dead_taxels = 2\n", kTwoDead));
  check_goes_on(run_with("most_dead_taxels = 0\n", kSound));
  check_goes_on(run_with("most_dead_taxels = -1\n", kTwoDead));
}

TEST_CASE("run: with a weaker array than its recipe asks for it ends at the first peak") {
  const Ended weak = run_with("least_response_v = 4.5\n", kSound);
  check_ends_at_the_peak(weak, 0);
  REQUIRE(weak.mean_v.size() == 4);
  CHECK(weak.mean_v[0] > 0.015);  // which the response does not hold
  const double response = weak.mean_v[3] - weak.mean_v[0];
  CHECK(response > 0.3);
  check_goes_on(run_with(fmt::format("least_response_v = {}\n", response - 0.03), kSound));
  check_ends_at_the_peak(run_with(fmt::format("least_response_v = {}\n", response + 0.03), kSound), 0);
}

TEST_CASE("run: the array is judged at the first peak alone, whatever becomes of it") {
  // At 60 psi a row that was read at 0 psi from then on is dead.
  bench::RunRequest request = small_request();
  request.recipes = {recipe_of(
      "unit = \"psi\"\nturning_points = [0, 60, 0]\nstep = 20\nrepeats = 2\n[limits]\nmost_dead_taxels = 3\n")};
  int steps = 0;
  double begins_s = 0.0;
  bench::Rig* rig = nullptr;
  request.on_rig = [&](bench::Rig& made, bench::RigMoment) { rig = &made; };
  request.on_step = [&](const sequences::Step& step) {
    ++steps;
    if (step.repeat != 1 || step.branch != 0 || begins_s > 0.0) return;
    begins_s = devices::in_seconds(rig->clock().now());
    rig->plant()->inject(bench::FaultKind::kRowStuck, 2.0);
  };
  const FinishedRun run(request);
  const bench::RunResult& result = run.result;
  INFO((result.error ? result.error->what() : ""));
  CHECK(begins_s > 0.0);
  CHECK(run.store.events(1).front().time_ns == 0);
  CHECK(result.outcome == db::Outcome::kCompleted);
  int flagged = 0;
  for (const db::FrameRecord& frame : run.store.frames(1))
    flagged += frame.flags.find("row-stuck") != std::string::npos ? 1 : 0;
  CHECK(flagged >= 3);
}
