// The section "Uncertainty": budgets by the GUM, U of every level and branch, its map, and what is not assessed.
#include <algorithm>
#include <cmath>

#include "analysis/counted.h"
#include "analysis/report/page/figure.h"
#include "analysis/report/page/gum_numbers.h"
#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"
#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {
namespace {

using html::markup;
using html::Markup;
using html::Text;

// As metrologists call a source; its own name is the key in the data.
std::string quantity_in_words(const SourceText& source) {
  static const std::vector<std::pair<std::string_view, const char*>> words = {
      {"reference, certificate", "measurement standard: certificate"},
      {"reference, drift", "measurement standard: drift"},
      {"reference, resolution", "measurement standard: resolution"},
      {"reference, voltage input", "measurement standard: voltage input that reads it"},
      {"reference, hysteresis", "measurement standard: hysteresis"},
      {"reference, zero", "measurement standard: zero deviation"},
      {"reference, temperature", "measurement standard: temperature"},
      {"chamber uniformity", "uniformity of the pressure in the chamber"},
      {"noise", "short-term repeatability (noise)"},
      {"converter resolution", "resolution of the ADC"},
      {"zero return", "zero deviation"},
      {"creep under load", "creep"},
      {"re-mounting, common", "reproducibility: mounting, common part"},
      {"re-mounting, a taxel's own", "reproducibility: mounting, a taxel’s own part"}};
  for (const auto& [key, text] : words)
    if (key == source.name) return text;
  return source.name;
}

Markup measurand(const Uncertainty& uncertainty, PressureUnit unit) {
  const ReferenceUncertainty& reference = uncertainty.reference;
  Markup out = markup(
      "<p>Measurand: the gauge pressure on one taxel, y, as its corrected indication states it: one frame, measurement "
      "model applied, less the mean error of the full sweeps at its level and branch, at any point of the histories "
      "named below. The expanded uncertainty is stated as the standard uncertainty of measurement u_c(y) multiplied by "
      "the coverage factor k, U = k u_c(y) (JCGM 100 “GUM”, Eq. 18), such that the coverage probability corresponds to "
      "approximately 95 %: k is that of Student’s distribution for 95.45 % at the effective degrees of freedom "
      "(Welch-Satterthwaite, Eq. G.2b). u_c(y) is the root of the sum of the squares of the contributions u_i(y) = "
      "|c_i| u(x_i) (Eq. 10, inputs taken as independent). Sources that are not assessed are listed below and are not "
      "in U.</p>\n");
  out += markup(
      "<p class=\"note\">Measurement standard of pressure: certificate {}, due {}{}; it covers: {}.{} Not included "
      "because negligible: "
      "the height of the air line (below {} a metre at {}).</p>\n",
      html::stated(reference.calibration.certificate), html::stated(reference.calibration.due),
      Text(reference.overdue ? ", overdue when the run began" : ""), Text(in_words(reference.covers)),
      Text(reference.beyond ? fmt::format(" No U is stated where {}.", in_words(*reference.beyond, unit))
                            : std::string()),
      html::pressure(0.01, unit, 2), html::pressure(60.0, unit, 0));
  return out;
}

// c of a source in volts is pressure a millivolt, else a number.
Markup sensitivity(const Contribution& row, bool volts, PressureUnit unit) {
  if (!volts) return markup("{}", html::significant(row.sensitivity, 3));
  return markup("{} {}/mV", html::significant(unit.of(1e-3 * row.sensitivity), 3), Text(unit.symbol()));
}

Markup budget_row(const Contribution& row, const Budget& budget, PressureUnit unit) {
  const SourceText& text = text_of(row.source);
  const double share = budget.combined_psi > 0.0 ? std::pow(row.u_psi / budget.combined_psi, 2) : 0.0;
  Markup out = markup("<tr><th scope=\"row\">{}</th>{}", Text(quantity_in_words(text)),
                      cell(markup("{}", Text(std::string(1, text.type)))));
  // x_i: the error that is taken off; all other estimates are 0.
  const double estimate = row.source == UncertaintySource::kModel ? budget.error_psi : 0.0;
  out += number_cell(html::fixed(unit.of(estimate), gum_decimals(unit.of(budget.expanded_psi))));
  const bool volts = std::string(text.unit) == "V";  // printed as mV
  out += number_cell(markup("{} {}", html::significant(volts ? 1e3 * row.width : unit.of(row.width), 3),
                            Text(volts ? "mV" : unit.symbol())));
  out += cell(Text(text.width));
  out += cell(Text(text.distribution));
  out += number_cell(html::significant(row.divisor, 3));
  out += number_cell(sensitivity(row, volts, unit));
  out += number_cell(gum_uncertainty(unit.of(row.u_psi)));
  out += number_cell(gum_degrees(row.dof));
  out += number_cell(html::percent(share, 1));
  out += markup("</tr>\n");
  return out;
}

// As many columns as budget_row has.
Markup missing_rows(const Uncertainty& uncertainty) {
  Markup out;
  for (std::size_t i = 0; i < kUncertaintySources; ++i) {
    if (uncertainty.missing[i].empty()) continue;
    const SourceText& text = text_of(static_cast<UncertaintySource>(i));
    out += markup("<tr><th scope=\"row\">{}</th><td>{}</td><td colspan=\"9\">not assessed</td></tr>\n",
                  Text(quantity_in_words(text)), Text(std::string(1, text.type)));
  }
  return out;
}

Markup budget_table(const Uncertainty& uncertainty, const Budget& budget, const char* which, int columns,
                    PressureUnit unit) {
  Markup out = markup(
      "<div class=\"wide keep\"><table class=\"levels even\"><caption>Budget of the {} taxel ({}) at {}, {}</caption>"
      "<thead><tr><th scope=\"col\">quantity X_i</th><th scope=\"col\">type</th><th scope=\"col\" class=\"n\">x_i, "
      "{}</th><th scope=\"col\" class=\"n\">a_i or "
      "s(x_i)</th><th scope=\"col\">given as</th><th scope=\"col\">distribution</th><th scope=\"col\" "
      "class=\"n\">divisor</th><th scope=\"col\" class=\"n\">c_i</th><th scope=\"col\" class=\"n\">u_i(y), {}</th><th "
      "scope=\"col\" class=\"n\">ν_i</th><th scope=\"col\" class=\"n\">of u_c², %</th></tr></thead><tbody>\n",
      Text(which), Text(place_of(budget.taxel, columns)), html::pressure(budget.pressure_psi, unit, 1),
      Text(branch_in_words(budget.up)), Text(unit.symbol()), Text(unit.symbol()));
  for (const Contribution& row : budget.contributions) out += budget_row(row, budget, unit);
  out += missing_rows(uncertainty);
  out += markup(
      "<tr><th scope=\"row\">combined</th><td colspan=\"7\">u_c(y), effective degrees of "
      "freedom</td>{}{}{}</tr>\n",
      number_cell(gum_uncertainty(unit.of(budget.combined_psi))), number_cell(gum_degrees(budget.dof)),
      number_cell(Text("100.0")));
  out += markup(
      "<tr><th scope=\"row\">expanded</th><td colspan=\"7\">U = {} u_c(y)</td><td class=\"n\" "
      "colspan=\"3\">{}</td></tr>\n"
      "</tbody></table></div>\n",
      html::fixed(budget.factor, 2), gum_pressure(budget.expanded_psi, unit));
  const int decimals = gum_decimals(unit.of(budget.expanded_psi));
  out += markup(
      "<p class=\"note\">x_i: estimate, which is taken off. The error that is taken off is the mean of {} less the "
      "reference value, and half of creep. "
      "The "
      "corrected indication is then off by 0 ± {} (k = {}). Without this correction the indication less the pressure "
      "lies in [{}, {}] {}.{}</p>\n",
      Text(counted(budget.readings, "reading")), gum_pressure(budget.expanded_psi, unit), html::fixed(budget.factor, 2),
      html::fixed(unit.of(budget.lower_psi()), decimals), html::fixed(unit.of(budget.upper_psi()), decimals),
      Text(unit.symbol()),
      Text(budget.linear ? ""
                         : " ▲ The inverse is not linear within ±2 u of the voltage here: Eq. (10) is a rough "
                           "approximation."));
  return out;
}

Markup basis_table(const Uncertainty& uncertainty, PressureUnit unit) {
  Markup out = markup(
      "<table class=\"pairs\"><caption>How each contribution is evaluated (sections of JCGM 100)</caption><tbody>\n");
  for (std::size_t i = 0; i < kUncertaintySources; ++i) {
    const SourceText& text = text_of(static_cast<UncertaintySource>(i));
    out += markup(
        "<tr><th scope=\"row\">{}</th><td>{}{}{}{}</td></tr>\n", Text(quantity_in_words(text)), Text(text.basis),
        Text(uncertainty.from[i].empty() ? "" : "; "), Text(uncertainty.from[i]),
        uncertainty.missing[i].empty() ? markup("") : markup(". Not assessed: {}", Text(uncertainty.missing[i])));
  }
  out += markup("</tbody></table>\n");
  return out;
}

Markup uncertainty_chart(const Uncertainty& uncertainty, PressureUnit unit) {
  LineChart chart;
  chart.title = "Expanded uncertainty of a corrected indication over pressure, increasing and decreasing";
  chart.x_label = "gauge pressure";
  chart.y_label = "U";
  chart.y_from_zero = true;
  for (const bool up : {true, false}) {
    Series median{fmt::format("median taxel, {}", branch_in_words(up)), {}, {}, up ? 0 : 1};
    Series worst{fmt::format("worst taxel, {}", branch_in_words(up)), {}, {}, up ? 2 : 3};
    for (const LevelUncertainty& level : uncertainty.levels) {
      if (level.up != up) continue;
      for (auto* series : {&median, &worst}) series->x.push_back(level.pressure_psi);
      median.y.push_back(level.median.expanded_psi);
      worst.y.push_back(level.worst.expanded_psi);
    }
    chart.series.push_back(std::move(median));
    chart.series.push_back(std::move(worst));
  }
  return markup(
      "<figure>{}<figcaption>U of one corrected indication; the figures stand in the table "
      "below.</figcaption></figure>\n",
      line_chart(pressures(std::move(chart), unit)));
}

Markup branch_cells(const LevelUncertainty* level, PressureUnit unit) {
  if (level == nullptr) return markup("<td colspan=\"4\">no reading</td>");
  Markup out = number_cell(markup("{}", level->median.readings));
  out += error_cells(*level, unit);
  out += level->not_linear > 0 ? number_cell(markup("▲ {}", level->not_linear)) : number_cell(Text("0"));
  return out;
}

Markup levels_table(const Uncertainty& uncertainty, PressureUnit unit) {
  Markup out = markup(
      "<div class=\"wide\"><table class=\"levels even\"><caption>Error and U at every level; figures of taxels in "
      "{}</caption><thead>"
      "<tr><th scope=\"colgroup\" colspan=\"2\">level</th><th scope=\"colgroup\" colspan=\"4\">increasing</th><th "
      "scope=\"colgroup\" colspan=\"4\">decreasing</th></tr><tr>{}",
      Text(unit.symbol()), level_headings(unit));
  for (int branch = 0; branch < 2; ++branch)
    out += markup(
        "<th scope=\"col\" class=\"n\">n</th><th scope=\"col\" class=\"n\">median taxel</th><th scope=\"col\" "
        "class=\"n\">worst taxel</th><th scope=\"col\" class=\"n\">not linear</th>");
  out += markup("</tr></thead><tbody>\n");
  for (const double pressure : level_pressures(uncertainty)) {
    out +=
        markup("<tr>{}{}{}</tr>\n", level_cells(pressure, unit), branch_cells(uncertainty.level(pressure, true), unit),
               branch_cells(uncertainty.level(pressure, false), unit));
  }
  out += markup(
      "</tbody></table></div>\n<p class=\"note\">Error: mean of the n readings of full sweeps less the reference "
      "value, and "
      "half of creep, which is taken off; ± U of one corrected indication. Median and worst taxel: by U, at each level "
      "and branch anew. The turn at the top counts as increasing. Not linear: taxels whose inverse bends, or ends, "
      "within ±2 u of the voltage while the voltage has more "
      "than a tenth of the variance; their U is a rough approximation.</p>\n");
  return out;
}

Markup ranges(const Uncertainty& uncertainty, PressureUnit unit) {
  const double full = level_pressures(uncertainty).back();
  Markup out = markup(
      "<table class=\"pairs\"><caption>Measuring interval: where U of 95 % of the taxels is within a share of the full "
      "pressure</caption><tbody>\n");
  for (const double share : {0.005, 0.01, 0.02}) {
    out += markup("<tr><th scope=\"row\">{} %: {}</th><td>{}; {}</td></tr>\n", html::percent(share, 1),
                  html::pressure(share * full, unit, 2), range_within(uncertainty, true, share * full, unit),
                  range_within(uncertainty, false, share * full, unit));
  }
  out += markup("</tbody></table>\n");
  return out;
}

}  // namespace

Markup uncertainty_section(const ReportInput& input) {
  Markup out = section_start("uncertainty", "Uncertainty");
  if (!input.uncertainty || input.uncertainty->levels.empty()) {
    out += markup(
        "<p>Not assessed: the uncertainty rests on a run’s frames and models, which this report was not given.</p>\n");
    return out;
  }
  const Uncertainty& uncertainty = *input.uncertainty;
  const LevelUncertainty& chosen = uncertainty.levels[uncertainty.chosen];
  const PressureUnit unit = input.unit;
  out += measurand(uncertainty, unit);
  out += conditions_part(input);
  out += budget_table(uncertainty, chosen.median, "median", input.fit.columns, unit);
  out += budget_table(uncertainty, chosen.worst, "worst", input.fit.columns, unit);
  out += basis_table(uncertainty, unit);
  out += uncertainty_chart(uncertainty, unit);
  out += ranges(uncertainty, unit);
  out += levels_table(uncertainty, unit);
  out += array_uncertainty_part(input);
  return out;
}

}  // namespace tactbench::analysis
