// The array as a picture in the terminal: shades, scale, names, and what a small window leaves of it.
#include "bench/monitor/heat_map.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <string>

#include "bench/common/for_people.h"
#include "tests/support/variable.h"

using namespace tactbench::bench;

namespace {

// Rising along the rows from 0 V to 3.1875 V, in steps of 0.0125 V.
ArrayView ramp(int rows = 16, int columns = 16) {
  ArrayView view;
  view.title = "frame 19 at 40.0 psi";
  view.rows = rows;
  view.columns = columns;
  view.full_scale_v = 5.0;
  for (int i = 0; i < rows * columns; ++i) view.volts.push_back(0.0125 * i);
  view.dead_are_known = true;
  return view;
}

std::string text_of(const PaintedLine& line) {
  std::string text;
  for (const Span& span : line) text += span.text;
  return text;
}

std::string text_of(const std::vector<PaintedLine>& lines) {
  std::string text;
  for (const PaintedLine& line : lines) text += text_of(line) + "\n";
  return text;
}

// CIE 1976 lightness of one of xterm's colours 16 to 231.
double lightness(int colour) {
  const auto linear = [](int level) {
    const double share = (level == 0 ? 0 : 55 + 40 * level) / 255.0;
    return share <= 0.04045 ? share / 12.92 : std::pow((share + 0.055) / 1.055, 2.4);
  };
  const int c = colour - 16;
  const double y = 0.2126 * linear(c / 36) + 0.7152 * linear(c / 6 % 6) + 0.0722 * linear(c % 6);
  return 116.0 * std::cbrt(y) - 16.0;
}

}  // namespace

TEST_CASE("heat map: ten shades from 0 V to the highest output, each lighter than the one before") {
  CHECK(shade_of(-0.1, 2.0) == 0);
  CHECK(shade_of(0.0, 2.0) == 0);
  CHECK(shade_of(0.1999, 2.0) == 0);
  CHECK(shade_of(0.2001, 2.0) == 1);
  CHECK(shade_of(1.9, 2.0) == 9);
  CHECK(shade_of(2.0, 2.0) == 9);
  CHECK(shade_of(1e9, 2.0) == 9);
  CHECK(shade_of(std::nan(""), 2.0) == 0);
  CHECK(std::string(kShadeCharacters).size() == kShades);
  for (std::size_t i = 1; i < kShades; ++i) CHECK(lightness(kShadeColours[i]) > lightness(kShadeColours[i - 1]) + 2.0);
  ArrayView view = ramp();
  CHECK(scale_top_v(view) == Approx(3.1875));
  view.volts.assign(256, 0.01);
  CHECK(scale_top_v(view) == Approx(0.5));  // an unloaded array stays dark
}

TEST_CASE("heat map: in characters, with scale, hottest taxels and dead ones") {
  ArrayView view = ramp();
  view.dead = {17, 18, 100, 255};
  const auto lines = heat_map(view, Shades::kCharacters, 80, 17);
  REQUIRE(lines.size() == 17);
  for (const PaintedLine& line : lines) {
    CHECK(text_of(line).size() < 80);
    for (const Span& span : line) CHECK(span.colour == -1);
  }
  CHECK(text_of(lines[0]) == "  array     frame 19 at 40.0 psi, 16 x 16 taxels");
  CHECK(text_of(lines[1]) == "  " + std::string(32, ' ') + "   @@ from 2.87 V");
  // Row 1 holds 0.2 to 0.3875 V; the second shade begins at 0.31875 V; taxels 17 and 18 are dead.
  CHECK(text_of(lines[2]).substr(0, 34) == "    xxxx" + std::string(14, ' ') + std::string(12, '.'));
  CHECK(text_of(lines[16]).substr(0, 34) == "  " + std::string(30, '@') + "xx");
  const std::string text = text_of(lines);
  CHECK_THAT(text, Catch::Contains("   hottest row 15, column 15  3.19 V\n"));
  CHECK_THAT(text, Catch::Contains("           row 15, column 14  3.18 V\n"));
  CHECK_THAT(text, Catch::Contains("   dead    row 1, column 1\n"));
  CHECK_THAT(text, Catch::Contains("           row 6, column 4, 1 more\n"));
  view.dead.clear();
  CHECK_THAT(text_of(heat_map(view, Shades::kCharacters, 80, 17)), Catch::Contains("dead    none\n"));
  view.dead_are_known = false;
  CHECK_THAT(text_of(heat_map(view, Shades::kCharacters, 80, 17)), Catch::Contains("dead    not judged\n"));
}

