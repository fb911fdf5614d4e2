// Values with U as they are printed, and the measuring interval by hand.
#include <catch2/catch.hpp>
#include <limits>
#include <string>

#include "analysis/report/data/judged_runs.h"
#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

constexpr double kNoReading = std::numeric_limits<double>::quiet_NaN();
constexpr PressureUnit kJudgedIn = PressureUnit::kPsi;

std::string printed_psi(double pressure, int digits) {
  return html::pressure(pressure, PressureUnit::kPsi, digits).value;
}

db::VerdictRecord judged_row(const char* criterion, double value, double limit, const char* unit,
                             const char* verdict = "pass", const char* rule = "simple") {
  return {12, 1, criterion, "array", value, limit, unit, rule, verdict, "", std::string(64, 'e'), 0};
}

JudgedUncertainty judged_u(const char* criterion, double expanded, const char* basis = "", const char* missing = "") {
  JudgedUncertainty u;
  u.criterion = criterion;
  u.scope = "array";
  u.expanded = expanded;
  u.basis = basis;
  u.missing = missing;
  u.run = 12;
  return u;
}

std::string value_of(double value, const char* unit, double expanded) {
  const JudgedUncertainty known = judged_u("any", expanded);
  return judged_value(&known, judged_row("any", value, 0.0, unit), kJudgedIn).value;
}

std::string whole_of(double value, const char* unit, double expanded) {
  const JudgedUncertainty known = judged_u("any", expanded);
  return judged_with_uncertainty(&known, judged_row("any", value, 0.0, unit), kJudgedIn).value;
}

// A level at which every taxel has the same U.
LevelUncertainty even_level(double pressure, bool up, double expanded) {
  LevelUncertainty level;
  level.pressure_psi = pressure;
  level.up = up;
  level.expanded_psi.assign(3, expanded);
  level.median.error_psi = 0.01 * pressure;
  level.worst.error_psi = -0.01 * pressure;
  level.median.expanded_psi = 0.5 * expanded;
  level.worst.expanded_psi = expanded;
  level.worst.taxel = 6;
  return level;
}

Uncertainty even_levels(bool up, const std::vector<double>& pressures, const std::vector<double>& expanded) {
  Uncertainty uncertainty;
  for (std::size_t i = 0; i < pressures.size(); ++i)
    uncertainty.levels.push_back(even_level(pressures[i], up, expanded[i]));
  return uncertainty;
}

std::string within_of(const Uncertainty& uncertainty, bool up, double most) {
  return range_within(uncertainty, up, most, PressureUnit::kPsi).value;
}

}  // namespace

TEST_CASE(
    "a judged value by hand: the place of its U where that is known, else three decimals of psi, two of per cent") {
  // 0.0996 is 0.10 psi and 0.687 is 0.69 kPa: hundredths of both. 1.23456 psi are 8.51199 kPa.
  CHECK(value_of(1.23456, "psi", 0.0996) == "1.23\u00A0psi (8.51\u00A0kPa)");
  for (const double unknown : {0.0, -1.0, kNoReading, std::numeric_limits<double>::infinity()})
    CHECK(value_of(1.23456, "psi", unknown) == "1.235\u00A0psi (8.51\u00A0kPa)");
  CHECK(judged_value(nullptr, judged_row("any", 1.23456, 0.0, "psi"), kJudgedIn).value == printed_psi(1.23456, 3));
  for (const char* share : {"FS", "fs", "share of FS"}) {
    CHECK(value_of(0.0123462, share, 0.0123) == "1.2\u00A0%\u00A0FS");
    CHECK(value_of(0.0123462, share, 0.000123) == "1.235\u00A0%\u00A0FS");
    CHECK(value_of(0.0123462, share, 0.0) == "1.23\u00A0%\u00A0FS");
    CHECK(value_of(kNoReading, share, 0.0123) == "not available");
  }
  CHECK(value_of(1.0, "taxels", 0.0) == "1 taxel");
  CHECK(value_of(2.0, "taxels", 0.0) == "2 taxels");
  CHECK(value_of(1.0, "V", 0.0) == "1 V");
  CHECK(value_of(12.345678, "V", 0.5) == "12.346 V");
  CHECK(value_of(std::numeric_limits<double>::infinity(), "V", 0.0) == "not available");
  CHECK(judged_limit(judged_row("any", 0.0, 0.01554, "FS"), kJudgedIn).value == "1.55\u00A0%\u00A0FS");
}

