// Page 5: the array at one level, spread over the taxels, the worst of them, sensitivity, as found and as left, health.
#include <algorithm>
#include <cmath>
#include <set>

#include "analysis/counted.h"
#include "analysis/report/document/document.h"
#include "analysis/report/page/chart.h"
#include "analysis/report/report_facts.h"
#include "analysis/report/sections/sections.h"
#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {

namespace {

using doc::Document;
using doc::Phrase;

constexpr std::size_t kWorstListed = 6;
constexpr std::size_t kFindingsListed = 10;
constexpr double kMapLevelShare = 2.0 / 3.0;  // of the full pressure

std::vector<double> sums_in(const ReadingLevel& level, PressureUnit unit) {
  std::vector<double> sums;
  for (std::size_t i = 0; i < level.error_psi.size(); ++i) sums.push_back(unit.of(level.sum_psi(i)));
  return sums;
}

// The level nearest to two thirds of the full pressure that was read in both directions.
double level_of_maps(const ReadingFigures& readings) {
  double best = kNan;
  const double wanted = kMapLevelShare * readings.full_psi;
  for (const ReadingLevel& level : readings.levels)
    if (readings.level(level.pressure_psi, !level.up) != nullptr &&
        !(std::abs(level.pressure_psi - wanted) >= std::abs(best - wanted)))
      best = level.pressure_psi;
  return best;
}

TaxelMap error_map(const ReadingFigures& readings, const ReadingLevel& level, const Health& health, PressureUnit unit) {
  const double tolerance = unit.of(readings.tolerance_psi);
  return {.title = fmt::format("|error| + U of each taxel, {}", level.up ? "increasing" : "decreasing"),
          .rows = health.rows,
          .columns = health.columns,
          .values = sums_in(level, unit),
          .low = 0.1 * tolerance,
          .high = 4.0 * tolerance,
          .logarithmic = true,
          .bold_above = tolerance,
          .size = 300.0,
          .numbered = true};
}

doc::Drawing map_figure(const ReadingFigures& readings, const ReadingLevel& level, const Health& health,
                        PressureUnit unit) {
  const TaxelMap map = error_map(readings, level, health, unit);
  const auto all = std::ranges::count_if(map.values, [](double value) { return std::isfinite(value); });
  const auto within = std::ranges::count_if(map.values, [&](double value) { return value <= map.bold_above; });
  return {taxel_map_svg(map),
          map.title,
          {doc::strong(fmt::format("|error| + U in {} at {}, {}.", unit.symbol(),
                                   doc::text_of(doc::both_units(level.pressure_psi), unit),
                                   level.up ? "increasing" : "decreasing")),
           fmt::format(" {} of {} taxels within {}; the others in bold.", within, all,
                       doc::text_of(doc::pressure(readings.tolerance_psi), unit))}};
}

doc::Drawing spread(const ReadingFigures& readings, const ReadingLevel& level, PressureUnit unit) {
  const std::vector<double> sums = finite_of(sums_in(level, unit));
  const double tolerance = unit.of(readings.tolerance_psi), within = unit.of(level.within_psi);
  const double high = 1.6 * std::max(tolerance, within);
  Chart chart{.title = fmt::format("Number of taxels by |error| + U, {}", level.up ? "increasing" : "decreasing"),
              .width = 322.0,
              .height = 150.0,
              .x = {fmt::format("|error| + U in {}, {} (last bar: and more)", unit.symbol(),
                                level.up ? "increasing" : "decreasing"),
                    0.0, high},
              .y = {"taxels"}};
  chart.bars.push_back(bars_of(sums, 0.0, high, 20));
  const auto mark = [&](const char* name, double value, const Stroke& stroke) {
    chart.rules.push_back({value, fmt::format("{} {}", name, doc::fixed_text(value, 1)), stroke, true});
  };
  mark("median", quantile_of(sums, 0.5), {"#0b5cad", "4 2"});
  mark(readings.by_mpe ? "limit" : "2 %:", tolerance, kRed);
  mark("95 %:", within, {"#0b5cad", "4 2"});
  return {chart_svg(chart), chart.title, {}};
}

doc::Table worst_taxels(const ReadingFigures& readings, double psi, int columns, PressureUnit unit) {
  const ReadingLevel &up = *readings.level(psi, true), &down = *readings.level(psi, false);
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < up.error_psi.size(); ++i)
    if (std::isfinite(up.sum_psi(i)) && std::isfinite(down.sum_psi(i))) order.push_back(i);
  const auto larger = [&](std::size_t i) { return std::max(up.sum_psi(i), down.sum_psi(i)); };
  std::ranges::stable_sort(order, std::greater<>(), larger);
  order.resize(std::min(order.size(), kWorstListed));
  doc::Table table{.id = "largest",
                   .caption = fmt::format("Largest |error| + U at {}", doc::text_of(doc::pressure(psi), unit)),
                   .columns = {{"taxel"},
                               {fmt::format("increasing\nerror ± U, {}", unit.symbol()), true},
                               {fmt::format("decreasing\nerror ± U, {}", unit.symbol()), true}},
                   .dense = true};
  for (const std::size_t i : order)
    table.rows.push_back(
        {{doc::Taxel{static_cast<int>(i), columns}, doc::bare_pressure_with_u(up.error_psi[i], up.expanded_psi[i]),
          doc::bare_pressure_with_u(down.error_psi[i], down.expanded_psi[i])}});
  return table;
}

