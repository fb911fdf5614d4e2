// Maps of an array: one cell per taxel, row 0 on top, on a light scale from white to blue, so that all digits can be
// black.
#pragma once

#include <string>
#include <vector>

#include "analysis/report/page/html.h"

namespace tactbench::analysis {

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

}  // namespace tactbench::analysis
