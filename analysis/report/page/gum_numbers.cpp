#include "analysis/report/page/gum_numbers.h"

#include <algorithm>
#include <cmath>

namespace tactbench::analysis {

namespace {

constexpr double kManyDegrees = 1000.0;  // beyond them k stays the same to three digits

}  // namespace

int gum_decimals(double expanded) {
  if (!std::isfinite(expanded) || expanded <= 0.0) return 3;
  int exponent = static_cast<int>(std::floor(std::log10(expanded)));
  // 0.0996 is 0.10: what rounds up to the next power of ten has a digit less.
  if (std::nearbyint(expanded / std::pow(10.0, exponent - 1)) >= 100.0) ++exponent;
  return std::clamp(1 - exponent, 0, 9);
}

namespace {

// 106 has two significant digits as 110, and its value is then rounded to tens, too.
double rounded_beside(double value, double expanded) {
  if (!std::isfinite(value) || !std::isfinite(expanded) || expanded < 99.5) return value;
  const double place = std::pow(10.0, std::floor(std::log10(expanded)) - 1.0);
  return place * std::nearbyint(value / place);
}

}  // namespace

html::Text gum_uncertainty(double expanded) {
  return html::fixed(rounded_beside(expanded, expanded), gum_decimals(expanded));
}

html::Markup gum_value(double value, double expanded) {
  return html::markup("{} ± {}", html::fixed(rounded_beside(value, expanded), gum_decimals(expanded)),
                      gum_uncertainty(expanded));
}

html::Markup gum_pressure(double expanded_psi, PressureUnit unit) {
  const PressureUnit beside = unit.beside();
  return html::markup("{}\u00A0{} ({}\u00A0{})", gum_uncertainty(unit.of(expanded_psi)), html::Text(unit.symbol()),
                      gum_uncertainty(beside.of(expanded_psi)), html::Text(beside.symbol()));
}

html::Markup gum_pressure(double value_psi, double expanded_psi, PressureUnit unit) {
  return gum_value(unit.of(value_psi), unit.of(expanded_psi));
}

html::Markup gum_pressure_value(double value_psi, double expanded_psi, PressureUnit unit) {
  const auto in = [&](PressureUnit shown) {
    return html::markup("{}\u00A0{}", html::fixed(shown.of(value_psi), gum_decimals(shown.of(expanded_psi))),
                        html::Text(shown.symbol()));
  };
  return html::markup("{} ({})", in(unit), in(unit.beside()));
}

html::Markup gum_pressure_stated(double value_psi, double expanded_psi, PressureUnit unit) {
  const auto in = [&](PressureUnit shown) {
    return html::markup("{}\u00A0{}", gum_pressure(value_psi, expanded_psi, shown), html::Text(shown.symbol()));
  };
  return html::markup("{} ({})", in(unit), in(unit.beside()));
}

html::Text gum_degrees(double dof) {
  if (std::isnan(dof)) return html::Text("not available");
  if (dof >= 1e6) return html::Text("∞");
  return dof >= kManyDegrees ? html::Text("> 1000") : html::fixed(std::floor(dof), 0);
}

}  // namespace tactbench::analysis
