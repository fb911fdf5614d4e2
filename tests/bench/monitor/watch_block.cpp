// What `watch` paints: status and map on screens of several sizes, and the bytes that go to the terminal.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "bench/common/screen.h"
#include "bench/monitor/watch_run.h"

using namespace tactbench::bench;

namespace {

std::vector<std::string> lines(int count) {
  std::vector<std::string> all;
  for (int i = 0; i < count; ++i) all.push_back("line " + std::to_string(i));
  return all;
}

ArrayView array() {
  ArrayView view;
  view.title = "frame 1 at 8.0 psi";
  view.rows = view.columns = 16;
  view.full_scale_v = 5.0;
  view.volts.assign(256, 1.0);
  return view;
}

// Painted in characters: what each line says.
std::vector<std::string> texts(const std::vector<PaintedLine>& block) {
  std::vector<std::string> all;
  for (const PaintedLine& line : block) {
    std::string& text = all.emplace_back();
    for (const Span& span : line) text += span.text;
  }
  return all;
}

std::vector<std::string> block(int count, bool with_array, ScreenSize size) {
  return texts(
      watch_block(lines(count), with_array ? std::optional(array()) : std::nullopt, Shades::kCharacters, size));
}

}  // namespace

TEST_CASE("watch: 80 x 24 holds the needed lines and the whole map, and a row stays free for the cursor") {
  const auto all = block(9, true, {80, 24});
  REQUIRE(all.size() == 23);
  CHECK(all[5] == "line 5");
  CHECK(all[6] == "  array     frame 1 at 8.0 psi, 16 x 16 taxels");
  CHECK(all[22].substr(0, 34) == "  " + std::string(32, '@'));
}

TEST_CASE("watch: a high screen shows all lines, a low one a coarser map or none") {
  CHECK(block(9, true, {80, 30}).size() == 26);
  CHECK(block(9, true, {80, 30})[8] == "line 8");
  const auto low = block(9, true, {80, 16});
  CHECK(low.size() <= 15);
  CHECK(low[6].starts_with("  array"));
  CHECK(low[7].substr(0, 18) == "  " + std::string(16, '@'));  // 2 x 2 taxels in a cell
  const auto lower = block(9, true, {80, 10});
  CHECK(lower == lines(9));
  CHECK(block(9, true, {80, 6}) == lines(5));
  CHECK(block(9, false, {80, 24}) == lines(9));
  CHECK(block(9, true, {3, 24}) == lines(9));  // too narrow for any map
  CHECK(block(9, true, {0, 0}).size() == 1);
}

TEST_CASE("watch: a block is painted over the one before, cut to the terminal's width, with nothing that moves it") {
  const std::vector<PaintedLine> lines{{{"ab"}, {"  ", 17}}, {{"\x1b[2Jcursor\n"}}, {{std::string(30, 'x')}}};
  CHECK(painted(lines, 21, 0) ==
        "ab\x1b[48;5;17m  \x1b[0m\x1b[K\n\\x1b[2Jcursor\\x0a\x1b[K\n" + std::string(19, 'x') + "\u2026\x1b[K\n\x1b[J");
  CHECK(painted({{{"a"}}}, 80, 3) == "\x1b[3Fa\x1b[K\n\x1b[J");
  CHECK(painted({{{"abc"}, {"def"}}}, 4, 0) == "abc\x1b[K\n\x1b[J");
  CHECK(screen_size(-1).columns == 80);
  CHECK(screen_size(-1).rows == 24);
}