doc::Drawing sensitivity(const ReportInput& input) {
  const Behaviour& b = input.behaviour;
  const std::vector<double> gains = finite_of(b.gain);
  const auto [least, most] = std::ranges::minmax(gains);
  const double reach = std::max({1.0 - least, most - 1.0, 0.05});
  const TaxelMap map{.title = "Relative sensitivity before correction",
                     .rows = input.health.rows,
                     .columns = input.health.columns,
                     .values = b.gain,
                     .low = 1.0 - reach,
                     .high = 1.0 + reach,
                     .two_sided = true,
                     .size = 168.0};
  return {taxel_map_svg(map),
          map.title,
          {doc::strong("Output of each taxel over the mean"), " at ", doc::pressure(b.equilibration_psi),
           ", increasing, before correction: ", doc::number(least, 2), " (brown) to ", doc::number(most, 2),
           " (blue), standard deviation ", doc::percent_of(sample_deviation(gains), 1), " %.",
           input.more.studies.uniformity.assessed()
               ? ""
               : " A non-uniform pressure in the chamber would look the same; it was not assessed."}};
}

doc::Table found_and_left(const PageData& data) {
  const ReportInput& input = data.input;
  const AsFound& found = *input.more.previous;
  const Evaluation &then = found.evaluation, &now = input.evaluation;
  doc::Table table{.id = "as-found",
                   .caption = "As found, as left: this run read with the models from before (" + found.model +
                              "), and with those made from it",
                   .columns = {{"figure"}, {"as found", true}, {"as left", true}},
                   .dense = true};
  const auto row = [&](const char* name, const Phrase& before, const Phrase& after) {
    table.rows.push_back({{name, before, after}});
  };
  row("mean |error|", doc::pressure(then.mean_error_psi, 2), doc::pressure(now.mean_error_psi, 2));
  row("worst taxel’s mean |error|", doc::pressure(then.worst_taxel_mean_error_psi, 2),
      doc::pressure(now.worst_taxel_mean_error_psi, 2));
  row("largest |error|", doc::pressure(then.max_error_psi), doc::pressure(now.max_error_psi));
  row("hysteresis of the mean, % FS", doc::percent_of(then.comp_distance_of_mean, 2),
      doc::percent_of(now.comp_distance_of_mean, 2));
  const auto verdict = [](std::optional<Verdict> one) { return one ? Phrase(*one) : Phrase("not judged"); };
  row("verdict", verdict(found.judgement.overall), verdict(input.judgement.overall));
  return table;
}

std::string findings(const Health& health) {
  std::string text;
  std::size_t listed = 0;
  for (const TaxelHealth& finding : health.findings)
    if (++listed <= kFindingsListed)
      text += fmt::format("{}{} {}", text.empty() ? "" : "; ",
                          doc::text_of(Phrase(doc::Taxel{finding.taxel, health.columns}), {}), finding.state);
  if (listed > kFindingsListed) text += fmt::format("; and {} more", listed - kFindingsListed);
  for (const SwappedLines& swap : health.swaps)
    text += fmt::format("{}{} {} and {} swapped", text.empty() ? "" : "; ", swap.rows ? "rows" : "columns", swap.first,
                        swap.second);
  if (text.empty()) text = "no taxel dead, stuck, saturated, noisy or without a model";
  return text +
         (health.swaps_assessed ? "." : "; swapped rows or columns were not assessed: no earlier seating is known.");
}

}  // namespace

