// `tactbench benchmark charts`: its table holds every case, and its figures are those that the charts promise, within
// the error of few draws.
#include "bench/benchmarks/charts.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <string>

using namespace tactbench;

TEST_CASE("benchmark charts: the promised false alarms and shifts found, for every baseline") {
  constexpr int kDraws = 200, kNights = 60 * kDraws / 100;
  std::map<std::string, double> figures;
  for (const bench::Figure& figure : bench::benchmark_charts(kDraws)) {
    CHECK(figures.emplace(figure.name, figure.value).second);
    CHECK(figure.unit == (figure.name.ends_with("_median") ? "runs" : "%"));
  }
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
