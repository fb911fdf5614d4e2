// The seating check where a figure meets its limit exactly, by limits and responses that are binary fractions; and the
// drift's verdicts where what is left is just what is tolerated.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "analysis/models/monotone.h"
#include "analysis/statistics/sensor/drift.h"
#include "analysis/statistics/sensor/seating.h"
#include "analysis/statistics/sensor/seating_lines.h"
#include "tests/analysis/support/bits.h"

using namespace tactbench::analysis;
using to_the_bit::just_above;
using to_the_bit::just_below;

namespace {

using ResponseAt = std::function<double(int row, int column)>;

SeatingFrames responding(int rows, int columns, const ResponseAt& response) {
  SeatingFrames frames{8.0, {}, {}};
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      frames.unloaded_v.push_back(0.25);
      frames.loaded_v.push_back(0.25 + response(row, column));
    }
  return frames;
}

std::string kinds_of(const SeatingResult& result) {
  std::string all;
  for (const SeatingFinding& finding : result.findings)
    all += (all.empty() ? "" : ", ") + finding.verdict + " " + finding.kind;
  return all;
}

SeatingResult alone(const ResponseAt& response, const SeatingOptions& options) {
  return check_seating(8, 8, responding(8, 8, response), std::nullopt, options);
}

// Row 5, or another, answers by `volts`, all others by 1 V.
ResponseAt one_row(double volts, int which = 5) {
  return [=](int row, int) { return row == which ? volts : 1.0; };
}

constexpr double kLittle = 0x1p-30;

double column_halves(int column) { return column < 4 ? 1.0 : -1.0; }
double column_stripes(int column) { return column % 2 == 0 ? 1.0 : -1.0; }

}  // namespace

TEST_CASE("seating, exactly: a taxel answers by the least response, now and at the last seating") {
  SeatingOptions options;
  options.least_response_v = 0.125;
  options.least_spread = 10.0;  // patterns are not compared
  const auto three = [](double volts) {
    return [=](int row, int column) { return row == column && row < 3 ? volts : 1.0; };
  };
  CHECK(alone(three(0.125), options).dead_taxels.empty());
  CHECK(alone(three(0.125 - kLittle), options).dead_taxels.size() == 3);
  const auto since = [&](double before) {
    return kinds_of(check_seating(8, 8, responding(8, 8, three(0.0)), responding(8, 8, three(before)), options));
  };
  CHECK(since(0.125) == "warning dead-taxels");
  CHECK(since(0.125 - kLittle).empty());  // they were dead before
}

TEST_CASE("seating, exactly: an array and its lines answer by the least response of an array") {
  SeatingOptions options;
  options.least_array_v = 0.25;
  const auto quarter = [](int, int) { return 0.25; };
  CHECK(kinds_of(alone(quarter, options)).empty());
  CHECK(kinds_of(alone([](int, int) { return 0.25 - kLittle; }, options)) == "fail no-response");
  CHECK(kinds_of(alone([](int row, int) { return row == 5 ? 0.0 : 0.25; }, options)) == "fail dead-rows");
}

TEST_CASE("seating, exactly: a line at the share of the others that a dead one is below is not dead") {
  SeatingOptions options;
  options.dead_line_share = 0.25;
  CHECK(kinds_of(alone(one_row(0.25), options)).empty());
  CHECK(kinds_of(alone(one_row(0.25 - kLittle), options)) == "fail dead-rows");
}

