// Condition of the inverse and U of the whole array by hand: ranges, shares, charts, maps.
#include <catch2/catch.hpp>
#include <string>

#include "analysis/report/sections/sections.h"
#include "tests/analysis/report/sections/printed.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace tactbench::analysis::printed;

namespace {

ReportInput conditioned() {
  ReportInput input;
  input.unit = PressureUnit::kPsi;
  UsableRange& range = input.more.usable;
  range.options = {4.0, 2.04, 0.95};
  range.pressure_psi = {0.0, 30.0, 60.0};
  range.taxels = 254;
  range.loading.resolved_share = {0.5, 1.0, 0.75};
  range.loading.usable_share = {0.4, 0.9, 0.65};
  range.loading.median_psi = {3.0, 1.0, 2.0};
  range.loading.worst_psi = {5.0, 1.5, 2.5};
  range.loading.resolved_low_psi = 2.04;
  range.loading.resolved_high_psi = 58.04;
  range.loading.low_psi = 30.0;
  range.loading.high_psi = 30.0;
  range.unloading.resolved_share = {0.3, 0.8, 0.55};
  range.unloading.usable_share = {0.2, 0.7, 0.45};
  range.unloading.median_psi = {3.5, 1.25, 2.25};
  range.unloading.worst_psi = {5.5, 1.75, 2.75};
  range.unloading.resolved_low_psi = 10.0;
  range.unloading.resolved_high_psi = 50.0;
  range.unloading.low_psi = range.unloading.high_psi = kNone;
  return input;
}

LineChart condition_chart(const char* title, const char* y_label, std::vector<Series> series) {
  return {.title = title,
          .x_label = "gauge pressure",
          .y_label = y_label,
          .series = std::move(series),
          .width = 335,
          .height = 280,
          .y_from_zero = true};
}

LevelUncertainty array_level(double pressure, bool up, double mean, double centre) {
  LevelUncertainty level;
  level.pressure_psi = pressure;
  level.up = up;
  level.array.mean_expanded_psi = mean;
  level.array.centre_expanded = centre;
  level.expanded_psi = {0.25, 0.5, kNone, 0.125};
  return level;
}

}  // namespace

TEST_CASE("condition of the inverse by hand: the rule's numbers, both ranges of both branches, charts in per cent") {
  const std::string page = usable_part(conditioned()).value;
  check_once(page, "off by 4 standard deviations of one");
  check_once(page, "inverse by at most " + psi(2.04, 1) + ";");
  check_once(page, "at least 95 % of the 254 fitted taxels");
  check_once(page, "<tr><th scope=\"row\">increasing</th><td>" + psi(2.04, 1) + " to " + psi(58.04, 1) + "</td><td>" +
                       psi(30.0, 1) + " to " + psi(30.0, 1) + "</td></tr>");
  check_once(page, "<tr><th scope=\"row\">decreasing</th><td>" + psi(10.0, 1) + " to " + psi(50.0, 1) +
                       "</td><td>none</td></tr>");
  const std::vector<double> x = {0.0, 30.0, 60.0};
  check_along(page,
              condition_chart("Share of the fitted taxels that meet the rule by noise, and by noise and model error",
                              "share of taxels in %",
                              {{"incr., noise", x, {50.0, 100.0, 75.0}, 1},
                               {"incr., noise and model", x, {40.0, 90.0, 65.0}, 2},
                               {"decr., noise", x, {30.0, 80.0, 55.0}, 4},
                               {"decr., noise and model", x, {20.0, 70.0, 45.0}, 3}}));
  check_both(page,
             condition_chart("Pressure by which an output off by noise and model error moves the inverse, per level",
                             "moved by",
                             {{"incr., median taxel", x, {3.0, 1.0, 2.0}, 1},
                              {"incr., worst", x, {5.0, 1.5, 2.5}, 2},
                              {"decr., median taxel", x, {3.5, 1.25, 2.25}, 4},
                              {"decr., worst", x, {5.5, 1.75, 2.75}, 3}}));
  const std::string none = "<h3>Condition of the inverse</h3>\n<p>not available</p>\n";
  ReportInput input = conditioned();
  input.more.usable.taxels = 0;
  CHECK(usable_part(input).value == none);
  input.more.usable.taxels = 1;
  check_once(usable_part(input).value, "% of the 1 fitted taxels");
  input.more.usable.pressure_psi.clear();
  CHECK(usable_part(input).value == none);
}

TEST_CASE("U of the array by hand: mean and centre of every level, the map of the chosen one on a scale from 0") {
  ReportInput input;
  input.unit = PressureUnit::kPsi;
  input.fit.rows = input.fit.columns = 2;
  input.uncertainty.emplace();
  input.uncertainty->levels = {array_level(10.0, true, 0.1234, 0.001234), array_level(20.04, false, 0.2345, 0.02345)};
  input.uncertainty->levels[1].expanded_psi = {0.01, 0.02, 0.03, 0.04};
  const auto page = [&] { return array_uncertainty_part(input).value; };
  // 0.1234 psi are 0.851 kPa, 0.2345 psi 1.617 kPa.
  check_once(page(), level_head("10.0", "68.9") + "<td>increasing</td>" +
                         numbers({"0.12\u00A0psi (0.85\u00A0kPa)", "0.0012"}) + "</tr>");
  check_once(page(), level_head("20.0", "138.2") + "<td>decreasing</td>" +
                         numbers({"0.23\u00A0psi (1.6\u00A0kPa)", "0.023"}) + "</tr>");
  const auto title = [](double pressure, const char* branch) {
    return "Expanded uncertainty U of each taxel in psi at " + psi(pressure, 1) + ", " + branch;
  };
  const auto map = [](const std::string& name, std::vector<double> values, double high) {
    return numbered_map({name, 2, 2, std::move(values), {0.0, high}, 416.0}, kTwoSignificant).value +
           pressure_bar({0.0, high}, "Colour scale of the map of U", PressureUnit::kPsi, 2).value + "<figcaption>" +
           name + ". Row 0";
  };
  check_once(page(), map(title(10.0, "increasing"), {0.25, 0.5, kNone, 0.125}, 0.5));
  input.uncertainty->chosen = 1;
  check_once(page(), map(title(20.04, "decreasing"), {0.01, 0.02, 0.03, 0.04}, 0.04));
  for (const double nothing : {0.0, kNone}) {
    input.uncertainty->levels[1].expanded_psi.assign(4, nothing);
    check_once(page(), map(title(20.04, "decreasing"), std::vector<double>(4, nothing), 1.0));
  }
}
