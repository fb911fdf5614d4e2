// Frames by hand: which levels are shown, each cell of both strips, the scales and their ends.
#include <catch2/catch.hpp>
#include <string>

#include "analysis/report/sections/sections.h"
#include "tests/analysis/report/sections/printed.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace tactbench::analysis::printed;

namespace {

LevelFigures frame_level(double pressure, std::vector<double> raw_up, std::vector<double> raw_down,
                         std::vector<double> up, std::vector<double> down, double step) {
  LevelFigures level;
  level.pressure_psi = pressure;
  level.raw_up_v = std::move(raw_up);
  level.raw_down_v = std::move(raw_down);
  level.comp_up_psi = std::move(up);
  level.comp_down_psi = std::move(down);
  level.raw_std_up = 0.0114 + step;
  level.raw_std_down = 0.0224 + step;
  level.raw_distance = 0.0334 + step;
  level.comp_std_up = 0.0444 + step;
  level.comp_std_down = 0.0554 + step;
  level.comp_distance = 0.0664 + step;
  return level;
}

ReportInput two_frames() {
  ReportInput input;
  input.unit = PressureUnit::kPsi;
  input.fit.rows = 1;
  input.fit.columns = 2;
  input.evaluation.full_scale_v = 4.0004;
  input.evaluation.full_scale_psi = 60.04;
  input.evaluation.levels = {frame_level(3.0, {0.5, 1.0}, {0.7, 1.8}, {3.0, kNone}, {5.1, kNone}, 0.0),
                             frame_level(40.0, {1.0, 2.0}, {1.5, 1.6}, {38.0, kNone}, {45.2, kNone}, 0.1)};
  return input;
}

// Pressures of the columns of the first strip, as printed.
std::vector<std::string> columns_of(const std::vector<double>& pressures) {
  ReportInput input = two_frames();
  input.evaluation.levels.clear();
  for (const double pressure : pressures)
    input.evaluation.levels.push_back(frame_level(pressure, {0.0, 1.0}, {0.0, 1.0}, {0.0, 1.0}, {0.0, 1.0}, 0.0));
  const std::string page = frames_section(input).value, begin = "<th scope=\"col\">";
  const std::string head = page.substr(0, page.find("</thead>"));
  std::vector<std::string> columns;
  for (std::size_t at = head.find(begin); at != std::string::npos; at = head.find(begin, at + 1))
    columns.push_back(head.substr(at + begin.size(), head.find(" psi", at) - at - begin.size()));
  return columns;
}

std::string cell_drawn(const std::string& title, std::vector<double> values, double high) {
  return "<td>" + frame_map({title, 1, 2, std::move(values), {0.0, high}, 78.0}).value + "</td>";
}

std::string words_row(const std::string& head, const std::string& first, const std::string& second) {
  return "<tr><th scope=\"row\">" + head + "</th><td>" + first + "</td><td>" + second + "</td></tr>";
}

}  // namespace

TEST_CASE("frames by hand: the level nearest to each of seven pressures, within 1 psi, the lower of two as near") {
  using Columns = std::vector<std::string>;
  CHECK(columns_of({0.0, 3.0, 9.0, 19.0, 29.0, 39.0, 49.0, 59.0}) == Columns{"3", "9", "19", "29", "39", "49", "59"});
  CHECK(columns_of({5.0, 11.0, 21.0, 31.0, 41.0, 51.0, 61.0}) == Columns{"5", "11", "21", "31", "41", "51", "61"});
  CHECK(columns_of({2.9, 5.1, 8.9, 11.1, 18.9, 21.1, 28.9, 31.1, 38.9, 41.1, 48.9, 51.1, 58.9, 61.1}).empty());
  CHECK(columns_of({19.0, 21.0}) == Columns{"19"});
  CHECK(columns_of({19.2, 20.4, 20.6}) == Columns{"20"});
  CHECK(columns_of({58.0, 60.0, 62.0}) == Columns{"60"});
  CHECK(columns_of({}).empty());
}