TEST_CASE("seating, exactly: edges begin below their share, reach as far as lines below theirs, and are graded") {
  SeatingOptions options;
  options.edge_share_alone = 0.25;
  options.edge_reach_share_alone = 0.5;
  CHECK(kinds_of(alone(one_row(0.25, 0), options)).empty());
  CHECK(kinds_of(alone(one_row(0.25 - kLittle, 0), options)) == "fail edge-outside");
  const auto rows_outside = [&](double second) {
    const SeatingResult result =
        alone([=](int row, int) { return row == 0   ? 0.125
                                         : row == 1 ? second
                                                    : 1.0; }, options);
    REQUIRE(kinds_of(result) == "fail edge-outside");
    return result.findings[0].rows;
  };
  CHECK(rows_outside(0.5) == std::vector<int>{0});
  CHECK(rows_outside(0.5 - kLittle) == std::vector<int>{0, 1});
  options.edge_least_share = 0.125;
  options.dead_line_share = 0.25;
  CHECK(kinds_of(alone(one_row(0.125, 0), options)) == "fail edge-outside");
  CHECK(kinds_of(alone(one_row(0.125 - kLittle, 0), options)) == "fail dead-rows");
}

TEST_CASE("seating, exactly: a line is judged of which a quarter is left, and stands at one voltage or between two") {
  SeatingTaxels taxels;
  taxels.rows = taxels.columns = 8;
  for (int i = 0; i < 64; ++i) {
    const int row = i / 8;
    taxels.response_v.push_back(row == 2 || row == 5 ? 0.0 : 1.0);
    taxels.loaded_v.push_back(row == 2 ? 0.25 : row == 5 ? 0.5 : 1.25);
  }
  taxels.known_dead.assign(64, false);
  taxels.open_rows.assign(8, false);
  const auto texts = [&](std::size_t open, double least_array_v) {
    taxels.open_columns.assign(8, false);
    for (std::size_t column = 0; column < open; ++column) taxels.open_columns[column] = true;
    SeatingOptions options;
    options.least_array_v = least_array_v;
    std::vector<bool> lost(64, false);
    std::string all;
    for (const SeatingFinding& finding : check_lines(taxels, true, options, lost)) all += finding.text;
    return all;
  };
  CHECK_THAT(texts(6, 0.02), Catch::StartsWith("rows 2, 5 do not answer, standing between 0.25 and 0.50 V"));
  CHECK(texts(7, 0.02).empty());
  CHECK_THAT(texts(0, 0.25), Catch::Contains("standing between 0.25 and 0.50 V"));
  CHECK_THAT(texts(0, just_above(0.25)), Catch::Contains("standing at 0.25 V"));
}

TEST_CASE("seating, exactly: a pattern is compared from its least spread on, and warns or fails below its limits") {
  const SeatingFrames before = responding(4, 8, [](int, int column) { return 1.0 + 0.25 * column_halves(column); });
  const SeatingFrames now = responding(
      4, 8, [](int, int column) { return 1.0 + 0.125 * column_halves(column) + 0.0625 * column_stripes(column); });
  SeatingOptions options;
  options.least_spread = 0.25;
  const auto compared = [&] { return check_seating(4, 8, now, before, options); };
  REQUIRE(compared().correlation);
  const double correlation = *compared().correlation;
  CHECK(correlation == Approx(2.0 / std::sqrt(5.0)));
  options.least_spread = just_above(0.25);
  CHECK_FALSE(compared().correlation);
  options.least_spread = 0.05;
  options.correlation_warning = correlation;
  CHECK(kinds_of(compared()).empty());
  options.correlation_warning = just_above(correlation);
  options.correlation_fail = correlation;
  CHECK(kinds_of(compared()) == "warning deviation");
  options.correlation_fail = just_above(correlation);
  CHECK(kinds_of(compared()) == "fail deviation");
}

