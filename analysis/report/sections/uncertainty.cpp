// The section "Uncertainty": budgets by the GUM, U of every level and branch, its map, and what is not assessed.
#include <algorithm>
#include <cmath>

#include "analysis/counted.h"
#include "analysis/report/page/figure.h"
#include "analysis/report/page/gum_numbers.h"
#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {
namespace {

using html::markup;
using html::Markup;
using html::Text;

constexpr double kPsiToKpa = 6.894757293168;

const char* branch_word(bool up) { return up ? "loading" : "unloading"; }

Markup measurand(const Uncertainty& uncertainty) {
  const ReferenceUncertainty& reference = uncertainty.reference;
  Markup out = markup(
      "<p>Measurand: the pressure on one taxel, as one compensated frame states it, corrected for the mean error of "
      "the "
      "full sweeps at its level and branch, at any point of the histories named below. The stated U is the expanded "
      "uncertainty U = k u_c (JCGM 100 “GUM”, Eq. 18) with k from Student’s distribution for 95.45 % at the effective "
      "degrees of freedom (Welch-Satterthwaite, Eq. G.2b); u_c is the root of the sum of the squares of the shares |c| "
      "u(x) (Eq. 10, inputs taken as independent). Sources that are not assessed are listed below and are not in "
      "U.</p>\n");
  out += markup(
      "<p class=\"note\">Reference: certificate {}, due {}{}. Not included because negligible: the height of the "
      "air line (below 0.01 psi a metre at 60 psi).</p>\n",
      html::stated(reference.calibration.certificate), html::stated(reference.calibration.due),
      Text(reference.overdue ? ", overdue when the run began" : ""));
  return out;
}

Markup budget_row(const Contribution& row, const Budget& budget) {
  const SourceText& text = text_of(row.source);
  const double share = budget.combined_psi > 0.0 ? std::pow(row.u_psi / budget.combined_psi, 2) : 0.0;
  Markup out =
      markup("<tr><th scope=\"row\">{}</th>{}", Text(text.name), cell(markup("{}", Text(std::string(1, text.type)))));
  const bool volts = std::string(text.unit) == "V";  // printed as mV
  out += number_cell(
      markup("{} {}", html::significant(volts ? 1e3 * row.width : row.width, 3), Text(volts ? "mV" : "psi")));
  out += cell(Text(text.width));
  out += cell(Text(text.distribution));
  out += number_cell(html::significant(row.divisor, 3));
  out += number_cell(html::significant(volts ? 1e-3 * row.sensitivity : row.sensitivity, 3));
  out += number_cell(gum_uncertainty(row.u_psi));
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
    out += markup("<tr><th scope=\"row\">{}</th><td>{}</td><td colspan=\"8\">not assessed</td></tr>\n", Text(text.name),
                  Text(std::string(1, text.type)));
  }
  return out;
}

Markup budget_table(const Uncertainty& uncertainty, const Budget& budget, const char* which, int columns) {
  Markup out = markup(
      "<div class=\"wide keep\"><table class=\"levels even\"><caption>Budget of the {} taxel ({}) at {}, {}</caption>"
      "<thead><tr><th scope=\"col\">contribution</th><th scope=\"col\">type</th><th scope=\"col\" class=\"n\">width"
      "</th><th scope=\"col\">what it is</th><th scope=\"col\">distribution</th><th scope=\"col\" class=\"n\">divisor"
      "</th><th scope=\"col\" class=\"n\">c</th><th scope=\"col\" class=\"n\">u, psi</th><th scope=\"col\" "
      "class=\"n\">ν</th><th scope=\"col\" class=\"n\">share, %</th></tr></thead><tbody>\n",
      Text(which), Text(place_of(budget.taxel, columns)), html::psi(budget.pressure_psi, 1),
      Text(branch_word(budget.up)));
  for (const Contribution& row : budget.contributions) out += budget_row(row, budget);
  out += missing_rows(uncertainty);
  out += markup(
      "<tr><th scope=\"row\">combined</th><td colspan=\"6\">u_c, effective degrees of "
      "freedom</td>{}{}{}</tr>\n",
      number_cell(gum_uncertainty(budget.combined_psi)), number_cell(gum_degrees(budget.dof)),
      number_cell(Text("100.0")));
  out += markup(
      "<tr><th scope=\"row\">expanded</th><td colspan=\"6\">U = {} u_c</td><td class=\"n\" colspan=\"3\">{} psi ({} "
      "kPa)</td></tr>\n</tbody></table></div>\n",
      html::fixed(budget.factor, 2), gum_uncertainty(budget.expanded_psi),
      gum_uncertainty(kPsiToKpa * budget.expanded_psi));
  out += markup(
      "<p class=\"note\">c: psi per unit of the width. Error that is taken off (mean of {} less the reference, and "
      "half of "
      "creep): the corrected reading is off by 0 ± {} psi (k = {}); for who does not correct, a reading less the "
      "pressure "
      "lies in [{}, {}] psi.{}</p>\n",
      Text(counted(budget.readings, "reading")), gum_uncertainty(budget.expanded_psi), html::fixed(budget.factor, 2),
      html::fixed(budget.lower_psi(), gum_decimals(budget.expanded_psi)),
      html::fixed(budget.upper_psi(), gum_decimals(budget.expanded_psi)),
      Text(budget.linear ? ""
                         : " ▲ The inverse is not linear within ±2 u of the voltage here: Eq. (10) is a rough "
                           "approximation."));
  return out;
}

