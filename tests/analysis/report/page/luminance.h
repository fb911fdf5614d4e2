// How bright a colour of the page looks.
#pragma once

#include <cmath>
#include <cstddef>
#include <string>

namespace tactbench::analysis {

// WCAG 2 relative luminance of "#rrggbb".
inline double luminance(const std::string& colour) {
  const double weights[] = {0.2126, 0.7152, 0.0722};
  double out = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double c = std::stoi(colour.substr(1 + 2 * i, 2), nullptr, 16) / 255.0;
    out += weights[i] * (c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
  }
  return out;
}

}  // namespace tactbench::analysis
