// The measuring interval by hand.
#include <catch2/catch.hpp>
#include <limits>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

constexpr double kNoReading = std::numeric_limits<double>::quiet_NaN();

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
