// Places the labels of a chart's lines: at their right ends, or within the plot where they cover least.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "analysis/report/page/html.h"

namespace tactbench::analysis {

inline constexpr double kLetterWidth = 5.3;  // of the chart's 10 px letters, on average

std::size_t letters_in(const std::string& text);  // not bytes

using LinePoints = std::vector<std::pair<double, double>>;  // pixels; y not finite: a gap

struct LineLabel {
  std::string text, colour;
  LinePoints line;       // that it names
  bool upright = false;  // beside an upright line, else above or below it
};

struct PlotArea {
  double left, right, top, bottom;
};

// One after the other: each where it overlaps fewest labels before it and fewest points of `lines`.
html::Markup labels_inside(const std::vector<LineLabel>& labels, const std::vector<LinePoints>& lines,
                           const PlotArea& area);
// Right of the plot, in the order of the lines' ends, not closer than a line of text.
html::Markup labels_at_ends(const std::vector<LineLabel>& labels, const PlotArea& area);

}  // namespace tactbench::analysis
