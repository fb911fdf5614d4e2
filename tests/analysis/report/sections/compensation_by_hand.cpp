// Single taxels and the parameters over the array by hand: three charts of each sequence, errors, histograms, bounds.
#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

#include "analysis/report/sections/sections.h"
#include "tests/analysis/report/sections/printed.h"
#include "tests/analysis/support/sensor_models.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace tactbench::analysis::printed;

namespace {

TaxelTrace corrected_trace(int taxel, const char* title, const char* sequence) {
  TaxelTrace trace;
  trace.taxel.taxel = taxel;
  trace.taxel.title = title;
  trace.sequence = sequence;
  trace.pressure_psi = {0.0, 30.0, 60.0};
  trace.measured_v = {0.0, 1.0, 2.0};
  trace.model_v = {0.1, 0.9, 2.0};
  trace.estimate_psi = {1.0, 28.0, 60.0};
  return trace;
}

// Three taxels with the parameter given, each times its place from 1, and one that is left out.
SensorModel four_taxels() {
  SensorModel fit;
  fit.model = "elam";
  fit.rows = fit.columns = 2;
  const std::vector<double> x = {0.0, 60.0}, up = {0.0, 2.0};
  for (int i = 1; i <= 3; ++i) {
    ElamParameters p;
    p.alpha_d = 0.12344 * i;
    p.beta_d = 0.22344 * i;
    p.alpha_a1 = -0.0009765625 * i;  // a power of two: its thirds are exact
    p.alpha_a0 = 0.3;
    p.beta_a = 0.05 * i;
    fit.taxels.push_back(by_hand::elam_taxel(PatternCurve(x, up, 0.0, 2.0), PatternCurve(x, up, 0.0, 2.0), p));
  }
  fit.taxels.insert(fit.taxels.begin() + 1, by_hand::left_out(TaxelStatus::kDead));
  by_hand::finish(fit, fit.taxels[0]);
  fit.taxels[1].fit.at_bound = 31;
  fit.taxels[2].fit.at_bound = 1;
  fit.taxels[3].fit.at_bound = 5;
  return fit;
}

}  // namespace

TEST_CASE("single taxels by hand: direct, inverse and corrected of each sequence, and their errors") {
  ReportInput input;
  input.unit = PressureUnit::kPsi;
  input.fit.model = "elam";
  input.more.traces = {corrected_trace(3, "best taxel", "up"), corrected_trace(3, "best taxel", "down"),
                       corrected_trace(5, "worst taxel", "up")};
  const std::string page = compensation_section(input).value;
  CHECK(count(page, "<h3>The best taxel</h3>") == 1);
  CHECK(count(page, "<h3>The worst taxel</h3>") == 1);
  // 1, 2 and 0 psi off.
  const std::string errors = numbers({"3", psi(1.0, 3), psi(2.0, 2)}) + "</tr>";
  CHECK(count(page, "<th scope=\"row\">best taxel</th><td>up</td>" + errors) == 1);
  CHECK(count(page, "<th scope=\"row\">best taxel</th><td>down</td>" + errors) == 1);
  const std::string of = "best taxel, sequence down";
  const std::vector<double> x = {0.0, 30.0, 60.0}, volts = {0.0, 1.0, 2.0}, estimate = {1.0, 28.0, 60.0};
  const auto third = [](const std::string& title, const char* along, const char* up, std::vector<Series> series) {
    return LineChart{
        .title = title, .x_label = along, .y_label = up, .series = std::move(series), .width = 226, .height = 205};
  };
  check_along(page, third("Output measured and by the direct model against pressure, " + of, "pressure", "output in V",
                          {{"measured", x, volts, 0}, {"ELAM", x, {0.1, 0.9, 2.0}, 1}}));
  check_once(page, line_chart(third("Pressure measured and by the inverse model against output, " + of, "output in V",
                                    "pressure in psi", {{"measured", volts, x, 0}, {"inverse", volts, estimate, 1}}))
                       .value);
  const std::string against = "Corrected indication against reference value, " + of;
  check_both(page, third(against, "reference", "corrected",
                         {{"corrected", x, estimate, 2, true}, {"ideal", {0.0, 60.0}, {0.0, 60.0}, 0}}));
  input.more.traces[1].pressure_psi = {30.0, kNone, kNone};
  check_both(compensation_section(input).value,
             third(against, "reference", "corrected", {{"corrected", {30.0, kNone, kNone}, estimate, 2, true}}));
  input.more.traces.clear();
  check_once(compensation_section(input).value, "<p>not available</p>");
}