TEST_CASE("seating, exactly: another position counts from its correlation on, and above its margin") {
  // Turned by half a turn: sides stay, halves and stripes turn into their opposites.
  const auto pattern = [](double sign) {
    return responding(4, 8, [=](int, int column) {
      const double sides = column < 2 || column > 5 ? 1.0 : -1.0;
      return 1.0 + 0.125 * sides + sign * (0.25 * column_halves(column) + 0.0625 * column_stripes(column));
    });
  };
  const SeatingFrames before = pattern(1.0), now = pattern(-1.0);
  std::vector<double> response_now, response_before;
  for (std::size_t i = 0; i < now.loaded_v.size(); ++i) {
    response_now.push_back(now.loaded_v[i] - now.unloaded_v[i]);
    response_before.push_back(before.loaded_v[i] - before.unloaded_v[i]);
  }
  const std::vector<bool> all(32, true);
  const auto fits = compare_positions(4, 8, response_now, response_before, all, all);
  const double identity = fits[0].correlation;
  double turned = fits[1].correlation;
  for (std::size_t i = 2; i < fits.size(); ++i) turned = std::max(turned, fits[i].correlation);
  REQUIRE(turned == Approx(1.0));
  REQUIRE(identity < 0.0);
  SeatingOptions options;
  const auto found = [&] { return kinds_of(check_seating(4, 8, now, before, options)); };
  options.turn_correlation = turned;
  CHECK(found() == "fail turned");
  options.turn_correlation = just_above(turned);
  CHECK(found() == "fail deviation");
  options.turn_correlation = 0.8;
  options.turn_margin = turned - identity;
  while (identity + options.turn_margin < turned) options.turn_margin = just_above(options.turn_margin);
  while (identity + options.turn_margin > turned) options.turn_margin = just_below(options.turn_margin);
  REQUIRE(identity + options.turn_margin == turned);
  CHECK(found() == "fail deviation");
  while (identity + options.turn_margin == turned) options.turn_margin = just_below(options.turn_margin);
  CHECK(found() == "fail turned");
}

TEST_CASE("seating, exactly: the mean warns and fails beyond its limits, dead taxels beyond their share") {
  SeatingOptions options;
  options.mean_warning = 0.25;
  options.mean_fail = 0.5;
  const auto by = [&](double factor) {
    return kinds_of(check_seating(8, 8, responding(8, 8, [=](int, int) { return factor; }),
                                  responding(8, 8, [](int, int) { return 1.0; }), options));
  };
  CHECK(by(0.75).empty());
  CHECK(by(0.75 - 1e-6) == "warning deviation");
  CHECK(by(0.5) == "warning deviation");
  CHECK(by(0.5 - 1e-6) == "fail deviation");
  options.dead_taxels_share = 0.03125;
  const auto dead = [&](int count) {
    return kinds_of(alone([=](int row, int column) { return row == column && row < count ? 0.0 : 1.0; }, options));
  };
  CHECK(dead(2).empty());
  CHECK(dead(3) == "warning dead-taxels");
}

TEST_CASE("drift, exactly: what is just tolerated needs no adjustment") {
  SensorModel document;
  ModelTaxel& taxel = document.taxels.emplace_back();
  taxel.status = TaxelStatus::kFitted;
  const std::vector<double> ends{0.0, 10.0};
  taxel.fit.model = std::make_unique<MonotoneModel>(PatternCurve(ends, ends, 0.0, 10.0));
  taxel.fit.full_scale = 10.0;
  Histories later;
  document.input_unit = later.input_unit;
  document.output_unit = later.output_unit;
  const std::vector<double> x{0, 0, 4, 4};
  later.taxels.emplace_back().score = {{"later", x, {1.1, 0.9, 9.1, 8.9}, branches_along(x), {}, {}}};
  const Drift drift = drift_of(document, later, 0.01);
  REQUIRE((drift.as_is > drift.zeroed && drift.zeroed > drift.adjusted && drift.adjusted > 0.0));
  const auto verdict = [&](double tolerance) { return drift_of(document, later, tolerance).verdict; };
  CHECK(verdict(drift.as_is) == DriftVerdict::kGood);
  CHECK(verdict(just_below(drift.as_is)) == DriftVerdict::kZero);
  CHECK(verdict(drift.zeroed) == DriftVerdict::kZero);
  CHECK(verdict(just_below(drift.zeroed)) == DriftVerdict::kGain);
  CHECK(verdict(drift.adjusted) == DriftVerdict::kGain);
  CHECK(verdict(just_below(drift.adjusted)) == DriftVerdict::kRecalibrate);
}
