// The section "Uncertainty": U of figures of the whole array, and U of each taxel at the chosen level as a map.
#include "analysis/report/page/figure.h"
#include "analysis/report/page/gum_numbers.h"
#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {
namespace {

using html::markup;
using html::Markup;
using html::Text;

Markup array_table(const Uncertainty& uncertainty, PressureUnit unit) {
  Markup out = markup(
      "<div class=\"wide\"><table class=\"levels even\"><caption>U of figures of the whole array, evenly loaded: mean "
      "pressure (total force: times the area of the array), centre of pressure</caption><thead><tr>{}<th "
      "scope=\"col\">branch</th><th scope=\"col\" class=\"n\">U, mean pressure</th><th scope=\"col\" class=\"n\">U, "
      "centre of pressure, pitches</th></tr></thead><tbody>\n",
      level_headings(unit));
  for (const LevelUncertainty& level : uncertainty.levels)
    out += markup("<tr>{}<td>{}</td>{}{}</tr>\n", level_cells(level.pressure_psi, unit),
                  Text(branch_in_words(level.up)), number_cell(gum_pressure(level.array.mean_expanded_psi, unit)),
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
  const PressureUnit unit = input.unit;
  const std::string title = fmt::format("Expanded uncertainty U of each taxel in {} at {}, {}", unit.symbol(),
                                        html::pressure(level.pressure_psi, unit, 1).value, branch_in_words(level.up));
  Markup out = markup(
      "<figure>{}",
      numbered_map(pressure_map({title, input.fit.rows, input.fit.columns, level.expanded_psi, scale, 416.0}, unit),
                   kTwoSignificant));
  out += pressure_bar(scale, "Colour scale of the map of U", unit, 2);
  out += markup(
      "<figcaption>{}. Row 0 on top, column 0 on the left; a cross marks a taxel without a model. The maps of "
      "all levels stand in the data of this file.</figcaption></figure>\n",
      Text(title));
  return out;
}

}  // namespace

Markup array_uncertainty_part(const ReportInput& input) {
  const Uncertainty& uncertainty = *input.uncertainty;
  Markup out = array_table(uncertainty, input.unit);
  out += map_of(input, uncertainty.levels[uncertainty.chosen]);
  return out;
}

}  // namespace tactbench::analysis