TEST_CASE("heat map: in colours, neighbours of one shade in one span") {
  const auto lines = heat_map(ramp(), Shades::kColours, 80, 17);
  REQUIRE(lines.size() == 17);
  CHECK(lines[1][1] == Span{std::string(32, ' '), kShadeColours[0]});
  CHECK(lines[16][1].colour == kShadeColours[9]);
  CHECK(lines[1][3].colour == kShadeColours[9]);  // the scale's lightest
}

TEST_CASE("heat map: a small window loses the text, then detail, and never gets more than it holds") {
  const ArrayView view = ramp();
  CHECK_THAT(text_of(heat_map(view, Shades::kCharacters, 72, 17)), Catch::Contains("hottest"));
  const std::string narrow = text_of(heat_map(view, Shades::kCharacters, 71, 17));
  CHECK_THAT(narrow, !Catch::Contains("hottest"));
  const auto coarse = heat_map(view, Shades::kCharacters, 80, 16);
  CHECK(text_of(coarse[1]).substr(0, 18) == "                  ");
  CHECK(coarse.size() <= 16);
  for (const std::size_t columns : {5U, 17U, 20U, 35U, 40U, 80U, 200U}) {
    for (const std::size_t rows : {2U, 3U, 8U, 9U, 17U, 60U}) {
      const auto lines = heat_map(ramp(24, 10), Shades::kCharacters, columns, rows);
      INFO(columns << " x " << rows);
      CHECK(lines.size() <= rows);
      CHECK(lines.size() >= 2);
      for (std::size_t i = 1; i < lines.size(); ++i) CHECK(text_of(lines[i]).size() < columns);
    }
  }
  CHECK(heat_map(view, Shades::kCharacters, 80, 1).empty());
  CHECK(heat_map(view, Shades::kCharacters, 4, 20).empty());
  CHECK(heat_map(ArrayView{}, Shades::kCharacters, 80, 20).empty());
}

TEST_CASE("heat map: a cell of several taxels has their mean") {
  ArrayView view = ramp(4, 4);
  view.volts = {0, 0, 1, 1, 0, 0, 1, 1, 1, 1, 0, 0, 1, 1, 0, 0};
  view.dead = {0, 1, 4, 5, 15};  // one cell wholly, one in part
  const auto lines = heat_map(view, Shades::kCharacters, 80, 4);
  REQUIRE(lines.size() == 4);
  CHECK(text_of(lines[1]).substr(0, 6) == "  xx@@");
  CHECK(text_of(lines[2]).substr(0, 6) == "  @@  ");
}

TEST_CASE("heat map: NO_COLOR and a terminal of few colours get characters") {
  const tactbench::tests::Variable colour("NO_COLOR", ""), depth("COLORTERM", "");
  {
    const tactbench::tests::Variable terminal("TERM", "xterm-256color");
    CHECK(shades_of_terminal() == Shades::kColours);
    const tactbench::tests::Variable none("NO_COLOR", "1");
    CHECK(shades_of_terminal() == Shades::kCharacters);
  }
  const tactbench::tests::Variable terminal("TERM", "linux");
  CHECK(shades_of_terminal() == Shades::kCharacters);
  const tactbench::tests::Variable deep("COLORTERM", "truecolor");
  CHECK(shades_of_terminal() == Shades::kColours);
}