Markup basis_table(const Uncertainty& uncertainty) {
  Markup out = markup(
      "<table class=\"pairs\"><caption>How each contribution is found (sections of JCGM 100)</caption><tbody>\n");
  for (std::size_t i = 0; i < kUncertaintySources; ++i) {
    const SourceText& text = text_of(static_cast<UncertaintySource>(i));
    out += markup(
        "<tr><th scope=\"row\">{}</th><td>{}{}{}{}</td></tr>\n", Text(text.name), Text(text.basis),
        Text(uncertainty.from[i].empty() ? "" : "; "), Text(uncertainty.from[i]),
        uncertainty.missing[i].empty() ? markup("") : markup(". Not assessed: {}", Text(uncertainty.missing[i])));
  }
  out += markup("</tbody></table>\n");
  return out;
}

Markup chart(const Uncertainty& uncertainty) {
  LineChart chart;
  chart.title = "Expanded uncertainty of a compensated reading over pressure, loading and unloading";
  chart.x_label = "pressure, psi";
  chart.y_label = "U, psi";
  chart.y_from_zero = true;
  for (const bool up : {true, false}) {
    Series median{fmt::format("median taxel, {}", branch_word(up)), {}, {}, up ? 0 : 1};
    Series worst{fmt::format("worst taxel, {}", branch_word(up)), {}, {}, up ? 2 : 3};
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
      "<figure>{}<figcaption>U (k for 95.45 %) of one compensated reading; the figures stand in the table "
      "below. 1 psi = 6.895 kPa.</figcaption></figure>\n",
      line_chart(chart));
}

Markup branch_cells(const LevelUncertainty* level) {
  if (level == nullptr) return markup("<td colspan=\"4\">no reading</td>");
  Markup out = number_cell(markup("{}", level->median.readings));
  for (const Budget* budget : {&level->median, &level->worst})
    out += number_cell(gum_value(budget->error_psi, budget->expanded_psi));
  out += level->not_linear > 0 ? number_cell(markup("▲ {}", level->not_linear)) : number_cell(Text("0"));
  return out;
}

Markup levels_table(const Uncertainty& uncertainty) {
  Markup out = markup(
      "<div class=\"wide\"><table class=\"levels even\"><caption>Error and U at every level, psi</caption><thead><tr>"
      "<th scope=\"colgroup\" colspan=\"2\">level</th><th scope=\"colgroup\" colspan=\"4\">loading</th><th "
      "scope=\"colgroup\" colspan=\"4\">unloading</th></tr><tr><th scope=\"col\" class=\"n\">psi</th><th scope=\"col\" "
      "class=\"n\">kPa</th>");
  for (int branch = 0; branch < 2; ++branch)
    out += markup(
        "<th scope=\"col\" class=\"n\">n</th><th scope=\"col\" class=\"n\">median taxel</th><th scope=\"col\" "
        "class=\"n\">worst taxel</th><th scope=\"col\" class=\"n\">not linear</th>");
  out += markup("</tr></thead><tbody>\n");
  std::vector<double> pressures;
  for (const LevelUncertainty& level : uncertainty.levels) pressures.push_back(level.pressure_psi);
  std::ranges::sort(pressures);
  const auto same = std::ranges::unique(pressures);
  pressures.erase(same.begin(), same.end());
  for (const double pressure : pressures) {
    out += markup("<tr><th scope=\"row\" class=\"n\">{}</th>{}{}{}</tr>\n", html::fixed(pressure, 1),
                  number_cell(html::kilopascals(pressure, 1)), branch_cells(uncertainty.level(pressure, true)),
                  branch_cells(uncertainty.level(pressure, false)));
  }
  out += markup(
      "</tbody></table></div>\n<p class=\"note\">Error: mean of the n readings of full sweeps less the reference, and "
      "half "
      "of creep, which is taken off; ± U of one corrected reading. Median and worst taxel: by U, at each level and "
      "branch anew. The turn at the top is read while "
      "loading. Not linear: taxels whose inverse bends, or ends, within ±2 u of the voltage while the voltage has more "
      "than a tenth of the variance; their U is a rough approximation.</p>\n");
  return out;
}

