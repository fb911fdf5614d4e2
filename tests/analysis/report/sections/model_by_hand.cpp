// The models of the taxels by hand: the mean taxel, what a dynamic model undoes, distributions, taxels without a model.
#include <catch2/catch.hpp>
#include <string>

#include "analysis/report/sections/sections.h"
#include "tests/analysis/report/sections/printed.h"
#include "tests/analysis/support/sensor_models.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace tactbench::analysis::printed;

namespace {

// Times `of` of a taxel whose loop reaches to 2.5 V.
ModelTaxel taxel_with_loop(double of) {
  const std::vector<double> x = {0.0, 60.0}, y = {0.0, 2.5 * of};
  const PatternCurve curve(x, y, 0.0, 2.5 * of);
  ModelTaxel taxel =
      by_hand::elam_taxel(curve, curve, {0.12344 * of, 0.22344 * of, -0.00344 * of, 0.32344 * of, 0.1 * of});
  taxel.fit.j = 0.44444 * of;
  taxel.fit.mean_error = 0.05123 * of;
  taxel.fit.max_error = 0.15678 * of * of;
  taxel.noise = 0.0012344 * of;
  return taxel;
}

ReportInput modelled() {
  ReportInput input;
  input.unit = PressureUnit::kPsi;
  input.fit.model = "elam";
  input.fit.rows = 1;
  input.fit.columns = 3;
  input.fit.taxels = {taxel_with_loop(1.0), taxel_with_loop(2.0), taxel_with_loop(0.5)};
  input.fit.taxels[0].fit.at_bound = 4;
  input.fit.taxels[2].fit.at_bound = 6;
  by_hand::finish(input.fit, taxel_with_loop(1.0));
  input.fit.taxels.back().fit.at_bound = 2;
  Evaluation& e = input.evaluation;
  e.taxel_mean_error_psi = {0.5, kNone, 1.25};
  e.mean_error_psi = 0.11114;
  e.mean_error_observable_psi = 0.22224;
  e.max_error_psi = 3.3334;
  e.max_error_observable_psi = 2.2224;
  e.worst_taxel_mean_error_psi = 0.44444;
  return input;
}

std::string quantity(const char* name, const char* value, const char* unit, const std::string& remark) {
  return std::string("<tr><th scope=\"row\">") + name + "</th><td class=\"n\">" + value + "</td><td>" + unit +
         "</td><td>" + remark + "</td></tr>";
}

std::string spread_row(const char* name, const char* unit, const std::vector<std::string>& cells) {
  return std::string("<tr><th scope=\"row\">") + name + "</th><td>" + unit + "</td>" + numbers(cells) + "</tr>";
}

}  // namespace

TEST_CASE("the mean taxel's model by hand: parameters, errors in volts and of full scale, noise in mV") {
  const std::string page = model_section(modelled()).value;
  check_once(page, quantity("alpha_d", "0.1234", "1", ""));
  check_once(page, quantity("beta_d", "0.2234", "1", "at a bound of the search"));
  check_once(page, quantity("alpha_a1", "−0.0034", "1/psi", ""));
  check_once(page, quantity("alpha_a0", "0.3234", "1", ""));
  check_once(page, quantity("beta_a", "0.1000", "1", ""));
  check_once(page, "<th scope=\"row\">J, Eq. (1)</th><td class=\"n\">0.4444</td><td>V²</td>");
  check_once(page, quantity("mean error, Eq. (49)", "0.0512", "V", "2.05 % FS"));
  check_once(page, quantity("maximum error", "0.1568", "V", "6.27 % FS"));
  check_once(page, "<th scope=\"row\">full scale (FS)</th><td class=\"n\">2.500</td>");
  check_once(page, quantity("noise of one sample", "1.23", "mV", "standard deviation"));
}

TEST_CASE("models of the taxels by hand: lowest, median and highest of each figure, and how many are at a bound") {
  const std::string page = model_section(modelled()).value;
  check_once(page, "<caption>ELAM of the 3 fitted taxels: distribution</caption>");
  // One, two and half of the mean taxel's.
  check_once(page, spread_row("alpha_d", "1", {"0.0617", "0.1234", "0.2469", "0"}));
  check_once(page, spread_row("beta_d", "1", {"0.1117", "0.2234", "0.4469", "1"}));
  check_once(page, spread_row("alpha_a1", "1/psi", {"−0.0069", "−0.0034", "−0.0017", "2"}));
  check_once(page, spread_row("J", "V²", {"0.2222", "0.4444", "0.8889", "–"}));
  check_once(page, spread_row("mean error", "V", {"0.0256", "0.0512", "0.1025", "–"}));
  check_once(page, spread_row("mean error", "% FS of the taxel", {"2.05", "2.05", "2.05", "–"}));
  check_once(page, spread_row("maximum error", "V", {"0.0392", "0.1568", "0.6271", "–"}));
  check_once(page, spread_row("maximum error", "% FS of the taxel", {"3.14", "6.27", "12.54", "–"}));
  check_once(page, spread_row("full scale of the taxel", "V", {"1.250", "2.500", "5.000", "–"}));
  check_once(page, spread_row("noise of one sample", "mV", {"0.62", "1.23", "2.47", "–"}));
  check_once(page, "<p>All 3 taxels were fitted; none was left out.</p>");
}

