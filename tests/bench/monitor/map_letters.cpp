// The array's picture by the letter: each line of small maps, what a frame's counts become, and how a screen is shared.
#include <catch2/catch.hpp>
#include <string>
#include <utility>
#include <vector>

#include "bench/monitor/array_view.h"
#include "bench/monitor/heat_map.h"
#include "bench/monitor/run_view.h"
#include "bench/monitor/watch_run.h"
#include "tests/bench/monitor/status_example.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

using MapLines = std::vector<std::string>;

// Colours as {number}.
MapLines map_lines(const ArrayView& view, Shades shades, std::size_t columns, std::size_t rows) {
  MapLines lines;
  for (const PaintedLine& line : heat_map(view, shades, columns, rows)) {
    std::string& text = lines.emplace_back();
    for (const Span& span : line)
      text += (span.colour < 0 ? "" : "{" + std::to_string(span.colour) + "}") + span.text + "|";
  }
  return lines;
}

// Its highest output is 2 V.
ArrayView six_taxels() {
  ArrayView view;
  view.title = "T";
  view.rows = 2;
  view.columns = 3;
  view.full_scale_v = 5.0;
  view.volts = {0.0, 0.5, 1.0, 1.5, 2.0, 0.25};
  return view;
}

ArrayView equal_taxels(int rows, int columns) {
  ArrayView view;
  view.title = "T";
  view.rows = rows;
  view.columns = columns;
  view.full_scale_v = 5.0;
  view.volts.assign(static_cast<std::size_t>(rows * columns), 1.0);
  return view;
}

}  // namespace

TEST_CASE("map letters: six taxels in characters, with scale, names and nothing judged") {
  const ArrayView view = six_taxels();
  // Spans of one colour are one.
  MapLines whole = {"  array     T, 2 x 3 taxels|",
                    "  |  ::++|   |@@| from 1.80 V|",
                    "  |##@@..|   |%%| from 1.60 V|",
                    "  |         |##| from 1.40 V|",
                    "  |         |**| from 1.20 V|",
                    "  |         |++| from 1.00 V|",
                    "  |         |==| from 0.80 V|",
                    "  |         |--| from 0.60 V|",
                    "  |         |::| from 0.40 V|",
                    "  |         |..| from 0.20 V|",
                    "  |         |  | from 0.00 V|",
                    "  |         |hottest row 1, column 1  2.00 V|",
                    "  |         |        row 1, column 0  1.50 V|",
                    "  |         |        row 0, column 2  1.00 V|",
                    "  |         |dead    not judged|"};
  CHECK(map_lines(view, Shades::kCharacters, 46, 40) == whole);
  whole.resize(4);
  CHECK(map_lines(view, Shades::kCharacters, 46, 4) == whole);
  CHECK(map_lines(view, Shades::kCharacters, 45, 40) ==
        MapLines{"  array     T, 2 x 3 taxels|", "  |  ::++|", "  |##@@..|"});
  CHECK(map_lines(view, Shades::kCharacters, 45, 3).size() == 3);
}

TEST_CASE("map letters: six taxels in colours, dead ones in neither") {
  ArrayView view = six_taxels();
  view.volts[1] = 0.0;
  view.dead_are_known = true;
  view.dead = {0, 1, 5};
  CHECK(map_lines(view, Shades::kColours, 45, 40) ==
        MapLines{"  array     T, 2 x 3 taxels|", "  |xxxx|{36}  |", "  |{148}  |{226}  |xx|"});
  view.dead.clear();
  CHECK(map_lines(view, Shades::kColours, 45, 40) ==
        MapLines{"  array     T, 2 x 3 taxels|", "  |{17}    |{36}  |", "  |{148}  |{226}  |{53}  |"});
  const MapLines beside = map_lines(view, Shades::kColours, 46, 40);
  CHECK(beside[1] == "  |{17}    |{36}  |   |{226}  | from 1.80 V|");
  CHECK(beside[10] == "  |         |{17}  | from 0.00 V|");
  CHECK(beside[14] == "  |         |dead    none|");
  CHECK(beside.size() == 15);
}