TEST_CASE("frames by hand: cells, spreads and hysteresis of both strips on their scales") {
  const std::string page = frames_section(two_frames()).value;
  check_once(page, "<table class=\"strip\" id=\"frames-raw\">");
  check_once(page, "<table class=\"strip\" id=\"frames-compensated\">");
  CHECK(count(page, "<th scope=\"col\">3 psi<br/>21 kPa</th><th scope=\"col\">40 psi<br/>276 kPa</th></tr>") == 2);
  // 2 V are the highest, 60.04 psi end the scale. Of 4.0004 V 0.8 V are 20.0 %, of 60.04 psi 7.2 psi 11.99 %: the
  // scales reach to 20 and 15 %.
  const auto share = [](double difference, double full) { return 100.0 * difference / full; };
  for (const std::string& cell :
       {cell_drawn("Indication, increasing, 3 psi", {0.5, 1.0}, 2.0),
        cell_drawn("Indication, increasing, 40 psi", {1.0, 2.0}, 2.0),
        cell_drawn("Indication, decreasing, 3 psi", {0.7, 1.8}, 2.0),
        cell_drawn("Indication, decreasing, 40 psi", {1.5, 1.6}, 2.0),
        cell_drawn("Indication, hysteresis, 3 psi", {share(0.2, 4.0004), share(0.8, 4.0004)}, 20.0),
        cell_drawn("Indication, hysteresis, 40 psi", {share(0.5, 4.0004), share(0.4, 4.0004)}, 20.0),
        cell_drawn("Corrected indication, increasing, 3 psi", {3.0, kNone}, 60.04),
        cell_drawn("Corrected indication, increasing, 40 psi", {38.0, kNone}, 60.04),
        cell_drawn("Corrected indication, decreasing, 3 psi", {5.1, kNone}, 60.04),
        cell_drawn("Corrected indication, decreasing, 40 psi", {45.2, kNone}, 60.04),
        cell_drawn("Corrected indication, hysteresis, 3 psi", {share(2.1, 60.04), kNone}, 15.0),
        cell_drawn("Corrected indication, hysteresis, 40 psi", {share(7.2, 60.04), kNone}, 15.0)})
    check_once(page, cell);
  check_once(page, words_row("s, % FS", "1.1", "11.1"));
  check_once(page, words_row("s, % FS", "2.2", "12.2"));
  check_once(page, words_row("mean, % FS", "3.3", "13.3"));
  check_once(page, words_row("s, % FS", "4.4", "14.4"));
  check_once(page, words_row("s, % FS", "5.5", "15.5"));
  check_once(page, words_row("mean, % FS", "6.6", "16.6"));
  check_once(page, colour_bar({0.0, 2.0}, "Colour scale of the frames of the indication", "V", 2).value);
  check_once(page, colour_bar({0.0, 20.0}, "Colour scale of the hysteresis of the indication", "% FS", 0).value);
  check_once(page,
             pressure_bar({0.0, 60.04}, "Colour scale of the frames of the corrected indication", PressureUnit::kPsi, 0)
                 .value);
  check_once(page,
             colour_bar({0.0, 15.0}, "Colour scale of the hysteresis of the corrected indication", "% FS", 0).value);
  check_once(page, "highest mean output, 4.000 V; of the corrected indication: full pressure, " + psi(60.04, 1) + ".");
}

TEST_CASE("frames by hand: scales of nothing have a length, and the hysteresis scale has at least 5 % of full scale") {
  ReportInput input = two_frames();
  for (LevelFigures& level : input.evaluation.levels) {
    level.raw_up_v = level.raw_down_v = {0.0, kNone};
    level.comp_up_psi = level.comp_down_psi = {0.0};  // shorter than the array: the other has no value
  }
  input.evaluation.full_scale_psi = 0.0;
  std::string page = frames_section(input).value;
  check_once(page, colour_bar({0.0, 1.0}, "Colour scale of the frames of the indication", "V", 2).value);
  check_once(
      page,
      pressure_bar({0.0, 1.0}, "Colour scale of the frames of the corrected indication", PressureUnit::kPsi, 0).value);
  check_once(page, colour_bar({0.0, 5.0}, "Colour scale of the hysteresis of the indication", "% FS", 0).value);
  check_once(page, cell_drawn("Indication, hysteresis, 3 psi", {0.0, kNone}, 5.0));
  input.evaluation.full_scale_psi = 0.5;
  page = frames_section(input).value;
  check_once(
      page,
      pressure_bar({0.0, 0.5}, "Colour scale of the frames of the corrected indication", PressureUnit::kPsi, 0).value);
  // Below 1 V the highest output ends the scale, too.
  input.evaluation.levels[1].raw_down_v = {0.25, 0.5};
  check_once(frames_section(input).value,
             colour_bar({0.0, 0.5}, "Colour scale of the frames of the indication", "V", 2).value);
  input.evaluation.levels.clear();
  check_once(frames_section(input).value, "<p>not available</p>");
}
