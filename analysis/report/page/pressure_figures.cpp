#include "analysis/report/page/figure.h"

namespace tactbench::analysis {
namespace {

constexpr double kRoomForTwoScales = 300.0;  // narrower charts have one

void show_in(std::vector<double>& pressures_psi, PressureUnit unit) {
  for (double& pressure : pressures_psi) pressure = unit.of(pressure);
}

SecondScale scale_beside(const LineChart& chart, PressureUnit unit) {
  if (chart.width < kRoomForTwoScales) return {};
  return {unit.beside().symbol(), unit.beside().of(1.0) / unit.of(1.0)};
}

}  // namespace

LineChart pressure_along(LineChart chart, PressureUnit unit) {
  for (Series& series : chart.series) show_in(series.x, unit);
  chart.x_label += std::string(" in ") + unit.symbol();
  chart.x_beside = scale_beside(chart, unit);
  return chart;
}

LineChart pressure_up(LineChart chart, PressureUnit unit) {
  for (Series& series : chart.series) show_in(series.y, unit);
  chart.y_label += std::string(" in ") + unit.symbol();
  chart.y_beside = scale_beside(chart, unit);
  return chart;
}

LineChart pressures(LineChart chart, PressureUnit unit) {
  return pressure_up(pressure_along(std::move(chart), unit), unit);
}

FrameMap pressure_map(FrameMap map, PressureUnit unit) {
  show_in(map.values, unit);
  map.scale = {unit.of(map.scale.low), unit.of(map.scale.high)};
  return map;
}

html::Markup pressure_bar(const ColourScale& scale_psi, const std::string& title, PressureUnit unit, int digits) {
  return colour_bar(html::pressure(scale_psi.low, unit, digits), html::pressure(scale_psi.high, unit, digits), title);
}

}  // namespace tactbench::analysis
