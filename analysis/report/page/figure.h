// The report's figures as inline SVG: line charts and maps of frames. Each has role="img" and a <title>; coordinates
// are CSS pixels, so that letters are as large in a half-width figure as in a full one.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/report/page/html.h"

namespace tactbench::analysis {

struct Series {
  std::string name;          // in the legend; empty: no entry
  std::vector<double> x, y;  // of equal length; a value that is not finite breaks the line
  int style = 0;             // colour and dash pattern, 0..kLineStyles-1
  bool points = false;       // dots without a line
  bool filled = false;       // the area below the line, down to the axis
};

// The same axis in another unit, on the opposite edge of the plot: value x factor. No unit: no such scale.
struct SecondScale {
  std::string unit;
  double factor = 1.0;
};

struct LineChart {
  std::string title, x_label, y_label;
  std::vector<Series> series;
  double width = 680.0, height = 300.0;
  bool y_from_zero = false;
  SecondScale x_beside = {}, y_beside = {};
};

// Charts of pressures: series in psi become series in `unit`, the label gains it ("gauge pressure" -> "gauge pressure
// in kPa"), and unless the chart is narrow the other unit stands on the opposite edge.
LineChart pressure_along(LineChart chart, PressureUnit unit);  // x is a pressure
LineChart pressure_up(LineChart chart, PressureUnit unit);     // y is a pressure
LineChart pressures(LineChart chart, PressureUnit unit);       // both

// Darkened Okabe-Ito: contrast at least 4.5:1 on white; dashes distinguish lines without colour.
struct LineStyle {
  const char* colour;
  const char* dashes;
};
inline constexpr LineStyle kLineStyles[] = {
    {"#000000", ""}, {"#b84300", "7 3"}, {"#00669f", "2 2"}, {"#00704f", "9 3 2 3"}, {"#9a4a7b", "4 2 1 2 1 2"}};

// Legend below the axes, never over the curves.
html::Markup line_chart(const LineChart& chart);

// Counts of values per bin. Values that are not finite are ignored.
struct Histogram {
  std::string title, x_label, y_label;
  std::vector<double> values;
  std::optional<double> limit;  // a dashed line across
  std::string limit_name;
  double width = 335.0, height = 220.0;
  int bins = 24;
};
html::Markup histogram_chart(const Histogram& histogram);

// About `wanted` round numbers (1, 2, 5 x 10^n) within [low, high].
std::vector<double> nice_ticks(double low, double high, int wanted);

// One scale serves a whole strip of maps; values beyond it take the end's colour.
struct ColourScale {
  double low = 0.0, high = 1.0;
};

// cividis (Nunez et al. 2018), linear in lightness; t is clamped to 0..1. "#rrggbb".
std::string cividis(double t);

struct FrameMap {
  std::string title;
  int rows = 0, columns = 0;
  std::vector<double> values;  // row-major, first row on top; not finite: white with a cross
  ColourScale scale;
  double size = 78.0;  // of the longer side
};

// One path per colour bin (32): a frame costs about 4 kB.
html::Markup frame_map(const FrameMap& map);
// The same, large, with the value in each cell; for few maps per report. kTwoSignificant for `digits`: as the GUM
// rounds an uncertainty, each value by itself.
inline constexpr int kTwoSignificant = -1;
html::Markup numbered_map(const FrameMap& map, int digits);
// The scale with its two ends.
html::Markup colour_bar(const html::Text& low, const html::Text& high, const std::string& title);
html::Markup colour_bar(const ColourScale& scale, const std::string& title, const std::string& unit, int digits);
// A map of pressures in psi, shown in `unit`; the bar below it has the other unit, too. `digits`: those of psi.
FrameMap pressure_map(FrameMap map, PressureUnit unit);
html::Markup pressure_bar(const ColourScale& scale_psi, const std::string& title, PressureUnit unit, int digits);

}  // namespace tactbench::analysis
