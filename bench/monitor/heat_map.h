// The newest image of the array as a heat map for terminals: two columns per taxel, a scale in volts next to it, and a
// list of the taxels with the highest output and of those without output.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "analysis/pressure_unit.h"
#include "bench/common/terminal.h"
#include "db/run_reader.h"
#include "db/run_store.h"

namespace tactbench::bench {

// The newest image of the array in a run's store: the last frame or, before the first frame, the one of the seating
// check.
struct ArrayView {
  std::string title;  // "frame 19 at 40.0 psi"
  int rows = 0, columns = 0;
  std::vector<double> volts;    // rows x columns, row-major; mean of the frame's scans
  double full_scale_v = 0.0;    // of the converter
  std::vector<int> dead;        // row * columns + column
  std::vector<int> saturated;   // taxels of a frame with a scan at the converter's limit
  bool dead_are_known = false;  // true if there is an unloaded frame to compare with and the whole array is loaded
};

// Data that do not change during a run.
struct ArrayBasis {
  double volts_per_count = 0.0;
  std::vector<double> unloaded_v;  // by the newest seating check; empty: there is none
};
// None: the scanner's scale is not known yet. Throws StoreError.
std::optional<ArrayBasis> array_basis(const db::RunReader& store, const db::RunRecord& run);
ArrayView view_of_frame(const ArrayBasis& basis, const db::StoredFrame& frame,
                        analysis::PressureUnit unit = analysis::PressureUnit::kPsi);

// None: the run has neither a frame nor a seating check, or its scanner's scale is not known yet. Throws StoreError.
std::optional<ArrayView> newest_array(const db::RunReader& store, const db::RunRecord& run,
                                      analysis::PressureUnit unit = analysis::PressureUnit::kPsi);

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
