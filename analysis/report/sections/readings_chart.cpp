#include <algorithm>

#include "analysis/report/document/printers.h"
#include "analysis/report/page/chart.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {

namespace {

constexpr double kShownShare =
    0.08;  // of the full pressure: the chart's axis, so that one bad taxel does not flatten the rest
constexpr double kShownTolerances = 1.7;
constexpr double kWideShare = 0.05;  // a second line where the limits state no MPE

Chart panel(const ReadingFigures& readings, bool up, PressureUnit unit) {
  const Stroke stroke = up ? kBlue : kBrown;
  const double most = unit.of(std::max(kShownShare * readings.full_psi, kShownTolerances * readings.tolerance_psi));
  Chart chart{
      .title = fmt::format("Error of a reading with its expanded uncertainty against pressure, {}",
                           up ? "increasing" : "decreasing"),
      .heading = up ? "Increasing pressure" : "Decreasing pressure",
      .width = up ? 336.0 : 344.0,
      .height = 256.0,
      .x = {fmt::format("reference pressure (gauge) in {}, below it in {}", unit.symbol(), unit.beside().symbol()), 0.0,
            unit.of(readings.full_psi)},
      .y = {up ? fmt::format("error of a reading in {}", unit.symbol()) : "", -most, most},
      .heading_stroke = stroke};
  chart.x.beside = unit.beside().symbol();
  chart.x.beside_factor = unit.beside().of(1.0) / unit.of(1.0);
  if (!up) {
    chart.y.beside = "% of full pressure";
    chart.y.beside_factor = 100.0 / unit.of(readings.full_psi);
  }
  Band spread{
      readings.known() ? "95 % of the taxels, with U" : "95 % of the taxels", {}, {}, {}, up ? "#d7e4f2" : "#f1e0d3"};
  Band median{readings.known() ? "median, with U" : "", {}, {}, {}, up ? "#8db4dc" : "#d3a683"};
  Curve middle{"", {}, {}, {stroke.colour, "", 2.0}};
  for (const ReadingLevel& level : readings.levels) {
    if (level.up != up) continue;
    const double x = unit.of(level.pressure_psi), y = unit.of(level.median_error_psi),
                 u = unit.of(level.median_expanded_psi);
    for (Band* band : {&spread, &median}) band->x.push_back(x);
    spread.low.push_back(unit.of(level.low_psi));
    spread.high.push_back(unit.of(level.high_psi));
    median.low.push_back(y - u);
    median.high.push_back(y + u);
    middle.x.push_back(x);
    middle.y.push_back(y);
  }
  chart.bands = {spread, median};
  chart.curves = {middle};
  const MeasuringInterval& span = up ? readings.span_up : readings.span_down;
  if (span.any) chart.stretches.push_back({unit.of(span.low_psi), unit.of(span.high_psi), span_text(span, unit)});
  const auto tolerance = [&](double psi, const Stroke& line) {
    const std::string name = fmt::format("{} %: {} {}", doc::fixed_text(100.0 * psi / readings.full_psi, 0),
                                         doc::text_of(doc::bare_pressure(psi), unit), unit.symbol());
    chart.rules.push_back({unit.of(psi), readings.by_mpe ? "limit, " + name : name, line});
    chart.rules.push_back({-unit.of(psi), "", line});
  };
  tolerance(readings.tolerance_psi, kRed);
  if (!readings.by_mpe) tolerance(kWideShare * readings.full_psi, kRedDots);
  return chart;
}

}  // namespace

doc::Beside readings_chart(const ReadingFigures& readings, PressureUnit unit) {
  doc::Beside out;
  for (const bool up : {true, false}) {
    const Chart chart = panel(readings, up, unit);
    doc::Document part;
    part.add(doc::Figure{chart_svg(chart), chart.title, {}});
    out.parts.push_back(std::move(part));
    out.shares.push_back(static_cast<int>(chart.width));
  }
  return out;
}

}  // namespace tactbench::analysis