TEST_CASE("map letters: three taxels by name of each kind, equal ones in their order, more by number") {
  ArrayView view = equal_taxels(2, 3);
  view.dead_are_known = true;
  const auto named = [&](std::vector<int> dead) {
    view.dead = std::move(dead);
    MapLines lines = map_lines(view, Shades::kCharacters, 80, 40);
    lines.erase(lines.begin(), lines.begin() + 11);
    for (std::string& line : lines) line = line.substr(13);
    return lines;
  };
  const MapLines hottest = {"hottest row 0, column 0  1.00 V|", "        row 0, column 1  1.00 V|",
                            "        row 0, column 2  1.00 V|"};
  const auto with = [&](const MapLines& more) {
    MapLines all = hottest;
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  CHECK(named({}) == with({"dead    none|"}));
  CHECK(named({4}) == with({"dead    row 1, column 1|"}));
  CHECK(named({0, 2, 5}) == with({"dead    row 0, column 0|", "        row 0, column 2|", "        row 1, column 2|"}));
  CHECK(named({0, 1, 2, 5}) ==
        with({"dead    row 0, column 0|", "        row 0, column 1|", "        row 0, column 2, 1 more|"}));
  CHECK(named({0, 1, 2, 3, 4, 5})[5] == "        row 0, column 2, 3 more|");
  CHECK(map_lines(equal_taxels(1, 2), Shades::kCharacters, 80, 40).size() == 1 + 10 + 2 + 1);
}

TEST_CASE("map letters: cells of more taxels, at the edges of screen and array") {
  ArrayView view = equal_taxels(3, 5);
  view.volts = {2.0, 2.0, 0.0, 0.0, 2.0,  //
                2.0, 2.0, 0.0, 0.0, 0.0,  //
                0.0, 2.0, 2.0, 0.0, 2.0};
  view.dead = {4, 9};
  view.dead_are_known = true;
  // Three rows of cells have no room below the title: 2 x 2 taxels, of which the last have fewer.
  CHECK(map_lines(view, Shades::kCharacters, 40, 3) ==
        MapLines{"  array     T, 3 x 5 taxels|", "  |@@  xx|", "  |++++@@|"});
  CHECK(map_lines(view, Shades::kCharacters, 40, 4).size() == 4);
  CHECK(map_lines(view, Shades::kCharacters, 40, 4)[1] == "  |@@@@    xx|");
  CHECK(map_lines(view, Shades::kCharacters, 13, 40)[1] == "  |@@@@    xx|");
  CHECK(map_lines(view, Shades::kCharacters, 12, 40)[1] == "  |@@  xx|");
  CHECK(map_lines(view, Shades::kCharacters, 9, 40)[1] == "  |@@  xx|");
  CHECK(map_lines(view, Shades::kCharacters, 8, 40).size() == 2);  // 3 x 3 taxels
  CHECK(map_lines(view, Shades::kCharacters, 5, 40).size() == 2);
  CHECK(map_lines(view, Shades::kCharacters, 4, 40).empty());
  CHECK(map_lines(view, Shades::kCharacters, 40, 2).size() == 2);
  const MapLines wide = map_lines(view, Shades::kCharacters, 80, 3);
  CHECK(wide[1] == "  |@@  xx|   |@@| from 1.80 V|");
  const ArrayView large = equal_taxels(32, 32);
  const MapLines named = map_lines(large, Shades::kCharacters, 80, 40);
  CHECK(named.size() == 33);
  CHECK(map_lines(large, Shades::kCharacters, 80, 32)[15] ==
        "  |" + std::string(32, '@') + "|   |cell    mean of 2 x 2 taxels|");
}

TEST_CASE("map letters: no scale ends below a tenth of the converter's range, or at nothing") {
  ArrayView view = equal_taxels(1, 1);
  view.volts = {0.5};
  CHECK(scale_top_v(view) == 0.5);
  view.volts = {0.49};
  CHECK(scale_top_v(view) == 0.5);
  view.full_scale_v = 0.0;
  CHECK(scale_top_v(view) == 0.49);
  view.volts.clear();
  CHECK(scale_top_v(view) == 1e-9);
  CHECK(shade_of(1.8, 2.0) == 9);
  CHECK(shade_of(1.79, 2.0) == 8);
}

TEST_CASE("map letters: a frame's means, its saturated taxels, and from which pressure dead ones are judged") {
  const ArrayBasis basis{0.001, {0.1, 0.1, 0.1, 0.1, 0.1, 0.1}};
  db::SeenFrame frame;
  frame.position = 19;
  frame.rows = 3;
  frame.columns = 2;
  frame.scans = 2;
  frame.reference_psi = 5.0;
  frame.counts = {100, 65535, 151, 149, 65534, 65535, 102, 65535, 151, 149, 65535, 200};
  ArrayView view = view_of_frame(basis, frame);
  CHECK(view.title == "frame 19 at 5.0 psi");
  CHECK((view.rows == 3 && view.columns == 2));
  CHECK(view.full_scale_v == Approx(65.535));
  CHECK(view.volts[0] == Approx(0.101));
  CHECK(view.volts[2] == Approx(0.151));
  CHECK(view.saturated == std::vector<int>{1, 4, 5});
  CHECK(view.dead_are_known);
  CHECK(view.dead == std::vector<int>{0, 3});  // those that rose by less than 50 mV
  frame.reference_psi = 4.99;
  CHECK_FALSE(view_of_frame(basis, frame).dead_are_known);
  frame.reference_psi = 6.0;
  CHECK_FALSE(view_of_frame({0.001, {0.1}}, frame).dead_are_known);
  CHECK_FALSE(view_of_frame({0.001, {}}, frame).dead_are_known);
  CHECK(view_of_frame(basis, frame).dead_are_known);
}

TEST_CASE("map letters: a seating check of another shape, or without one, is none") {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"));
  const Begun begun = begin_example(store);
  std::int64_t time_ns = 0;
  const auto basis_after = [&](const char* kind, const std::string& detail, std::vector<double> data) {
    store.append_check(begun.run, {begun.run, ++time_ns, kind, "pass", detail, std::move(data)});
    return array_basis(store, store.run(begun.run)).value().unloaded_v;
  };
  const std::string well = R"({"pressure_psi":8.0,"rows":1,"columns":2,"volts_per_count":0.5})";
  CHECK(basis_after("tare", well, {1, 2, 3, 4}).empty());
  CHECK(basis_after("seating", well, {1, 2, 3, 4}) == std::vector<double>{0.5, 1.0});
  CHECK(basis_after("tare", well, {5, 6, 7, 8}) == std::vector<double>{0.5, 1.0});  // the newest of seating
  CHECK(basis_after("seating", well, {3, 4, 5, 6}) == std::vector<double>{1.5, 2.0});
  CHECK(basis_after("seating", well, {3, 4}).empty());
  CHECK(basis_after("seating", R"({"rows":0,"columns":2,"volts_per_count":0.5})", {}).empty());
  CHECK(basis_after("seating", R"({"rows":-1,"columns":-2,"volts_per_count":0.5})", {1, 2, 3, 4}).empty());
  CHECK(basis_after("seating", R"({"rows":2,"columns":1,"volts_per_count":0.5})", {1, 2, 3, 4}).size() == 2);
  CHECK(basis_after("seating", "[]", {1, 2, 3, 4}).empty());
  CHECK_FALSE(newest_array(store, store.run(begun.run)));
}

TEST_CASE("map letters: how a screen is shared between lines and map") {
  const auto shared = [](int rows, std::size_t lines, std::size_t screen_rows) {
    const std::vector<std::string> texts(lines, "line");
    const std::vector<PaintedLine> block =
        watch_block(texts, equal_taxels(rows, 2), Shades::kCharacters, {40, screen_rows});
    std::size_t own = 0;
    while (own < block.size() && block[own][0].text == "line") ++own;
    return std::pair(own, block.size() - own);
  };
  using Share = std::pair<std::size_t, std::size_t>;
  // 16 rows and a title; a row stays free; six lines are needed.
  CHECK(shared(16, 9, 27) == Share(9, 17));
  CHECK(shared(16, 9, 26) == Share(8, 17));
  CHECK(shared(16, 9, 24) == Share(6, 17));
  CHECK(shared(16, 9, 23) == Share(6, 9));  // cells of 2 x 2
  CHECK(shared(16, 9, 12) == Share(6, 5));
  CHECK(shared(16, 9, 11) == Share(9, 0));
  CHECK(shared(16, 4, 23) == Share(4, 17));
  CHECK(shared(2, 9, 13) == Share(9, 3));
  CHECK(shared(2, 9, 10) == Share(6, 3));
  CHECK(shared(2, 9, 9) == Share(8, 0));
  CHECK(shared(2, 9, 1) == Share(1, 0));
}

TEST_CASE("map letters: which events show progress, and from when on a silent run is told") {
  db::EventRecord event;
  for (const char* quiet : {"command", "stage", "environment", "fail-safe", "relays", "time", "prompt"}) {
    event.kind = quiet;
    CHECK_FALSE(shows_progress(event));
  }
  for (const char* loud : {"state", "warning", "attempt", "safe", "branch-broken", "", "commands"}) {
    event.kind = loud;
    CHECK(shows_progress(event));
  }
  RunView view;
  view.live = example_live();
  view.live.status.rate = 1.0;
  view.live.status.prompts_left = 0;
  const auto time_line = [&](double age_s) {
    view.live.status.age_s = age_s;
    return view_lines(view)[3];
  };
  const std::string time = "  time      0:01:12 elapsed, 0:10:45 left (0:10:30 to 0:11:20)";
  CHECK(time_line(4.99) == time);
  CHECK(time_line(5.0) == time + "; nothing new for 5 s");
  view.live.status.prompts_left = 2;
  CHECK(time_line(0.0) == "  time      0:01:12 elapsed, 0:10:45 left + 2 prompts (0:10:30 to 0:11:20)");
  view.live.status.left_high_s = 0.0;
  CHECK(time_line(0.0) == "  time      0:01:12 elapsed, time left not known");
  CHECK(view_lines(view)[0] == "run 7 on bench 'rig-1': pausing");
}
