// Defective taxels and swapped lines.
#include "analysis/statistics/sensor/health.h"
#include "tests/analysis/support/sensor_models.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

using namespace tactbench::analysis;

namespace {

// 2 x 3 taxels over 0 - 60 - 0 psi: well, dead, stuck, saturated, noisy, weak.
Dataset ailing_dataset() {
  Dataset dataset;
  dataset.rows = 2;
  dataset.columns = 3;
  Repeat repeat;
  for (const double p : {0.0, 30.0, 60.0, 30.0, 0.0}) {
    repeat.steps.push_back({p, p});
    for (const double v : {p / 20.0, 0.001, 1.5 + 0.0001 * p, p > 50.0 ? 5.0 : p / 10.0, p / 20.0, 0.06 * p / 60.0})
      repeat.volts.push_back(v);
  }
  dataset.sequences = {{"loop", {repeat}}};
  dataset.noise_v = {0.001, 0.001, 0.001, 0.001, 0.0041, 0.001};
  dataset.at_limit = {false, false, false, true, false, false};
  return dataset;
}

std::string states_of(const Health& health, int taxel) {
  std::string states;
  for (const TaxelHealth& finding : health.findings)
    if (finding.taxel == taxel) states += finding.state + " ";
  return states;
}

}  // namespace

TEST_CASE("each defect is reported with name, reason and consequence") {
  const Health health = health_of(ailing_dataset(), {}, true);
  CHECK(states_of(health, 0).empty());
  CHECK(states_of(health, 1) == "dead ");
  CHECK(states_of(health, 2) == "stuck ");
  CHECK(states_of(health, 3) == "saturated ");
  CHECK(states_of(health, 4) == "noisy ");  // 4.1 times the median
  CHECK(states_of(health, 5).empty());      // spans 60 mV, more than 50
  CHECK(health.count("dead") == 1);
  for (const TaxelHealth& finding : health.findings) {
    CHECK(finding.excluded == (finding.state != "noisy"));
    CHECK_THAT(finding.reason, Catch::Contains(finding.state == "noisy" ? "4.10 mV" : "output "));
  }
  CHECK(health.low_v[3] == 0.0);
  CHECK(health.high_v[3] == 5.0);
}

TEST_CASE("a run that presses on a part of the array calls no silent taxel dead") {
  const Health health = health_of(ailing_dataset(), {}, false);
  CHECK(health.count("dead") == 0);
  CHECK(health.count("stuck") == 0);
  CHECK(health.count("saturated") == 1);
}

TEST_CASE("the fit's taxel states take precedence, and without scans noise is not judged") {
  Dataset dataset = ailing_dataset();
  dataset.noise_v.assign(6, 0.0);
  SensorModel fit;
  fit.taxels.resize(6);
  for (ModelTaxel& taxel : fit.taxels) taxel.status = TaxelStatus::kFitted;
  const std::vector<double> ends{0.0, 60.0}, volts{0.0, 2.0};
  const PatternCurve loop(ends, volts, 0.0, 2.0);
  fit.taxels[0] = by_hand::elam_taxel(loop, loop);
  fit.taxels[0].status = TaxelStatus::kUnfit;
  fit.taxels[0].fit.mean_error = 0.5;
  const Health health = health_of(dataset, fit, true);
  REQUIRE(health.findings.size() == 1);
  CHECK(health.findings[0].state == "unfit");
  CHECK_THAT(health.findings[0].reason, Catch::Contains("25.0 %"));
  CHECK(health.noise_v.empty());
  CHECK(std::isnan(health.median_noise_v));
  fit.taxels.pop_back();
  CHECK_THROWS_AS(health_of(dataset, fit, true), std::invalid_argument);
}

TEST_CASE("swapped rows and columns are found, a changed gain and noise are not") {
  const int rows = 16, columns = 12;
  std::mt19937 random(11);
  std::vector<double> before;
  for (int i = 0; i < rows * columns; ++i) before.push_back(0.5 + static_cast<double>(random()) / 4294967296.0);
  const auto at = [&](std::vector<double>& frame, int row, int column) -> double& {
    return frame[static_cast<std::size_t>(row * columns + column)];
  };
  std::vector<double> now = before;
  for (std::size_t i = 0; i < now.size(); ++i) now[i] *= 1.2 + 0.01 * std::sin(static_cast<double>(i));
  CHECK(swapped_lines(rows, columns, now, before).empty());
  for (int column = 0; column < columns; ++column) std::swap(at(now, 1, column), at(now, 4, column));
  const auto swaps = swapped_lines(rows, columns, now, before);
  REQUIRE(swaps.size() == 1);
  CHECK(swaps[0].rows);
  CHECK(swaps[0].first == 1);
  CHECK(swaps[0].second == 4);
  CHECK(swaps[0].exchanged > 0.95);
  // A taxel that stands still hides the exchange, one that is known to do so does not.
  at(now, 4, 7) = 40.0;
  CHECK(swapped_lines(rows, columns, now, before).empty());
  at(now, 4, 7) = std::numeric_limits<double>::quiet_NaN();
  REQUIRE(swapped_lines(rows, columns, now, before).size() == 1);
  CHECK(swapped_lines(rows, columns, now, before)[0].exchanged > 0.95);
  for (int column = 0; column < 5; ++column) at(now, 4, column) = std::numeric_limits<double>::quiet_NaN();
  CHECK(swapped_lines(rows, columns, now, before).empty());  // six are left: too few to tell
  now = before;
  for (int row = 0; row < rows; ++row) std::swap(at(now, row, 0), at(now, row, 3));
  const auto columns_swapped = swapped_lines(rows, columns, now, before);
  REQUIRE(columns_swapped.size() == 1);
  CHECK_FALSE(columns_swapped[0].rows);
  CHECK(columns_swapped[0].second == 3);
  CHECK(swapped_lines(2, 3, {1, 2, 3, 3, 2, 1}, {3, 2, 1, 1, 2, 3}).empty());  // too short to tell
}
