#include "bench/instruments/reference_calibration.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <stdexcept>
#include <utility>

#include "analysis/pressure_unit.h"
#include "bench/common/error.h"

namespace tactbench::bench {

namespace {

struct Level {
  double reference_sum = 0.0;
  double lowest = 0.0, highest = 0.0;  // of gauge - reference
  double difference_sum = 0.0;
  int points = 0;
};

}  // namespace

ReferenceCalibration calibrate_reference(const std::vector<GaugePoint>& points, double gauge_expanded_uncertainty_psi,
                                         double gauge_resolution_psi) {
  std::map<double, Level> levels;
  for (const GaugePoint& point : points) {
    Level& level = levels[point.level_psi];
    const double difference = point.gauge_psi - point.reference_psi;
    level.lowest = level.points == 0 ? difference : std::min(level.lowest, difference);
    level.highest = level.points == 0 ? difference : std::max(level.highest, difference);
    level.reference_sum += point.reference_psi;
    level.difference_sum += difference;
    ++level.points;
  }
  if (levels.size() < 2) throw std::invalid_argument("a calibration needs readings at two levels or more");
  ReferenceCalibration result;
  result.correction.coverage_factor = 2.0;
  for (const auto& [psi, level] : levels) {
    const double half = (level.highest - level.lowest) / 2.0;
    const double u_gauge = gauge_expanded_uncertainty_psi / 2.0;
    const double u =
        std::sqrt(u_gauge * u_gauge + half * half / 3.0 + gauge_resolution_psi * gauge_resolution_psi / 12.0);
    result.correction.reading_psi.push_back(level.reference_sum / level.points);
    result.correction.correction_psi.push_back(level.difference_sum / level.points);
    result.correction.expanded_uncertainty_psi.push_back(2.0 * u);
    result.hysteresis_psi = std::max(result.hysteresis_psi, 2.0 * half);
  }
  const std::vector<double>& readings = result.correction.reading_psi;
  std::vector<double> pressures;
  std::ranges::transform(readings, result.correction.correction_psi, std::back_inserter(pressures), std::plus<>());
  for (const auto& [whose, of_levels] :
       {std::pair("reference", &readings), std::pair("hand gauge", &std::as_const(pressures))}) {
    const auto fall = std::ranges::adjacent_find(*of_levels, std::greater_equal<>());
    if (fall == of_levels->end()) continue;
    throw Error("TB-REFERENCE-FLAT",
                fmt::format("the {}'s reading does not rise with the pressure: {}, and {} at the next level", whose,
                            analysis::both_units(fall[0], 3), analysis::both_units(fall[1], 3)),
                "calibrate-reference");
  }
  for (const GaugePoint& point : points) {
    const double corrected = result.correction.corrected(devices::Psi(point.reference_psi)).value();
    result.residual_psi.push_back(point.gauge_psi - corrected);
    result.largest_residual_psi = std::max(result.largest_residual_psi, std::abs(result.residual_psi.back()));
  }
  return result;
}

std::string correction_toml(const ReferenceCalibration& calibration, const std::vector<GaugePoint>& points,
                            const std::string& heading) {
  const auto list = [](const std::vector<double>& values) {
    std::vector<std::string> texts;
    for (const double value : values) texts.push_back(fmt::format("{:.4f}", value));
    return fmt::format("[{}]", fmt::join(texts, ", "));
  };
  std::string text =
      fmt::format("# {}\n# level psi, direction, reference psi, hand gauge psi, residual psi\n", heading);
  for (std::size_t i = 0; i < points.size(); ++i) {
    text += fmt::format("# {:8.3f}  {:<4}  {:9.4f}  {:9.4f}  {:+.4f}\n", points[i].level_psi,
                        points[i].rising ? "up" : "down", points[i].reference_psi, points[i].gauge_psi,
                        calibration.residual_psi[i]);
  }
  text += fmt::format("# largest residual {:.4f} psi, largest difference between up and down {:.4f} psi\n",
                      calibration.largest_residual_psi, calibration.hysteresis_psi);
  const devices::PressureCorrection& correction = calibration.correction;
  return text + fmt::format(
                    "schema = 1\nreading_psi = {}\ncorrection_psi = {}\nexpanded_uncertainty_psi = {}\ncoverage_factor "
                    "= {:.1f}\n",
                    list(correction.reading_psi), list(correction.correction_psi),
                    list(correction.expanded_uncertainty_psi), correction.coverage_factor);
}

}  // namespace tactbench::bench
