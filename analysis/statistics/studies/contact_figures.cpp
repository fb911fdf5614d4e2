#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/studies/contact_results.h"

namespace tactbench::analysis {

namespace {

constexpr double kContactShare = 0.1, kLeastContactPsi = 0.5;

}  // namespace

ContactFigures contact_figures(std::span<const double> pressure_psi, int rows, int columns,
                               const ArrayGeometry& geometry) {
  if (pressure_psi.size() != static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns))
    throw std::invalid_argument("a frame of pressures has one value a taxel");
  ContactFigures out;
  double peak = 0.0, in_contact = 0.0;
  for (const double pressure : pressure_psi)
    if (std::isfinite(pressure)) peak = std::max(peak, pressure);
  out.threshold_psi = std::max(kLeastContactPsi, kContactShare * peak);
  for (std::size_t i = 0; i < pressure_psi.size(); ++i) {
    if (!std::isfinite(pressure_psi[i])) continue;
    const auto row = static_cast<int>(i) / columns, column = static_cast<int>(i) % columns;
    const double x = (column - 0.5 * (columns - 1)) * geometry.pitch_mm;
    const double y = (row - 0.5 * (rows - 1)) * geometry.pitch_mm;
    const double force = pressure_psi[i] * geometry.taxel_area_mm2 * kNewtonPerPsiMm2;
    out.force_n += force;
    if (pressure_psi[i] < out.threshold_psi) continue;
    in_contact += force;
    out.moment_x_nmm += force * y;
    out.moment_y_nmm -= force * x;
    out.area_mm2 += geometry.taxel_area_mm2;
  }
  const bool pressed = in_contact > 0.0;
  out.x_mm = pressed ? -out.moment_y_nmm / in_contact : kNan;
  out.y_mm = pressed ? out.moment_x_nmm / in_contact : kNan;
  return out;
}

}  // namespace tactbench::analysis
