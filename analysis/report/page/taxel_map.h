// Maps of an array: a cell a taxel, row 0 on top, on one light scale from white to blue that all digits are black on.
#pragma once

#include <string>
#include <vector>

#include "analysis/report/page/html.h"

namespace tactbench::analysis {

struct TaxelMap {
  std::string title = {};
  int rows = 0, columns = 0;
  std::vector<double> values = {};  // row-major; not finite: white with a cross
  double low = 0.0, high = 1.0;     // of the colours; values beyond take the end's
  bool logarithmic = false;
  bool two_sided = false;     // brown below the middle, white there, blue above
  double bold_above = 1e300;  // printed in bold
  double size = 320.0;        // pixels of the longer side, without the counts of rows and columns
  bool numbered = false;      // each value in its cell, two significant digits
  bool counted = true;        // rows and columns at the edges
};

html::Markup taxel_map_svg(const TaxelMap& map);
// The scale of a map with some values marked: "8.3 (limit)".
html::Markup colour_scale_svg(const TaxelMap& map, const std::vector<std::pair<double, std::string>>& marks,
                              double width);

}  // namespace tactbench::analysis