TEST_CASE("errors of the corrected indication by hand: figures, the worst taxel with its finding, the map") {
  ReportInput input = modelled();
  const auto page = [&] { return model_section(input).value; };
  check_once(page(), row("mean", {psi(0.11114, 3), psi(0.22224, 3)}));
  check_once(page(), row("maximum", {psi(3.3334, 2), psi(2.2224, 2)}));
  check_once(page(), row("mean of the worst taxel", {psi(0.44444, 3), "not assessed"}));
  check_none(page(), "Worst taxel: ");
  input.evaluation.worst_taxel = 0;
  check_once(page(), "Worst taxel: 0 (row 0, column 0).</p>");
  input.health.findings = {{1, "noisy", "", false}, {2, "stuck", "", true}};
  input.evaluation.worst_taxel = 1;
  check_once(page(), "Worst taxel: 1 (row 0, column 1, noisy).</p>");
  const auto map = [](std::vector<double> values, double high) {
    return numbered_map({"Mean absolute error of each taxel in psi", 1, 3, std::move(values), {0.0, high}, 416.0},
                        kTwoSignificant)
               .value +
           pressure_bar({0.0, high}, "Colour scale of the error map", PressureUnit::kPsi, 2).value;
  };
  check_once(page(), map({0.5, kNone, 1.25}, 1.25));
  input.evaluation.taxel_mean_error_psi = {0.0, 0.0, kNone};
  check_once(page(), map({0.0, 0.0, kNone}, 1.0));
  input.evaluation.taxel_mean_error_psi.clear();
  check_once(page(), "<p>Map of the error: not available</p>");
}

TEST_CASE("taxels without a model by hand: each with its place and the reason") {
  ReportInput input = modelled();
  input.fit.columns = 2;
  ModelTaxel bare = by_hand::left_out(TaxelStatus::kUnfit), bad = taxel_with_loop(1.0);
  bad.status = TaxelStatus::kUnfit;
  bad.fit.mean_error = 0.31249;
  ModelTaxel told = bad;
  told.reason = "no loop was swept";
  input.fit.taxels = {taxel_with_loop(1.0),
                      by_hand::left_out(TaxelStatus::kDead),
                      by_hand::left_out(TaxelStatus::kStuck),
                      by_hand::left_out(TaxelStatus::kSaturated),
                      by_hand::left_out(TaxelStatus::kConstant),
                      bare,
                      bad,
                      told};
  by_hand::finish(input.fit, taxel_with_loop(1.0));
  const std::string page = model_section(input).value;
  const auto left_out_row = [](const char* taxel, const char* place, const char* state, const char* reason) {
    return std::string("<tr><th scope=\"row\">") + taxel + "</th><td>" + place + "</td><td>" + state + "</td><td>" +
           reason + "</td></tr>";
  };
  check_once(page, left_out_row("1", "row 0, column 1", "dead", "the output stays near 0 V"));
  check_once(page, left_out_row("2", "row 1, column 0", "stuck", "the output stays at one value other than 0 V"));
  check_once(page, left_out_row("3", "row 1, column 1", "saturated", "the output stood at the limit of the converter"));
  check_once(page, "<tr><th scope=\"row\">4</th><td>row 2, column 0</td>");
  check_once(page, "<td>the output does not change</td>");
  check_once(page, left_out_row("5", "row 2, column 1", "unfit", "the output moves, but not with the pressure"));
  check_once(page, left_out_row("6", "row 3, column 0", "unfit", "the model&#39;s mean error, 0.312 V, is too large"));
  check_once(page, left_out_row("7", "row 3, column 1", "unfit", "no loop was swept"));
  check_none(page, "none was left out");
}

TEST_CASE("what a dynamic model undoes by hand: creep in three times, lag, and the runs that they were taken from") {
  ReportInput input = modelled();
  const auto page = [&] { return model_section(input).value; };
  check_none(page(), "undo: the array&#39;s");
  input.fit.dynamics.emplace();
  check_once(page(), "Creep and lag are left in: the models come from one run");
  Dynamics& d = input.fit.dynamics->shared;
  d.creep_s = {3.1234, 30.0, 300.0};
  d.creep_share = {0.0, 0.02344, 0.0};
  d.creep_half = 10.04;
  const std::string creep =
      "0.00 % in 3.12 s, 2.34 % in 30 s, 0.00 % in 300 s of the output; half of it at " + psi(10.04, 1) + "</td>";
  check_once(page(), "<caption>Creep that the models undo: the array&#39;s</caption>");
  check_once(page(), creep);
  check_once(page(), "<th scope=\"row\">lag</th><td>left in</td>");
  input.fit.dynamics->rate = {1, "abc"};
  input.fit.dynamics->creep = {5, ""};
  d.lag_s = 1.2344;
  d.lag_share = 0.1234;
  check_once(page(), "<caption>Lag and creep that the models undo: the array&#39;s</caption>");
  check_once(page(), "<td>12.3 % of a change of pressure comes late, in 1.23 s</td>");
  check_once(page(), "<th scope=\"row\">lag taken from</th><td>run 1, content <code>abc</code></td>");
  check_once(page(), "<th scope=\"row\">creep taken from</th><td>run 5, content not available</td>");
  d.creep_share = {0.01, 0.01, 0.01};
  check_once(page(), "<td>the fitted run; by taxel: run 5, content not available</td>");
}
