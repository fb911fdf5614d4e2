// Recipes whose first level is not the pressure at which the conditioning ends, or the repeat before.
#include <fmt/format.h>

#include <catch2/catch.hpp>

#include "tests/bench/run/finished_run.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

struct Row {
  const char* turning_points;
  std::vector<double> levels;  // of a repeat's frames, psi
};

}  // namespace

TEST_CASE("run: a repeat may begin at any level, and fall, rise or stay from there") {
  const Row row = GENERATE(values<Row>({{"[20, 10, 20, 0]", {20, 10, 20, 10, 0}},
                                        {"[20, 10]", {20, 10}},
                                        {"[10, 20]", {10, 20}},
                                        {"[20]\nframes_per_level = 3\nframe_interval_s = 1", {20, 20, 20}}}));
  INFO(row.turning_points);
  bench::RunRequest request = small_request();
  request.recipes = {recipe_of(fmt::format(
      "unit = \"psi\"\nturning_points = {}\nstep = 10\nrepeats = 2\n[conditioning]\ncycles = 1\npeak = 20\n",
      row.turning_points))};
  const FinishedRun run(request);
  const bench::RunResult& result = run.result;
  INFO((result.error ? result.error->what() : ""));
  REQUIRE(result.outcome == db::Outcome::kCompleted);
  std::vector<double> expected = row.levels, read;
  expected.insert(expected.end(), row.levels.begin(), row.levels.end());
  for (const db::BranchRecord& branch : run.store.branches(1)) CHECK_FALSE(branch.is_void);
  for (const db::FrameRecord& frame : run.store.frames(1)) {
    read.push_back(frame.setpoint_psi);
    CHECK(frame.reference_psi == Approx(frame.setpoint_psi).margin(0.5));
    CHECK(frame.flags.empty());
  }
  CHECK(read == expected);
}