Document array_page(const PageData& data) {
  const ReportInput& input = data.input;
  const PressureUnit unit = input.unit;
  Document out, left, right;
  out.add(doc::Heading{2, "The array", "array"});
  const double psi = data.readings ? level_of_maps(*data.readings) : kNan;
  if (std::isfinite(psi)) {
    const ReadingFigures& readings = *data.readings;
    doc::SideBySide maps;
    for (const bool up : {true, false}) {
      Document part;
      part.add(map_figure(readings, *readings.level(psi, up), input.health, unit));
      maps.parts.push_back(std::move(part));
    }
    out.add(std::move(maps));
    const TaxelMap scale = error_map(readings, *readings.level(psi, true), input.health, unit);
    const auto mark = [&](double factor) {
      return std::pair(factor * unit.of(readings.tolerance_psi),
                       doc::fixed_text(factor * unit.of(readings.tolerance_psi), 1));
    };
    out.add(doc::Drawing{colour_scale_svg(scale,
                                          {mark(0.1),
                                           mark(0.3),
                                           {unit.of(readings.tolerance_psi),
                                            doc::text_of(doc::bare_pressure(readings.tolerance_psi), unit) +
                                                (readings.by_mpe ? " (limit)" : " (2 %)")},
                                           mark(4.0)},
                                          640.0),
                         "Colour scale",
                         {}});
    left.add(spread(readings, *readings.level(psi, true), unit));
    left.add(worst_taxels(readings, psi, input.health.columns, unit));
  }
  if (std::ranges::any_of(input.behaviour.gain, [](double gain) { return std::isfinite(gain); }))
    right.add(sensitivity(input));
  Document& shorter = left.blocks.empty() ? left : right;
  if (input.more.previous) {
    shorter.add(found_and_left(data));
    if (!input.more.previous->doubt.empty())
      shorter.add(doc::Paragraph{{doc::StyledText{"✗ " + input.more.previous->doubt, doc::TextStyle::kBad}}});
  } else if (!input.evaluation.levels.empty()) {
    shorter.add(doc::Paragraph{
        {doc::strong("As found: "), "not assessed, no earlier models of the sensor were used (--previous)."}});
  }
  shorter.add(doc::Paragraph{{doc::strong("Health: "), findings(input.health)}});
  doc::SideBySide both;
  for (Document* part : {&left, &right})
    if (!part->blocks.empty()) both.parts.push_back(std::move(*part));
  out.add(std::move(both));
  return out;
}

// Page 4: error and uncertainty at every level.

namespace {

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
  row.cells.push_back(within ? Phrase(doc::StyledText{"✓ ", doc::TextStyle::kGood}, sum) : Phrase(sum));
  row.cells.push_back(doc::bare_pressure(level->worst_psi));
  row.cells.push_back(doc::Taxel{level->worst, columns});
}

doc::Table levels_table(const ReadingFigures& readings, int columns, PressureUnit unit) {
  std::set<double> pressures;
  for (const ReadingLevel& level : readings.levels) pressures.insert(level.pressure_psi);
  doc::Table table{.id = "levels",
                   .caption = fmt::format("All errors and U in {}", unit.symbol()),
                   .columns = {{unit.symbol(), true}, {unit.other().symbol(), true}},
                   .dense = true,
                   .keep = pressures.size() < 40};
  for (const bool up : {true, false})
    for (const char* name :
         {"median\nerror", "median\nU", "95 % of taxels\n|error| + U", "worst taxel\n|error| + U", "which"})
      table.columns.push_back({direction_title(up, name), true});
  for (const double psi : pressures) {
    doc::Row row{{doc::bare_pressure(psi), Phrase(doc::quiet(doc::text_of(doc::bare_pressure(psi), unit.other())))}};
    for (const bool up : {true, false}) add_direction(readings, psi, up, columns, row);
    table.rows.push_back(std::move(row));
  }
  return table;
}

doc::Drawing uncertainty_chart(const ReadingFigures& readings, bool up, PressureUnit unit) {
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

Document levels_page(const PageData& data) {
  Document out;
  if (!data.readings) return out;
  const ReadingFigures& readings = *data.readings;
  const PressureUnit unit = data.input.unit;
  out.add(doc::Heading{2, "Error and uncertainty at every level", {}});
  out.add(levels_table(readings, data.input.health.columns, unit));
  if (!readings.known()) {
    out.add(doc::Paragraph{{"Error: mean corrected indication of full sweeps minus the reference value. U of a reading "
                            "was not established for any history: ",
                            doc::StyledText{"why", doc::TextStyle::kPlain, "kinds"}, "."},
                           doc::Paragraph::kNote});
    return out;
  }
  out.add(
      doc::Paragraph{{"Error: mean corrected indication minus the reference value, for “", readings.kind,
                      "”. U: expanded uncertainty of one corrected indication, coverage probability about 95 %. 95 "
                      "% of taxels: the value that |error| + U does not exceed for them. The worst taxel may be "
                      "another one at each level; worst of all: page 1. ✓: within the measuring interval, ",
                      doc::both_units(readings.tolerance_psi),
                      ". The error is known and may be subtracted; U then remains. Error, U and k of each taxel and "
                      "level are in the data (report --format json)."},
                     doc::Paragraph::kNote});
  doc::SideBySide charts;
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