// The longest row of levels where the median taxel's U is within a share of the full pressure.
Markup range_within(const Uncertainty& uncertainty, bool up, double most_psi) {
  double low = 0.0, high = 0.0, begin = 0.0, end = 0.0;
  bool inside = false, any = false;
  for (const LevelUncertainty& level : uncertainty.levels) {
    if (level.up != up) continue;
    const bool within = level.median.expanded_psi <= most_psi;
    if (within) {
      if (!inside) begin = level.pressure_psi;
      end = level.pressure_psi;
      if (!any || end - begin > high - low) {
        low = begin;
        high = end;
      }
      any = true;
    }
    inside = within;
  }
  if (!any) return markup("{}: at no level", Text(branch_word(up)));
  return markup("{}: {} to {} psi", Text(branch_word(up)), html::fixed(low, 1), html::fixed(high, 1));
}

Markup ranges(const Uncertainty& uncertainty) {
  double full = 0.0;
  for (const LevelUncertainty& level : uncertainty.levels) full = std::max(full, level.pressure_psi);
  Markup out = markup(
      "<table class=\"pairs\"><caption>Where U of the median taxel is within a share of the full pressure</caption>"
      "<tbody>\n");
  for (const double share : {0.005, 0.01, 0.02}) {
    out += markup("<tr><th scope=\"row\">{} %: {}</th><td>{}; {}</td></tr>\n", html::percent(share, 1),
                  html::psi(share * full, 2), range_within(uncertainty, true, share * full),
                  range_within(uncertainty, false, share * full));
  }
  out += markup("</tbody></table>\n");
  return out;
}

Markup array_table(const Uncertainty& uncertainty) {
  Markup out = markup(
      "<div class=\"wide\"><table class=\"levels even\"><caption>U of figures of the whole array, evenly loaded: mean "
      "pressure in psi (total force: times the area of the array), centre of pressure in pitches</caption><thead><tr>"
      "<th scope=\"col\" class=\"n\">psi</th><th scope=\"col\">branch</th><th scope=\"col\" class=\"n\">U, mean "
      "pressure"
      "</th><th scope=\"col\" class=\"n\">U, centre of pressure</th></tr></thead><tbody>\n");
  for (const LevelUncertainty& level : uncertainty.levels)
    out += markup("<tr><th scope=\"row\" class=\"n\">{}</th><td>{}</td>{}{}</tr>\n", html::fixed(level.pressure_psi, 1),
                  Text(branch_word(level.up)), number_cell(gum_uncertainty(level.array.mean_expanded_psi)),
                  number_cell(html::significant(level.array.centre_expanded, 2)));
  out += markup(
      "</tbody></table></div>\n<p class=\"note\">What all taxels have in common adds up, what is a taxel’s own "
      "averages "
      "out; a common part moves no centre of pressure.</p>\n");
  return out;
}

Markup map_of(const ReportInput& input, const LevelUncertainty& level) {
  const double high = spread_of(level.expanded_psi).high;
  const ColourScale scale{0.0, high > 0.0 ? high : 1.0};
  const std::string title = fmt::format("Expanded uncertainty U of each taxel in psi at {:.1f} psi, {}",
                                        level.pressure_psi, branch_word(level.up));
  Markup out = markup(
      "<figure>{}",
      numbered_map({title, input.fit.rows, input.fit.columns, level.expanded_psi, scale, 416.0}, high < 10.0 ? 2 : 1));
  out += colour_bar(scale, "Colour scale of the map of U", "psi", 2);
  out += markup(
      "<figcaption>{}. Row 0 on top, column 0 on the left; a cross marks a taxel without a model. The maps of "
      "all levels stand in the data of this file.</figcaption></figure>\n",
      Text(title));
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
  out += measurand(uncertainty);
  out += conditions_part(input);
  out += budget_table(uncertainty, chosen.median, "median", input.fit.columns);
  out += budget_table(uncertainty, chosen.worst, "worst", input.fit.columns);
  out += basis_table(uncertainty);
  out += chart(uncertainty);
  out += ranges(uncertainty);
  out += levels_table(uncertainty);
  out += array_table(uncertainty);
  out += map_of(input, chosen);
  return out;
}

}  // namespace tactbench::analysis
