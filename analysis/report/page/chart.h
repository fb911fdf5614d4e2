// Drawings of the report as inline SVG with role="img" and a <title>: charts, maps of the array, QR codes. Layers of a
// chart are drawn in the order of their members; labels are placed at the lines, not in a legend. Coordinates are CSS
// pixels.
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
  std::string second_unit = {};     // name of the second unit; empty: none
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

// Counts of the finite values in `bins` of equal width; the last bin also contains values above `high`.
Bars bars_of(const std::vector<double>& values, double low, double high, int bins);

// Places the labels of a chart's lines: at their right ends, or within the plot where they cover least.
inline constexpr double kLetterWidth = 5.3;  // of the chart's 10 px letters, on average

using LinePoints = std::vector<std::pair<double, double>>;  // pixels; y not finite: a gap

struct LineLabel {
  std::string text, colour;
  LinePoints line;       // the line to which the label belongs
  bool upright = false;  // next to a vertical line, else above or below a line
};

struct PlotArea {
  double left, right, top, bottom;
};

// Places the labels right of the plot, in the order of the lines' ends, at least one line of text apart.
html::Markup labels_at_ends(const std::vector<LineLabel>& labels, const PlotArea& area);

// Maps of an array: one cell per taxel, row 0 on top, on a light scale from white to blue, so that all digits can be
// black.
struct TaxelMap {
  std::string title = {};
  int rows = 0, columns = 0;
  std::vector<double> values = {};  // row-major; a non-finite value is white with a cross
  double low = 0.0, high = 1.0;     // range of the colours; values beyond have the colour of the end
  bool logarithmic = false;
  bool two_sided = false;     // brown below the middle, white there, blue above
  double bold_above = 1e300;  // values above it are printed in bold
  double size = 320.0;        // pixels of the longer side, without the counts of rows and columns
  bool numbered = false;      // each value in its cell, two significant digits
  bool counted = true;        // rows and columns at the edges
};

html::Markup taxel_map_svg(const TaxelMap& map);
// The scale of a map with some values marked: "8.3 (limit)".
html::Markup colour_scale_svg(const TaxelMap& map, const std::vector<std::pair<double, std::string>>& marks,
                              double width);

// A QR code (ISO/IEC 18004) as SVG.
// Byte mode, error correction level M, with the quiet zone of four modules; `size` px wide. The same text gives the
// same bytes. Throws std::invalid_argument if the text is empty or longer than 2331 bytes.
html::Markup qr_code_svg(const std::string& text, const std::string& title, double size);

}  // namespace tactbench::analysis
