// Sensor health by hand: criteria in numbers, findings listed, the map of spans, the histogram of noise, JSON.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "analysis/report/data/section_data.h"
#include "analysis/report/sections/sections.h"
#include "tests/analysis/report/sections/printed.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace tactbench::analysis::printed;

namespace {

// Two rows of three taxels: one dead, one noisy and one that no model meets.
ReportInput examined() {
  ReportInput input;
  input.unit = PressureUnit::kPsi;
  Health& health = input.health;
  health.rows = 2;
  health.columns = 3;
  health.options = {0.07, 3.5, 0.2, 0.8};
  health.low_v = {0.1, 0.2, 0.0, 0.3, 0.4, 0.5};
  health.high_v = {2.1, 3.2, 0.01, 1.3, 2.4, 0.75};
  health.noise_v = {0.001, 0.002, 0.0005, 0.009, 0.001, kNone};
  health.median_noise_v = 0.001234;
  health.findings = {{2, "dead", "moves 0.01 V", true}, {3, "noisy", "9 mV", false}, {5, "unfit", "12 %", true}};
  return input;
}

std::string criterion(const char* state, int taxels, const std::string& begins) {
  return std::string("<tr><th scope=\"row\">") + state + "</th><td class=\"n\">" + std::to_string(taxels) +
         "</td><td>" + begins;
}

}  // namespace

TEST_CASE("sensor health by hand: how many taxels are used, the criteria's numbers, each finding with its place") {
  ReportInput input = examined();
  std::string page = health_section(input).value;
  check_once(page, "<p>4 of 6 taxels used, 2 excluded.</p>");
  check_once(page, criterion("dead", 1, "output moves less than 0.07 V over the whole run and stays below that</td>"));
  check_once(page, criterion("stuck", 0, "output moves less than 0.07 V over the whole run, away from 0 V</td>"));
  check_once(page, criterion("saturated", 0, "at least one sample at the limit of the converter</td>"));
  check_once(page, criterion("not modelled", 1,
                             "output moves, but not with the pressure, or no model meets it better "
                             "than 10 % of"));
  check_once(page, criterion("noisy", 1,
                             "standard deviation of a sample, from the scans of one frame, above 3.5 times "
                             "the median taxel&#39;s 1.23 mV</td>"));
  check_once(page,
             "<tr><th scope=\"row\">2</th><td>row 0, column 2</td><td class=\"state\">dead</td><td>moves 0.01 "
             "V</td><td>every figure</td></tr>");
  check_once(page,
             "<tr><th scope=\"row\">3</th><td>row 1, column 0</td><td class=\"state\">noisy</td><td>9 "
             "mV</td><td>nothing</td></tr>");
  check_once(page, "<td class=\"state\">not modelled</td><td>12 %</td><td>every figure</td></tr>");
  input.health.loaded = false;
  CHECK(count(health_section(input).value, "; not assessed: the run pressed on a part of the array only</td>") == 2);
  input.health.noise_v.clear();
  page = health_section(input).value;
  check_once(page, "not assessed: one scan a frame gives no noise");
  check_none(page, "Noise of one sample, number of taxels");
  input.health.findings.clear();
  page = health_section(input).value;
  check_none(page, "Taxels with findings");
  check_once(page, "<p>6 of 6 taxels used, 0 excluded.</p>");
  input.health.high_v.clear();
  check_once(health_section(input).value, "<p>not available</p>");
}

TEST_CASE("sensor health by hand: sixty-four findings are listed, of more the number is told") {
  ReportInput input = examined();
  input.health.findings.assign(64, {1, "noisy", "", false});
  const auto listed = [&] { return count(health_section(input).value, "<td class=\"state\">noisy</td>"); };
  CHECK(listed() == 64);
  check_none(health_section(input).value, "all stand in the data");
  input.health.findings.push_back({1, "noisy", "", false});
  CHECK(listed() == 64);
  check_once(health_section(input).value, "The first 64 of 65 are printed; all stand in the data.");
}

