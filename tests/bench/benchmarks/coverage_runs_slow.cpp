// `benchmark coverage` on four taxels and short runs: shares, U and half-widths of each calibration and model as they
// were recorded.
#include <catch2/catch.hpp>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "bench/benchmarks/coverage.h"
#include "tests/bench/benchmarks/short_runs.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

// In the order in which they are printed.
constexpr std::pair<const char*, double> kRecordedCoverage[] = {
    {"paper_production_dynamic_full_sweeps", 97.54},
    {"paper_production_dynamic_full_sweeps_median_u", 0.2274},
    {"paper_production_dynamic_full_sweeps_half_width_95", 1.518},
    {"paper_production_dynamic_held", 93.75},
    {"paper_production_dynamic_held_median_u", 1.988},
    {"paper_production_dynamic_held_half_width_95", 2.796},
    {"paper_production_dynamic_inner_branches", 95},
    {"paper_production_dynamic_inner_branches_median_u", 1.055},
    {"paper_production_dynamic_inner_branches_half_width_95", 1.863},
    {"paper_production_dynamic_month_later", 91.96},
    {"paper_production_dynamic_month_later_median_u", 0.9832},
    {"paper_production_dynamic_month_later_half_width_95", 3.115},
    {"paper_production_dynamic_other_dwell", 92.19},
    {"paper_production_dynamic_other_dwell_median_u", 0.771},
    {"paper_production_dynamic_other_dwell_half_width_95", 3.131},
    {"paper_production_dynamic_other_temperature", 90.62},
    {"paper_production_dynamic_other_temperature_median_u", 0.8143},
    {"paper_production_dynamic_other_temperature_half_width_95", 2.619},
    {"paper_production_dynamic_random_reversals", 94.64},
    {"paper_production_dynamic_random_reversals_median_u", 1.638},
    {"paper_production_dynamic_random_reversals_half_width_95", 2.85},
    {"paper_production_dynamic_remounted_not_valid", 1},
    {"paper_production_elam_full_sweeps", 97.54},
    {"paper_production_elam_full_sweeps_median_u", 0.3446},
    {"paper_production_elam_full_sweeps_half_width_95", 0.4262},
    {"paper_production_elam_held", 83.33},
    {"paper_production_elam_held_median_u", 0.8264},
    {"paper_production_elam_held_half_width_95", 1.806},
    {"paper_production_elam_inner_branches", 96.25},
    {"paper_production_elam_inner_branches_median_u", 1.156},
    {"paper_production_elam_inner_branches_half_width_95", 1.723},
    {"paper_production_elam_month_later", 92.41},
    {"paper_production_elam_month_later_median_u", 0.7696},
    {"paper_production_elam_month_later_half_width_95", 2.465},
    {"paper_production_elam_other_dwell", 93.23},
    {"paper_production_elam_other_dwell_median_u", 0.7947},
    {"paper_production_elam_other_dwell_half_width_95", 1.98},
    {"paper_production_elam_other_temperature", 92.97},
    {"paper_production_elam_other_temperature_median_u", 0.5028},
    {"paper_production_elam_other_temperature_half_width_95", 2.435},
    {"paper_production_elam_random_reversals", 91.07},
    {"paper_production_elam_random_reversals_median_u", 0.9214},
    {"paper_production_elam_random_reversals_half_width_95", 1.513},
    {"paper_production_elam_remounted", 82.73},
    {"paper_production_elam_remounted_median_u", 1.39},
    {"paper_production_elam_remounted_half_width_95", 2.743},
    {"paper_table_1_dynamic_full_sweeps", 97.54},
    {"paper_table_1_dynamic_full_sweeps_median_u", 0.4314},
    {"paper_table_1_dynamic_full_sweeps_half_width_95", 1.855},
    {"paper_table_1_dynamic_held", 91.67},
    {"paper_table_1_dynamic_held_median_u", 1.312},
    {"paper_table_1_dynamic_held_half_width_95", 2.374},
    {"paper_table_1_dynamic_inner_branches", 96.25},
    {"paper_table_1_dynamic_inner_branches_median_u", 1.075},
    {"paper_table_1_dynamic_inner_branches_half_width_95", 2.625},
    {"paper_table_1_dynamic_month_later", 92.41},
    {"paper_table_1_dynamic_month_later_median_u", 1.166},
    {"paper_table_1_dynamic_month_later_half_width_95", 2.582},
    {"paper_table_1_dynamic_other_dwell", 93.75},
    {"paper_table_1_dynamic_other_dwell_median_u", 1.075},
    {"paper_table_1_dynamic_other_dwell_half_width_95", 2.589},
    {"paper_table_1_dynamic_other_temperature", 94.53},
    {"paper_table_1_dynamic_other_temperature_median_u", 1.114},
    {"paper_table_1_dynamic_other_temperature_half_width_95", 3.806},
    {"paper_table_1_dynamic_random_reversals", 92.86},
    {"paper_table_1_dynamic_random_reversals_median_u", 1.146},
    {"paper_table_1_dynamic_random_reversals_half_width_95", 2.369},
    {"paper_table_1_dynamic_remounted_not_valid", 1},
    {"paper_table_1_elam_full_sweeps", 95.9},
    {"paper_table_1_elam_full_sweeps_median_u", 0.3813},
    {"paper_table_1_elam_full_sweeps_half_width_95", 0.633},
    {"paper_table_1_elam_held", 83.33},
    {"paper_table_1_elam_held_median_u", 0.8729},
    {"paper_table_1_elam_held_half_width_95", 1.798},
    {"paper_table_1_elam_inner_branches", 95.62},
    {"paper_table_1_elam_inner_branches_median_u", 1.165},
    {"paper_table_1_elam_inner_branches_half_width_95", 1.711},
    {"paper_table_1_elam_month_later", 93.3},
    {"paper_table_1_elam_month_later_median_u", 0.8717},
    {"paper_table_1_elam_month_later_half_width_95", 2.571},
    {"paper_table_1_elam_other_dwell", 92.19},
    {"paper_table_1_elam_other_dwell_median_u", 0.8995},
    {"paper_table_1_elam_other_dwell_half_width_95", 1.995},
    {"paper_table_1_elam_other_temperature", 93.75},
    {"paper_table_1_elam_other_temperature_median_u", 0.6849},
    {"paper_table_1_elam_other_temperature_half_width_95", 2.453},
    {"paper_table_1_elam_random_reversals", 94.64},
    {"paper_table_1_elam_random_reversals_median_u", 1.002},
    {"paper_table_1_elam_random_reversals_half_width_95", 1.506},
    {"paper_table_1_elam_remounted", 83.86},
    {"paper_table_1_elam_remounted_median_u", 1.573},
    {"paper_table_1_elam_remounted_half_width_95", 2.778},
};

}  // namespace

TEST_CASE("benchmark coverage: each calibration, model and use of a sensor, from short runs, as it was recorded") {
  const tests::TemporaryFolder folder;
  tests::ShortRuns runs(2);
  CoverageOptions options;
  options.sensor_seeds = {51};
  options.harsh = false;
  const std::vector<Figure> figures = benchmark_coverage(options, folder.path(), runs.in_place());
  CHECK(runs.asked.size() == 3 + 48 + 2 * 4);
  REQUIRE(figures.size() == std::size(kRecordedCoverage));
  for (std::size_t i = 0; i < figures.size(); ++i) {
    CHECK(figures[i].name == std::string("coverage_") + kRecordedCoverage[i].first);
    INFO(figures[i].name);
    CHECK(figures[i].value == Approx(kRecordedCoverage[i].second).epsilon(2e-3));
  }
}
