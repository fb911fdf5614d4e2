// Values with U as they are printed, and the measuring interval by hand.
#include <catch2/catch.hpp>
#include <limits>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "analysis/report/data/judged_runs.h"
#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

constexpr double kNoReading = std::numeric_limits<double>::quiet_NaN();
constexpr PressureUnit kJudgedIn = PressureUnit::kPsi;

db::VerdictRecord judged_row(double value, double limit, const char* unit) {
  return {12, 1, "any", "array", value, limit, unit, "simple", "pass", "", std::string(64, 'e'), 0};
}

JudgedUncertainty judged_u(double expanded) {
  JudgedUncertainty u;
  u.criterion = "any";
  u.scope = "array";
  u.expanded = expanded;
  u.run = 12;
  return u;
}

std::string value_of(double value, const char* unit, double expanded) {
  const JudgedUncertainty known = judged_u(expanded);
  return judged_value(&known, judged_row(value, 0.0, unit), kJudgedIn).value;
}

std::string whole_of(double value, const char* unit, double expanded) {
  const JudgedUncertainty known = judged_u(expanded);
  return judged_with_uncertainty(&known, judged_row(value, 0.0, unit), kJudgedIn).value;
}

std::string share_of_fs(const std::string& percent) { return percent + "\u00A0%\u00A0" + "FS"; }

// Every taxel has the same U at a level.
Uncertainty even_levels(bool up, const std::vector<double>& pressures, const std::vector<double>& expanded) {
  Uncertainty uncertainty;
  for (std::size_t i = 0; i < pressures.size(); ++i) {
    LevelUncertainty& level = uncertainty.levels.emplace_back();
    level.pressure_psi = pressures[i];
    level.up = up;
    level.expanded_psi.assign(3, expanded[i]);
  }
  return uncertainty;
}

// The ends of the range that is printed, one where it is a level alone.
std::vector<double> ends_within(const Uncertainty& uncertainty, bool up, double most) {
  static const std::regex ends("([0-9.]+)\u00A0psi");
  const std::string printed = range_within(uncertainty, up, most, PressureUnit::kPsi).value;
  CHECK(printed.starts_with(up ? "increasing" : "decreasing"));
  std::vector<double> pressures;
  for (auto end = std::sregex_iterator(printed.begin(), printed.end(), ends); end != std::sregex_iterator(); ++end)
    pressures.push_back(std::stod((*end)[1]));
  return pressures;
}

}  // namespace

TEST_CASE(
    "a judged value by hand: the place of its U where that is known, else three decimals of psi, two of per cent") {
  // 0.0996 is 0.10 psi and 0.687 is 0.69 kPa: hundredths of both. 1.23456 psi are 8.51199 kPa.
  CHECK(value_of(1.23456, "psi", 0.0996) == "1.23\u00A0psi (8.51\u00A0kPa)");
  for (const double unknown : {0.0, -1.0, kNoReading, std::numeric_limits<double>::infinity()})
    CHECK(value_of(1.23456, "psi", unknown) == "1.235\u00A0psi (8.51\u00A0kPa)");
  CHECK(judged_value(nullptr, judged_row(1.23456, 0.0, "psi"), kJudgedIn).value == "1.235\u00A0psi (8.51\u00A0kPa)");
  for (const char* share : {"FS", "fs", "share of FS"}) {
    CHECK(value_of(0.0123462, share, 0.0123) == share_of_fs("1.2"));
    CHECK(value_of(0.0123462, share, 0.000123) == share_of_fs("1.235"));
    CHECK(value_of(0.0123462, share, 0.0) == share_of_fs("1.23"));
    CHECK(value_of(kNoReading, share, 0.0123) == "not available");
  }
  CHECK(value_of(1.0, "taxels", 0.0) == "1 taxel");
  CHECK(value_of(2.0, "taxels", 0.0) == "2 taxels");
  CHECK(value_of(1.0, "V", 0.0) == "1 V");
  CHECK(value_of(12.345678, "V", 0.5) == "12.346 V");
  CHECK(value_of(std::numeric_limits<double>::infinity(), "V", 0.0) == "not available");
  CHECK(judged_limit(judged_row(0.0, 0.01554, "FS"), kJudgedIn).value == share_of_fs("1.55"));
}

TEST_CASE("a judged value with U by hand: in its unit, per cent of full scale, plain numbers, without U the value") {
  CHECK(whole_of(1.23456, "psi", 0.0996) == "1.23 ± 0.10\u00A0psi (8.51 ± 0.69\u00A0kPa)");
  CHECK(whole_of(0.0123462, "FS", 0.00123) == share_of_fs("1.23") + " ± 0.12");
  CHECK(whole_of(3.0, "taxels", 0.5) == "3 taxels ± 0.50");
  for (const double unknown : {0.0, -0.5, kNoReading}) CHECK(whole_of(3.0, "taxels", unknown) == "3 taxels");
  CHECK(whole_of(kNoReading, "taxels", 0.5) == "not available");
  CHECK(judged_with_uncertainty(nullptr, judged_row(3.0, 0.0, "taxels"), kJudgedIn).value == "3 taxels");
}

TEST_CASE("the longest row of levels within a bound by hand: the first of two as long, ends alone, none") {
  using Ends = std::vector<double>;
  const Ends pressures = {0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0};
  for (const auto& [expanded, ends] : {std::pair<Ends, Ends>{{.1, .3, .1, .1, .1, .3, .1}, {20.0, 40.0}},
                                       {{.1, .1, .3, .1, .1, .3, .1}, {0.0, 10.0}},  // as long as 30 to 40
                                       {{.3, .1, .1, .3, .1, .1, .1}, {40.0, 60.0}},
                                       {{.2, .2, .3, .3, .3, .3, .1}, {0.0, 10.0}},  // at the bound is within
                                       {{.3, .3, .3, .1, .3, .3, .3}, {30.0}},
                                       {{.3, .3, .3, .1, .3, .3, .1}, {30.0}},
                                       {{.3, .3, .3, .3, .3, .3, .3}, {}},
                                       {{.1, .1, .1, .1, .1, .1, .1}, {0.0, 60.0}}}) {
    const Uncertainty rising = even_levels(true, pressures, expanded);
    CHECK(ends_within(rising, true, 0.2) == ends);
    CHECK(ends_within(rising, false, 0.2).empty());  // the other branch alone counts
  }
  Uncertainty both = even_levels(true, {0.0, 10.0}, {0.1, 0.1});
  for (const LevelUncertainty& level : even_levels(false, {10.0, 20.0}, {0.1, 0.1}).levels)
    both.levels.push_back(level);
  CHECK(ends_within(both, false, 0.2) == Ends{10.0, 20.0});
}

TEST_CASE("a level is within a bound when 95 of 100 taxels are, of those that have a model") {
  Uncertainty uncertainty = even_levels(true, {10.0}, {0.1});
  std::vector<double>& expanded = uncertainty.levels[0].expanded_psi;
  expanded.assign(100, 0.1);
  for (std::size_t i = 0; i < 4; ++i) expanded[10 * i] = 0.9;
  expanded.insert(expanded.end(), 50, kNoReading);
  CHECK(ends_within(uncertainty, true, 0.2).size() == 1);
  expanded[5] = 0.9;
  CHECK(ends_within(uncertainty, true, 0.2).empty());
}
