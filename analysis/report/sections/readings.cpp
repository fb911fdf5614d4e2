// Page 1: what a corrected indication is worth, before the budgets: range of use, error and U at some levels, the
// largest error. The section "Uncertainty" prints the same assessment whole.
#include <algorithm>
#include <set>

#include "analysis/report/data/judged_runs.h"
#include "analysis/report/page/gum_numbers.h"
#include "analysis/report/sections/sections.h"
#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::Text;

namespace {

constexpr double kTaxelsWithin = 0.95;
constexpr double kShareOfUse = 0.02;  // of the full pressure: U within it on page 1
constexpr std::size_t kSpreadLevels = 4;

const LevelUncertainty& worst_level(const Uncertainty& uncertainty) {
  return *std::ranges::max_element(uncertainty.levels, {},
                                   [](const LevelUncertainty& level) { return level.worst.expanded_psi; });
}

// Levels spread over the range, its ends among them, and the one with the largest U.
std::set<double> shown_levels(const Uncertainty& uncertainty) {
  const std::vector<double> all = level_pressures(uncertainty);
  std::set<double> shown = {worst_level(uncertainty).pressure_psi};
  for (std::size_t i = 0; i < kSpreadLevels; ++i) shown.insert(all[i * (all.size() - 1) / (kSpreadLevels - 1)]);
  return shown;
}

Markup direction_cells(const LevelUncertainty* level, const LevelUncertainty& worst, PressureUnit unit) {
  if (level == nullptr) return markup("<td class=\"n\" colspan=\"2\">no reading</td>");
  return error_cells(*level, unit, level == &worst ? "▲ " : "");
}

Markup levels_in_brief(const Uncertainty& uncertainty, int columns, PressureUnit unit) {
  const LevelUncertainty& worst = worst_level(uncertainty);
  Markup out = markup(
      "<table class=\"levels even keep\"><caption>Corrected indication: error and U at some levels, in {}</caption>"
      "<thead><tr><th scope=\"colgroup\" colspan=\"2\">level</th><th scope=\"colgroup\" colspan=\"2\">increasing"
      "</th><th scope=\"colgroup\" colspan=\"2\">decreasing</th></tr><tr>{}",
      Text(unit.symbol()), level_headings(unit));
  for (int branch = 0; branch < 2; ++branch)
    out += markup("<th scope=\"col\" class=\"n\">median taxel</th><th scope=\"col\" class=\"n\">worst taxel</th>");
  out += markup("</tr></thead><tbody>\n");
  for (const double pressure : shown_levels(uncertainty))
    out += markup("<tr>{}{}{}</tr>\n", level_cells(pressure, unit),
                  direction_cells(uncertainty.level(pressure, true), worst, unit),
                  direction_cells(uncertainty.level(pressure, false), worst, unit));
  out += markup(
      "</tbody></table>\n<p class=\"note\">Error: mean of full sweeps less the reference value, which is taken off; "
      "± U of one corrected indication (coverage probability approximately 95 %). Median and worst taxel: by U, at "
      "each "
      "level and direction anew. ▲: the largest U of all levels, taxel {}. All levels: <a "
      "href=\"#uncertainty\">Uncertainty</a>.</p>\n",
      Text(place_of(worst.worst.taxel, columns)));
  return out;
}

Markup range_of_use(const Uncertainty& uncertainty, PressureUnit unit) {
  const std::vector<double> levels = level_pressures(uncertainty);
  return markup("{} to {}", html::pressure(levels.front(), unit, 1), html::pressure(levels.back(), unit, 1));
}

Markup measuring_interval(const Uncertainty& uncertainty, PressureUnit unit) {
  const double most_psi = kShareOfUse * level_pressures(uncertainty).back();
  return markup("U of 95 % of the taxels is within {} % of the full pressure, {}: {}; {}",
                html::percent(kShareOfUse, 0), html::pressure(most_psi, unit, 2),
                range_within(uncertainty, true, most_psi, unit), range_within(uncertainty, false, most_psi, unit));
}

// Over the report's own run and those held out.
Markup largest_error(const ReportInput& input) {
  const Evaluation* largest = &input.evaluation;
  std::string title = title_of_judged(input, input.run.run);
  for (const HeldOut& held_out : input.held_out) {
    if (!(held_out.evaluation.max_error_psi > largest->max_error_psi)) continue;
    largest = &held_out.evaluation;
    title = held_out.title;
  }
  if (largest->max_error_taxel < 0) return markup("not available");
  return markup("{}: taxel {}, at {}, {}", html::pressure(largest->max_error_psi, input.unit, 2),
                Text(place_of(largest->max_error_taxel, input.fit.columns)),
                html::pressure(largest->max_error_at_psi, input.unit, 1), Text(title));
}

}  // namespace

std::vector<double> level_pressures(const Uncertainty& uncertainty) {
  std::set<double> pressures;
  for (const LevelUncertainty& level : uncertainty.levels) pressures.insert(level.pressure_psi);
  return {pressures.begin(), pressures.end()};
}

Markup error_cells(const LevelUncertainty& level, PressureUnit unit, const char* mark) {
  Markup out = number_cell(gum_pressure(level.median.error_psi, level.median.expanded_psi, unit));
  out += number_cell(markup("{}{}", Text(mark), gum_pressure(level.worst.error_psi, level.worst.expanded_psi, unit)));
  return out;
}

// The longest row of levels where U of 95 % of the taxels is within a share of the full pressure.
Markup range_within(const Uncertainty& uncertainty, bool up, double most_psi, PressureUnit unit) {
  double low = 0.0, high = 0.0, begin = 0.0, end = 0.0;
  bool inside = false, any = false;
  for (const LevelUncertainty& level : uncertainty.levels) {
    if (level.up != up) continue;
    const bool within = quantile_of(finite_of(level.expanded_psi), kTaxelsWithin) <= most_psi;
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
  if (!any) return markup("{}: at no level", Text(branch_in_words(up)));
  if (low == high) return markup("{}: at {} alone", Text(branch_in_words(up)), html::pressure(low, unit, 1));
  return markup("{}: {} to {}", Text(branch_in_words(up)), html::pressure(low, unit, 1), html::pressure(high, unit, 1));
}

Markup readings_in_brief(const ReportInput& input) {
  if (input.evaluation.levels.empty()) return {};
  const bool assessed = states_uncertainty(input);
  std::vector<Pair> rows;
  if (assessed) {
    rows.push_back({"range of use", range_of_use(*input.uncertainty, input.unit)});
    rows.push_back({"measuring interval", measuring_interval(*input.uncertainty, input.unit)});
  } else {
    rows.push_back({"range of use", markup("U was not assessed: no range can be stated")});
  }
  rows.push_back({"largest |error| of one frame and taxel", largest_error(input)});
  Markup out = pairs_table("Use of the corrected indication", rows);
  if (assessed) out += levels_in_brief(*input.uncertainty, input.fit.columns, input.unit);
  return out;
}

}  // namespace tactbench::analysis
