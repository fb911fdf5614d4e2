// Page 4: error and uncertainty at every level.
#include <algorithm>
#include <cmath>
#include <set>

#include "analysis/report/document/printers.h"
#include "analysis/report/page/chart.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {

namespace {

using doc::Document;
using doc::Phrase;

bool inside(const MeasuringInterval& span, double psi) {
  return span.any && psi >= span.low_psi && psi <= span.high_psi;
}

std::string direction_title(bool up, const char* name) {
  return fmt::format("{} | {}", up ? "increasing" : "decreasing", name);
}

void add_direction(const ReadingFigures& readings, double psi, bool up, int columns, doc::Row& row) {
  const ReadingLevel* const level = readings.level(psi, up);
  if (level == nullptr) {
    row.cells.insert(row.cells.end(), {"–", "–", "–", "–", "–"});
    return;
  }
  const bool within = inside(up ? readings.span_up : readings.span_down, psi);
  const doc::Quantity sum = doc::bare_pressure(level->within_psi);
  row.cells.push_back(doc::bare_pressure(level->median_error_psi));
  row.cells.push_back(doc::bare_pressure(level->median_expanded_psi));
  row.cells.push_back(within ? Phrase(doc::Words{"✓ ", doc::Look::kGood}, sum) : Phrase(sum));
  row.cells.push_back(doc::bare_pressure(level->worst_psi));
  row.cells.push_back(doc::Taxel{level->worst, columns});
}

doc::Table levels_table(const ReadingFigures& readings, int columns, PressureUnit unit) {
  std::set<double> pressures;
  for (const ReadingLevel& level : readings.levels) pressures.insert(level.pressure_psi);
  doc::Table table{.id = "levels",
                   .caption = fmt::format("All errors and U in {}", unit.symbol()),
                   .columns = {{unit.symbol(), true}, {unit.beside().symbol(), true}},
                   .dense = true,
                   .keep = pressures.size() < 40};
  for (const bool up : {true, false})
    for (const char* name :
         {"median\nerror", "median\nU", "95 % of taxels\n|error| + U", "worst taxel\n|error| + U", "which"})
      table.columns.push_back({direction_title(up, name), true});
  for (const double psi : pressures) {
    doc::Row row{{doc::bare_pressure(psi), Phrase(doc::quiet(doc::text_of(doc::bare_pressure(psi), unit.beside())))}};
    for (const bool up : {true, false}) add_direction(readings, psi, up, columns, row);
    table.rows.push_back(std::move(row));
  }
  return table;
}

doc::Figure uncertainty_chart(const ReadingFigures& readings, bool up, PressureUnit unit) {
  Chart chart{.title = fmt::format("U of a reading, {}", up ? "increasing" : "decreasing"),
              .heading = fmt::format("U in {}, {}", unit.symbol(), up ? "increasing" : "decreasing"),
              .width = 336.0,
              .height = 128.0,
              .x = {fmt::format("gauge pressure in {}", unit.symbol()), 0.0, unit.of(readings.full_psi)},
              .y = {.label = "", .low = {}, .high = {}, .logarithmic = true},
              .labels_at_ends = true,
              .heading_stroke = up ? kBlue : kBrown};
  const char* const colour = up ? kBlue.colour : kBrown.colour;
  for (const auto& [name, figure, dashes] : {std::tuple{"95 % of taxels", &ReadingLevel::expanded_within_psi, "6 3"},
                                             std::tuple{"median taxel", &ReadingLevel::median_expanded_psi, ""},
                                             std::tuple{"mean of all", &ReadingLevel::mean_expanded_psi, "2 2"}}) {
    Curve curve{name, {}, {}, {colour, dashes, 1.4}};
    for (const ReadingLevel& level : readings.levels) {
      if (level.up != up) continue;
      curve.x.push_back(unit.of(level.pressure_psi));
      curve.y.push_back(unit.of(level.*figure));
    }
    chart.curves.push_back(std::move(curve));
  }
  return {chart_svg(chart), chart.title, {}};
}

}  // namespace

Document every_level(const PageData& data) {
  Document out;
  if (!data.readings) return out;
  const ReadingFigures& readings = *data.readings;
  const PressureUnit unit = data.input.unit;
  out.add(doc::Heading{2, "Error and uncertainty at every level", {}});
  out.add(levels_table(readings, data.input.health.columns, unit));
  if (!readings.known()) {
    out.add(doc::Paragraph{{"Error: mean corrected indication of full sweeps less the reference value. U of a reading "
                            "was not established for any history: ",
                            doc::Words{"why", doc::Look::kPlain, "kinds"}, "."},
                           doc::Paragraph::kNote});
    return out;
  }
  out.add(doc::Paragraph{{"Error: mean corrected indication less the reference value, for “", readings.kind,
                          "”. U: expanded uncertainty of one corrected indication, coverage probability about 95 %. 95 "
                          "% of taxels: the value that |error| + U does not exceed for them. The worst taxel may be "
                          "another one at each level; worst of all: page 1. ✓: within the measuring interval, ",
                          doc::both_units(readings.tolerance_psi),
                          ". The error is known and may be taken off; U then remains. Error, U and k of each taxel and "
                          "level are in the data (report --format json)."},
                         doc::Paragraph::kNote});
  doc::Beside charts;
  for (const bool up : {true, false}) {
    Document part;
    part.add(uncertainty_chart(readings, up, unit));
    charts.parts.push_back(std::move(part));
  }
  out.add(doc::Heading{3, "U of one taxel, and of the mean of all", {}});
  out.add(std::move(charts));
  return out;
}

}  // namespace tactbench::analysis
