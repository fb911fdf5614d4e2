#include "analysis/report/page/numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tactbench::analysis {

double rounded_beside(double value, double expanded) {
  if (!std::isfinite(value) || !std::isfinite(expanded) || expanded < 99.5) return value;
  const double place = std::pow(10.0, std::floor(std::log10(expanded)) - 1.0);
  return place * std::nearbyint(value / place);
}

int gum_decimals(double expanded) {
  if (!std::isfinite(expanded) || expanded <= 0.0) return 3;
  int exponent = static_cast<int>(std::floor(std::log10(expanded)));
  // 0.0996 is 0.10: what rounds up to the next power of ten has a digit less.
  if (std::nearbyint(expanded / std::pow(10.0, exponent - 1)) >= 100.0) ++exponent;
  return std::clamp(1 - exponent, 0, 9);
}

std::string fixed_text(double value, int digits) {
  if (!std::isfinite(value)) return "–";
  std::string text = fmt::format("{:.{}f}", value, digits);
  if (text.front() != '-') return text;
  text.erase(0, 1);
  return text.find_first_of("123456789") == std::string::npos ? text : "\u2212" + text;
}

std::string two_digits_text(double expanded) {
  return fixed_text(rounded_beside(expanded, expanded), gum_decimals(expanded));
}

}  // namespace tactbench::analysis
