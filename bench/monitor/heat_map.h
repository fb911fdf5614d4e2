// Heat map of the array for terminals: two columns per taxel, a scale in volts next to it, and a list of the taxels
// with the highest output and of those without output.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "bench/common/screen.h"
#include "bench/monitor/array_view.h"

namespace tactbench::bench {

enum class Shades { kColours, kCharacters };

inline constexpr std::size_t kShades = 10;
// From no output (dark) to the highest (light): colours of xterm, and characters for terminals without colours.
inline constexpr std::array<int, kShades> kShadeColours = {17, 53, 55, 25, 30, 36, 77, 148, 220, 226};
inline constexpr const char* kShadeCharacters = " .:-=+*#%@";

// Colours on a terminal that has 256 of them, unless NO_COLOR is set to something (no-color.org).
Shades shades_of_terminal();

// The shade of `volts` on the scale from 0 V to `top_v`: 0 to kShades - 1.
std::size_t shade_of(double volts, double top_v);
// The scale's upper end: the highest output, at least a tenth of the converter's range, so that an unloaded array stays
// dark.
double scale_top_v(const ArrayView& view);

// A title line and the map, at most `columns` wide and `rows` high. An array that is too large is drawn with one cell
// for the mean of 2 x 2 taxels, 3 x 3 and so on; if the text next to the map does not fit, it is left out. A dead taxel
// is drawn as "xx". Empty: the map does not fit.
std::vector<PaintedLine> heat_map(const ArrayView& view, Shades shades, std::size_t columns, std::size_t rows);

}  // namespace tactbench::bench