TEST_CASE("a judged value with U by hand: in its unit, per cent of full scale, plain numbers, without U the value") {
  CHECK(whole_of(1.23456, "psi", 0.0996) == "1.23 ± 0.10\u00A0psi (8.51 ± 0.69\u00A0kPa)");
  CHECK(whole_of(0.0123462, "FS", 0.00123) == "1.23\u00A0%\u00A0FS ± 0.12");
  CHECK(whole_of(3.0, "taxels", 0.5) == "3 taxels ± 0.50");
  for (const double unknown : {0.0, -0.5, kNoReading}) CHECK(whole_of(3.0, "taxels", unknown) == "3 taxels");
  CHECK(whole_of(kNoReading, "taxels", 0.5) == "not available");
  CHECK(judged_with_uncertainty(nullptr, judged_row("any", 3.0, 0.0, "taxels"), kJudgedIn).value == "3 taxels");
}

TEST_CASE("the longest row of levels within a bound by hand: the first of two as long, ends alone, none") {
  const std::vector<double> pressures = {0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0};
  const auto up = [&](const std::vector<double>& expanded) { return even_levels(true, pressures, expanded); };
  const auto row_is = [](double low, double high) {
    return "increasing: " + printed_psi(low, 1) + " to " + printed_psi(high, 1);
  };
  CHECK(within_of(up({.1, .3, .1, .1, .1, .3, .1}), true, 0.2) == row_is(20.0, 40.0));
  CHECK(within_of(up({.1, .1, .3, .1, .1, .3, .1}), true, 0.2) == row_is(0.0, 10.0));  // as long as 30 to 40
  CHECK(within_of(up({.3, .1, .1, .3, .1, .1, .1}), true, 0.2) == row_is(40.0, 60.0));
  CHECK(within_of(up({.2, .2, .3, .3, .3, .3, .1}), true, 0.2) == row_is(0.0, 10.0));  // at the bound is within
  CHECK(within_of(up({.3, .3, .3, .1, .3, .3, .3}), true, 0.2) == "increasing: at " + printed_psi(30.0, 1) + " alone");
  CHECK(within_of(up({.3, .3, .3, .1, .3, .3, .1}), true, 0.2) == "increasing: at " + printed_psi(30.0, 1) + " alone");
  CHECK(within_of(up({.3, .3, .3, .3, .3, .3, .3}), true, 0.2) == "increasing: at no level");
  CHECK(within_of(up({.1, .1, .1, .1, .1, .1, .1}), true, 0.2) == row_is(0.0, 60.0));
  // The other branch alone counts.
  CHECK(within_of(up({.1, .1, .1, .1, .1, .1, .1}), false, 0.2) == "decreasing: at no level");
  Uncertainty both = even_levels(true, {0.0, 10.0}, {0.1, 0.1});
  for (const LevelUncertainty& level : even_levels(false, {10.0, 20.0}, {0.1, 0.1}).levels)
    both.levels.push_back(level);
  CHECK(within_of(both, false, 0.2) == "decreasing: " + printed_psi(10.0, 1) + " to " + printed_psi(20.0, 1));
}

TEST_CASE("a level is within a bound when 95 of 100 taxels are, of those that have a model") {
  Uncertainty uncertainty = even_levels(true, {10.0}, {0.1});
  std::vector<double>& expanded = uncertainty.levels[0].expanded_psi;
  expanded.assign(100, 0.1);
  for (std::size_t i = 0; i < 4; ++i) expanded[10 * i] = 0.9;
  expanded.insert(expanded.end(), 50, kNoReading);
  CHECK(within_of(uncertainty, true, 0.2) == "increasing: at " + printed_psi(10.0, 1) + " alone");
  expanded[5] = 0.9;
  CHECK(within_of(uncertainty, true, 0.2) == "increasing: at no level");
}
