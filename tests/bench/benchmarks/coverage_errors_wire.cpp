// `benchmark coverage`: which readings count, how far they are from the truth, and whether U holds them. Not a unit
// test: readings are made by several threads.
#include <catch2/catch.hpp>
#include <cmath>
#include <utility>
#include <vector>

#include "analysis/statistics/figures/streams.h"
#include "bench/benchmarks/coverage.h"
#include "bench/benchmarks/synthetic_array.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

// Turning points of Table 1, in psi.
const std::vector<std::vector<int>> kTurns = {
    {0, 60, 0, 50, 0, 40, 0, 30, 0, 20, 0, 10, 0},
    {0, 60, 10, 60, 0, 60, 20, 60, 0, 60, 30, 60, 0, 60, 40, 60, 0, 60, 50, 60, 0}};

struct KnownStep {
  bool full = false, up = true;
};
std::vector<KnownStep> known_steps(const std::vector<int>& turns) {
  std::vector<KnownStep> steps{{true, true}};  // the first one belongs to the first branch
  for (std::size_t b = 1; b < turns.size(); ++b) {
    const int way = std::abs(turns[b] - turns[b - 1]);
    steps.insert(steps.end(), static_cast<std::size_t>(way / 2), {way == 60, turns[b] > turns[b - 1]});
  }
  return steps;
}

}  // namespace

TEST_CASE("benchmark coverage: readings on full sweeps and on inner branches, against the truth of their own frame") {
  const analysis::Dataset dataset = synthetic_dataset(1, 2, 2);
  const analysis::SensorModel fit = analysis::fit_array(dataset);
  std::vector<std::vector<double>> readings(2);  // by taxel, in the order of the frames
  analysis::compensate_in_order(dataset, fit, 1, [&](std::size_t taxel) {
    return [&, taxel](std::size_t, std::size_t, std::size_t, const analysis::Compensated& now) {
      readings[taxel].push_back(now.pressure_psi);
    };
  });
  REQUIRE(readings[0].size() == 2 * (211 + 451));
  REQUIRE(readings[1].size() == readings[0].size());

  // The truth of frame n is n % 7 eighths of a psi below what the first taxel read.
  KnownRun run;
  run.data = dataset;
  for (std::size_t n = 0; n < readings[0].size(); ++n)
    run.chamber_psi.push_back(readings[0][n] - 0.125 * static_cast<double>(n % 7));
  // An eighth is known of each reading; U is 0.45 psi going up and 0.2 psi going down.
  analysis::ConditionUncertainty stated;
  stated.pressure_psi = {0.0, 60.0, 0.0, 60.0};
  stated.up = {true, true, false, false};
  stated.expanded_psi = {0.45, 0.45, 0.45, 0.45, 0.2, 0.2, 0.2, 0.2};
  stated.error_psi = std::vector<double>(8, 0.125);

  for (const bool full : {true, false}) {
    INFO((full ? "full sweeps" : "inner branches"));
    Covered covered;
    covered.inside = 1000.0;  // of other runs
    covered.errors = covered.expanded = {9.0};
    add_errors(run, fit, stated, full, covered);
    std::vector<double> errors{9.0}, expanded{9.0};
    double inside = 1000.0;
    for (std::size_t taxel = 0; taxel < 2; ++taxel) {
      std::size_t frame = 0;
      for (const std::vector<int>& turns : kTurns)
        for (int repeat = 0; repeat < 2; ++repeat)
          for (const KnownStep& step : known_steps(turns)) {
            const double error = std::abs(readings[taxel][frame] - 0.125 - run.chamber_psi[frame]);
            ++frame;
            if (step.full != full) continue;
            errors.push_back(error);
            expanded.push_back(step.up ? 0.45 : 0.2);
            inside += error <= expanded.back() ? 1.0 : 0.0;
          }
    }
    REQUIRE(covered.errors.size() == errors.size());
    REQUIRE(covered.expanded.size() == expanded.size());
    for (std::size_t i = 0; i < errors.size(); ++i) {
      INFO("reading " << i);
      CHECK(covered.errors[i] == Approx(errors[i]).margin(1e-12));
      CHECK(covered.expanded[i] == Approx(expanded[i]));
    }
    CHECK(covered.inside == inside);
    CHECK(covered.not_valid == 0.0);
    // Of the first taxel's readings the errors are 1, 0, 1, 2, 3, 4, 5 eighths in turn.
    CHECK(inside > 1000.0);
    CHECK(inside < 1000.0 + static_cast<double>(errors.size()) - 1.0);
  }
}
