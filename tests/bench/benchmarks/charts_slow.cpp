// `tactbench benchmark charts`: its table holds every case, and its figures are those that the charts promise, within
// the error of few draws; and those of these seeds are as they were recorded.
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "tests/bench/benchmarks/recorded_charts.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// Of 200 draws, in the order in which they are printed.
constexpr RecordedChart kRecorded[] = {
    {"false_normal", 2.5, 5, 5},
    {"false_largest", 9, 16, 14},
    {"false_log_of_largest", 9.5, 4.5, 11},
    {"step_1", 29, 70, 88.5},
    {"step_1_median", 23, 12, 12},
    {"step_2", 83, 100, 100},
    {"step_2_median", 5, 4, 4},
    {"step_3", 98, 100, 100},
    {"step_3_median", 3, 2, 2},
    {"ramp_0.1", 100, 100, 100},
    {"ramp_0.1_median", 22, 18, 16},
    {"ramp_0.5", 100, 100, 100},
    {"ramp_0.5_median", 7, 6, 6},
    {"of_671_false_nights_normal", 0, 1.6667, 0},
    {"of_671_false_periods_normal", 0, 50, 0},
    {"of_671_gross_nights_normal", 0, 0, 0.8333},
    {"of_671_false_nights_largest", 0, 0, 1.6667},
    {"of_671_false_periods_largest", 0, 0, 100},
    {"of_671_gross_nights_largest", 7.5, 49.1667, 58.3333},
    {"of_671_false_nights_log_of_largest", 0, 0, 0},
    {"of_671_false_periods_log_of_largest", 0, 0, 0},
    {"of_671_gross_nights_log_of_largest", 3.3333, 5, 5.8333},
    {"of_671_1_step_2_found", 0, 100, 100},
    {"of_671_1_step_2_false_share", 0, 0, 0},
    {"of_671_1_step_3_found", 0, 100, 100},
    {"of_671_1_step_3_false_share", 0, 0, 0},
    {"of_671_1_step_5_found", 50, 100, 100},
    {"of_671_1_step_5_false_share", 0, 0, 0},
    {"of_671_67_step_2_found", 0, 94.0299, 100},
    {"of_671_67_step_2_false_share", 0, 1.5152, 2.8986},
    {"of_671_67_step_3_found", 55.2239, 100, 100},
    {"of_671_67_step_3_false_share", 1.1905, 4.9215, 2.1846},
    {"of_671_67_step_5_found", 100, 100, 100},
    {"of_671_67_step_5_false_share", 3.5921, 2.1846, 4.9215},
};

}  // namespace

TEST_CASE("benchmark charts: the promised false alarms and shifts found, for every baseline") {
  constexpr int kDraws = 200, kNights = 60 * kDraws / 100;
  std::map<std::string, double> figures;
  const std::vector<bench::Figure> printed = bench::benchmark_charts(kDraws);
  check_charts(printed, kRecorded);
  for (const bench::Figure& figure : printed) CHECK(figures.emplace(figure.name, figure.value).second);
  CHECK(figures.size() == 3 * (3 + 2 * 5 + 3 * 3 + 2 * 2 * 3));
  const auto of = [&](int n, const std::string& name) {
    return figures.at("charts_n" + std::to_string(n) + "_" + name);
  };
  const auto margin = [](double percent) { return 4.0 * std::sqrt(percent * (100.0 - percent) / kDraws); };
  for (const int n : {8, 20, 30}) {
    INFO(n);
    CHECK(of(n, "false_normal") <= 4.6 + margin(4.6));
    CHECK(of(n, "false_normal") >= 1.0);
    CHECK(of(n, "step_2") >= 83.0 - margin(83.0));
    CHECK(of(n, "step_3") > of(n, "step_1"));
    CHECK(of(n, "step_3_median") < of(n, "step_1_median"));
    CHECK(of(n, "ramp_0.1") >= 98.0);
    CHECK(of(n, "ramp_0.5_median") < of(n, "ramp_0.1_median"));
    CHECK(of(n, "of_671_false_nights_normal") <= 5.0);
    CHECK(of(n, "of_671_gross_nights_normal") ==
          Approx(0.67).margin(4.0 * std::sqrt(0.67 * 99.33 / kNights)));  // 671 x 1e-5
    CHECK(of(n, "of_671_67_step_5_found") >= 99.0);
    CHECK(of(n, "of_671_67_step_5_false_share") <= 10.0);
  }
  CHECK(of(8, "step_1") == Approx(33.0).margin(margin(33.0)));  // by a program of another's
  CHECK(of(30, "step_1") >= 75.0);
}
