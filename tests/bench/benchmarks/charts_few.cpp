// `benchmark charts` with few draws and nights of 70 figures: every case, each with its own seed, as it was recorded.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/bench/benchmarks/recorded_charts.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// Of 300 draws and three periods, in the order in which they are printed.
constexpr RecordedChart kFew[] = {
    {"false_normal", 2.66667, 5.33333, 6},
    {"false_largest", 8.33333, 14.3333, 16.6667},
    {"false_log_of_largest", 7.66667, 4.33333, 9},
    {"step_1", 29.6667, 70.3333, 86},
    {"step_1_median", 17, 12, 13},
    {"step_2", 82.6667, 100, 100},
    {"step_2_median", 6, 4, 4},
    {"step_3", 98, 100, 100},
    {"step_3_median", 3, 2, 2},
    {"ramp_0.1", 100, 100, 100},
    {"ramp_0.1_median", 22, 18, 16},
    {"ramp_0.5", 100, 100, 100},
    {"ramp_0.5_median", 7, 6, 6},
    {"of_70_false_nights_normal", 0, 0, 0},
    {"of_70_false_periods_normal", 0, 0, 0},
    {"of_70_gross_nights_normal", 0, 0, 0},
    {"of_70_false_nights_largest", 0, 1.11111, 2.22222},
    {"of_70_false_periods_largest", 0, 66.6667, 66.6667},
    {"of_70_gross_nights_largest", 0.555556, 7.77778, 8.33333},
    {"of_70_false_nights_log_of_largest", 1.11111, 0, 0},
    {"of_70_false_periods_log_of_largest", 33.3333, 0, 0},
    {"of_70_gross_nights_log_of_largest", 0.555556, 0, 0.555556},
    {"of_70_1_step_2_found", 0, 100, 100},
    {"of_70_1_step_2_false_share", 0, 0, 0},
    {"of_70_1_step_3_found", 0, 100, 100},
    {"of_70_1_step_3_false_share", 0, 0, 0},
    {"of_70_1_step_5_found", 100, 100, 100},
    {"of_70_1_step_5_false_share", 16.6667, 0, 0},
    {"of_70_67_step_2_found", 51.7413, 100, 100},
    {"of_70_67_step_2_false_share", 0, 0.490196, 0.490196},
    {"of_70_67_step_3_found", 99.5025, 100, 100},
    {"of_70_67_step_3_false_share", 0, 0, 0.490196},
    {"of_70_67_step_5_found", 100, 100, 100},
    {"of_70_67_step_5_false_share", 0, 0, 0.490196},
};

}  // namespace

TEST_CASE("benchmark charts: shifts found and false reports of every case, as they were recorded") {
  check_charts(bench::benchmark_charts(300, 70), kFew);
}

TEST_CASE("benchmark charts: fewer than a hundred draws make one period, and nights have 671 figures") {
  const std::vector<bench::Figure> figures = bench::benchmark_charts(1, 70);
  for (const bench::Figure& figure : figures) {
    INFO(figure.name);
    if (figure.name.ends_with("_median")) continue;
    if (figure.name.find("false_periods") != std::string::npos) CHECK((figure.value == 0.0 || figure.value == 100.0));
    CHECK(figure.value <= 100.0);
  }
  CHECK(bench::kNightFigures == 671);
}
