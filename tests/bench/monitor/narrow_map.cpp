// The map of an array on a narrow screen: cells of several taxels, as wide as the screen allows and no wider.
#include <catch2/catch.hpp>

#include "bench/monitor/heat_map.h"

using namespace tactbench::bench;

TEST_CASE("heat map: on a narrow screen a cell is the mean of more taxels") {
  ArrayView view;
  view.title = "frame";
  view.rows = view.columns = 16;
  view.full_scale_v = 5.0;
  view.volts.assign(256, 1.0);
  const auto width = [&](std::size_t columns) {
    const std::vector<PaintedLine> map = heat_map(view, Shades::kCharacters, columns, 30);
    std::size_t wide = 0;
    for (const Span& span : map.at(1)) wide += span.text.size();
    return wide;
  };
  CHECK(width(35) == 2 + 2 * 16);
  CHECK(width(34) == 2 + 2 * 8);
  CHECK(width(19) == 2 + 2 * 8);
  CHECK(width(18) == 2 + 2 * 6);
  CHECK(width(5) == 2 + 2 * 1);
}