TEST_CASE("sensor health by hand: the map of spans leaves out what is excluded, the histogram is in mV with its line") {
  ReportInput input = examined();
  const std::string page = health_section(input).value;
  const char* const title = "Span of each taxel's output over the run";
  const auto spans = [&](const std::vector<double>& values, double high) {
    return frame_map({title, 2, 3, values, {0.0, high}, 220.0}).value +
           colour_bar({0.0, high}, "Colour scale of the spans", "V", 2).value;
  };
  check_once(page, spans({2.1 - 0.1, 3.2 - 0.2, kNone, 1.3 - 0.3, 2.4 - 0.4, kNone}, 3.2 - 0.2));
  const Histogram noise{.title = "Noise of one sample, number of taxels",
                        .x_label = "noise of one sample in mV",
                        .y_label = "taxels",
                        .values = {1.0, 2.0, 0.5, 9.0, 1.0, kNone},
                        .limit = 1e3 * 3.5 * 0.001234,
                        .limit_name = "noisy above",
                        .width = 420,
                        .height = 240};
  check_once(page, histogram_chart(noise).value);
  check_once(page, "of each taxel; 1 beyond the line.");
  input.health.high_v = input.health.low_v;  // nothing moves
  input.health.findings.clear();
  check_once(health_section(input).value, spans(std::vector<double>(6, 0.0), 1.0));
  input.health.high_v.assign(6, kNone);
  check_none(health_section(input).value, title);
}

TEST_CASE("sensor health by hand: findings of seating checks in the page's unit, what is none is passed over") {
  ReportInput input = examined();
  check_once(health_section(input).value, "not assessed, this run has no seating check.</p>");
  input.history.seating_v = {0.1};
  check_once(health_section(input).value, "not assessed, there is no earlier good seating of this sensor");
  const auto seating = [&](const char* kind, const char* detail) {
    input.history.checks = {{12, 0, kind, "warning", detail, {}}};
    return health_section(input).value;
  };
  check_once(
      seating("seating", R"({"findings":[{"text":"weak at 40 psi"},{"text":7},{"words":"no"},3,{"text":"cold"}]})"),
      "<p>Findings of the seating check:</p>\n<ul>\n<li>weak at 40 psi (275.8 kPa)</li>\n<li>cold</li>\n</ul>");
  for (const char* nothing : {"", "[]", "{}", R"({"findings":{"text":"no"}})", R"({"findings":[]})"})
    check_none(seating("seating", nothing), "Findings of the seating check");
  check_none(seating("tare", R"({"findings":[{"text":"weak"}]})"), "Findings of the seating check");
  input.history.checks.push_back({12, 1, "seating", "warning", R"({"findings":[{"text":"weak"}]})", {}});
  check_once(health_section(input).value, "<li>weak</li>");
}

TEST_CASE("sensor health by hand: its data name each finding and each pair of lines") {
  ReportInput input = examined();
  input.health.swaps_assessed = true;
  input.health.swaps = {{true, 3, 7, 0.125, 0.75}, {false, 0, 15, 0.25, 0.875}};
  const auto data = nlohmann::json::parse(health_json(input));
  CHECK(data["findings"].size() == 3);
  CHECK((data["findings"][1]["taxel"] == 3 && data["findings"][1]["state"] == "noisy"));
  CHECK((data["findings"][2]["reason"] == "12 %" && data["findings"][2]["excluded"] == true));
  CHECK(data["swaps"] ==
        nlohmann::json::parse(
            R"([{"lines":"rows","first":3,"second":7,"correlation_as_is":0.125,"correlation_exchanged":0.75},)"
            R"({"lines":"columns","first":0,"second":15,"correlation_as_is":0.25,"correlation_exchanged":0.875}])"));
  CHECK((data["dead_v"] == 0.07 && data["noisy_factor"] == 3.5 && data["swaps_assessed"] == true));
  CHECK((data["noise_v"][3] == 0.009 && data["noise_v"][5].is_null() && data["high_v"][1] == 3.2));
}
