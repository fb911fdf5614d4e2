// Charts of the report as inline SVG with role="img" and a <title>. Layers are drawn in the order of their members;
// labels are placed at the lines, not in a legend. Coordinates are CSS pixels.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "analysis/report/page/html.h"

namespace tactbench::analysis {

// Darkened Okabe-Ito: contrast at least 4.5:1 on white; dashes distinguish lines without colour.
struct Stroke {
  const char* colour = "#1a2026";
  const char* dashes = "";
  double width = 1.4;
};
inline constexpr Stroke kBlack{}, kBlue{"#0b5cad", ""}, kBrown{"#9c4400", ""}, kGreen{"#00704f", "9 3 2 3"},
    kViolet{"#6b3fa0", "2 2"}, kRed{"#a11212", "6 3"}, kRedDots{"#a11212", "2 3", 1.2};
inline constexpr Stroke kStrokes[] = {kBlack, {"#b84300", "7 3"}, kBlue, kGreen, kViolet};

// `ends`: labels are outside the plot at the right end of their line; else inside, where they cover least.
struct Curve {
  std::string label = {};
  std::vector<double> x, y = {};  // of equal length; a non-finite value interrupts the line
  Stroke stroke = {};
  bool points = false;
};
struct Band {
  std::string label = {};
  std::vector<double> x, low, high = {};
  const char* fill = "#d5dde3";
};
struct Rule {
  double at = 0.0;
  std::string label = {};
  Stroke stroke = kRed;
  bool upright = false;  // a vertical line at an x; else a horizontal one at a y
};
struct ShadedSpan {  // of x, shaded from top to bottom
  double from = 0.0, to = 0.0;
  std::string label = {};  // above the plot
};
struct Bars {
  std::vector<double> edges, counts = {};  // one edge more than counts
};

struct Axis {
  std::string label = {};
  std::optional<double> low = {}, high = {};  // else from the data
  bool logarithmic = false;
  std::string beside = {};          // name of the second unit; empty: none
  double second_unit_factor = 1.0;  // value x factor
};

struct Chart {
  std::string title, heading = {};  // heading: printed above the plot
  double width = 330.0, height = 220.0;
  Axis x, y;
  std::vector<ShadedSpan> stretches = {};
  std::vector<Bars> bars = {};
  std::vector<Band> bands = {};
  std::vector<Rule> rules = {};
  std::vector<Curve> curves = {};
  bool labels_at_ends = false;
  Stroke heading_stroke = kBlack;
};

// Values beyond a fixed axis are drawn at its edge, with a triangle.
html::Markup chart_svg(const Chart& chart);
std::string svg_file(const Chart& chart);  // a complete SVG file

// About `wanted` round numbers (1, 2, 5 x 10^n) within [low, high].
std::vector<double> nice_ticks(double low, double high, int wanted);

// Counts of the finite values in `bins` of equal width; the last bin also contains values above `high`.
Bars bars_of(const std::vector<double>& values, double low, double high, int bins);

// Places the labels of a chart's lines: at their right ends, or within the plot where they cover least.

inline constexpr double kLetterWidth = 5.3;  // of the chart's 10 px letters, on average

std::size_t letters_in(const std::string& text);  // number of characters, not bytes

using LinePoints = std::vector<std::pair<double, double>>;  // pixels; y not finite: a gap

struct LineLabel {
  std::string text, colour;
  LinePoints line;       // the line to which the label belongs
  bool upright = false;  // next to a vertical line, else above or below a line
};

struct PlotArea {
  double left, right, top, bottom;
};

// Places the labels one after the other, each where it overlaps the fewest earlier labels and the fewest points of
// `lines`.
html::Markup labels_inside(const std::vector<LineLabel>& labels, const std::vector<LinePoints>& lines,
                           const PlotArea& area);
// Places the labels right of the plot, in the order of the lines' ends, at least one line of text apart.
html::Markup labels_at_ends(const std::vector<LineLabel>& labels, const PlotArea& area);

}  // namespace tactbench::analysis