TEST_CASE("parameters over the array by hand: maps, their scales and ends with three decimals, the slope with four") {
  ReportInput input;
  input.fit = four_taxels();
  const std::string page = elam_parameters_part(input).value;
  const auto drawn = [&](const char* name, std::vector<double> values, double low, double high, int digits) {
    return frame_map({std::string(name) + " of each taxel", 2, 2, std::move(values), {low, high}, 190.0}).value +
           colour_bar({low, high}, std::string("Colour scale of ") + name, "", digits).value;
  };
  const double a = 0.12344, b = 0.22344, s = -0.0009765625;
  check_once(page, drawn("alpha_d", {a, kNone, 2 * a, 3 * a}, a, 3 * a, 3));
  check_once(page, drawn("beta_d", {b, kNone, 2 * b, 3 * b}, b, 3 * b, 3));
  check_once(page, drawn("alpha_a1", {s, kNone, 2 * s, 3 * s}, 3 * s, s, 4));
  check_once(page, drawn("alpha_a0", {0.3, kNone, 0.3, 0.3}, 0.3, 0.3 + 1e-9, 3));
  check_once(page, "alpha_d: minimum 0.123, median 0.247, maximum 0.370.</figcaption>");
  check_once(page, "beta_d: minimum 0.223, median 0.447, maximum 0.670.</figcaption>");
  check_once(page, "alpha_a1: minimum −0.0029, median −0.0020, maximum −0.0010.</figcaption>");
  check_once(page, "alpha_a0: minimum 0.300, median 0.300, maximum 0.300.</figcaption>");
  check_once(page, "<figcaption>alpha_a1 over the array, 1/psi.</figcaption>");
  check_once(page, "<figcaption>beta_a over the array.</figcaption>");
  // Taxel 1 has no model: its bounds do not count.
  check_once(page, "<th scope=\"row\">alpha_d</th><td class=\"n\">2</td><td>(1, 0) (1, 1)</td></tr>");
  check_once(page, "<th scope=\"row\">beta_d</th><td class=\"n\">0</td><td>none</td></tr>");
  check_once(page, "<th scope=\"row\">alpha_a1</th><td class=\"n\">1</td><td>(1, 1)</td></tr>");
  input.fit.taxels = {by_hand::left_out(TaxelStatus::kDead)};
  check_once(elam_parameters_part(input).value, "<p>not available</p>");
}

TEST_CASE("parameters over the array by hand: a histogram has 24 bins from the lowest to the highest") {
  ReportInput input;
  input.fit = four_taxels();
  const std::string page = elam_parameters_part(input).value;
  const auto chart = [](const char* name, const char* label, double low, double width, const std::vector<int>& bins) {
    Series outline{"taxels", {low}, {0.0}, 0};
    for (int bin = 0; bin < 24; ++bin) {
      outline.x.insert(outline.x.end(), {low + width * bin, low + width * (bin + 1)});
      const auto taxels = static_cast<double>(std::ranges::count(bins, bin));
      outline.y.insert(outline.y.end(), {taxels, taxels});
    }
    outline.x.push_back(low + 24 * width);
    outline.y.push_back(0.0);
    return line_chart({.title = std::string("Histogram of ") + name + " over the taxels",
                       .x_label = label,
                       .y_label = "taxels",
                       .series = {outline},
                       .width = 335,
                       .height = 215,
                       .y_from_zero = true})
        .value;
  };
  // Lowest, middle and highest: bins 0, 12 and the last. Alike values lie in the first of 24 bins of a millionth.
  const double s = -0.0009765625;
  check_once(page, chart("alpha_a1", "alpha_a1, 1/psi", 3 * s, (s - 3 * s) / 24, {0, 12, 23}));
  check_once(page, chart("alpha_a0", "alpha_a0", 0.3, 1e-6 / 24, {0, 0, 0}));
}
