// The strips of frames under an object by hand: sizes, colours, titles and figures of each cell.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>

#include "analysis/report/page/figure.h"
#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"
#include "tests/analysis/report/report_page.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

constexpr double kNoReading = std::numeric_limits<double>::quiet_NaN();

ContactLevel contact_level_of(double target, bool rising, std::vector<double> volts, std::vector<double> psi,
                              double raw_std, double compensated_std) {
  ContactLevel level;
  level.target_n = target;
  level.rising = rising;
  level.raw_v = std::move(volts);
  level.compensated_psi = std::move(psi);
  level.raw_std = raw_std;
  level.compensated_std = compensated_std;
  return level;
}

// One row of two taxels, 2 N going up and down, 6 N going up alone; full scale 4 V and 40 psi.
ContactResult two_taxels_pressed() {
  ContactResult contact;
  contact.full_scale_v = 4.0;
  contact.full_scale_psi = 40.0;
  contact.levels = {contact_level_of(2.0, true, {0.5, 1.0}, {10.0, 20.0}, 0.011, 0.021),
                    contact_level_of(6.0, true, {1.0, 2.0}, {20.0, kNoReading}, 0.012, 0.022),
                    contact_level_of(2.0, false, {1.0, 0.9}, {12.0, 19.0}, 0.013, 0.023)};
  contact.raw_distance = {0.075, kNoReading};
  contact.compensated_distance = {0.0375, kNoReading};
  return contact;
}

// A map of one row of two taxels, 78 wide: cells of 39, one colour below and one beside it.
std::string two_cells_drawn(const std::string& title, double first, double second) {
  return "<td><svg role=\"img\" class=\"map\" viewBox=\"0 0 78 39\" width=\"78\" height=\"39\"><title>" + title +
         "</title><g transform=\"scale(39)\">" +
         frame_map({title, 1, 2, {first, second}, {0.0, 1.0}, 78.0})
             .value.substr(frame_map({title, 1, 2, {first, second}, {0.0, 1.0}, 78.0}).value.find("<path")) +
         "</td>";
}

}  // namespace

TEST_CASE("frames under an object by hand: each strip's cells, 78 wide, coloured by shares of the highest value") {
  const std::string page = contact_frames_part(two_taxels_pressed(), 1, 2, PressureUnit::kKilopascal).value;
  CHECK(count(page, "<svg role=\"img\" class=\"map\" viewBox=\"0 0 78 39\" width=\"78\" height=\"39\">") == 8);
  CHECK(count(page, " class=\"map\" ") == 8);
  // Of the indication 2 V are the highest, of the corrected one 20 psi; hysteresis is 30 % at the scale's end.
  for (const std::string& cell :
       {two_cells_drawn("Indication under the object, increasing, 2 N", 0.25, 0.5),
        two_cells_drawn("Indication under the object, increasing, 6 N", 0.5, 1.0),
        two_cells_drawn("Indication under the object, decreasing, 2 N", 0.5, 0.45),
        two_cells_drawn("Indication under the object, hysteresis, 2 N", 12.5 / 30.0, 2.5 / 30.0),
        two_cells_drawn("Corrected indication under the object, increasing, 2 N", 0.5, 1.0),
        two_cells_drawn("Corrected indication under the object, increasing, 6 N", 1.0, kNoReading),
        two_cells_drawn("Corrected indication under the object, decreasing, 2 N", 0.6, 0.95),
        two_cells_drawn("Corrected indication under the object, hysteresis, 2 N", 5.0 / 30.0, 2.5 / 30.0)}) {
    INFO(cell);
    CHECK(count(page, cell) == 1);
  }
}

TEST_CASE("frames under an object by hand: heads, spreads, means of hysteresis and what is worse") {
  ContactResult contact = two_taxels_pressed();
  const auto page = [&] { return contact_frames_part(contact, 1, 2, PressureUnit::kKilopascal).value; };
  const std::string text = page();
  CHECK(count(text, "<td></td><th scope=\"col\">2 N</th><th scope=\"col\">6 N</th></tr>") == 2);
  CHECK(count(text, "<tr><th scope=\"row\">s, % FS</th><td>1.1</td><td>1.2</td></tr>") == 1);
  CHECK(count(text, "<tr><th scope=\"row\">s, % FS</th><td>1.3</td><td>–</td></tr>") == 1);
  CHECK(count(text, "<tr><th scope=\"row\">s, % FS</th><td>2.1</td><td>2.2</td></tr>") == 1);
  CHECK(count(text, "<tr><th scope=\"row\">s, % FS</th><td>2.3</td><td>–</td></tr>") == 1);
  CHECK(count(text, "<tr><th scope=\"row\">mean, % FS</th><td>7.5</td><td>–</td></tr>") == 1);
  CHECK(count(text, "<tr><th scope=\"row\">mean, % FS</th><td>3.8</td><td>–</td></tr>") == 1);  // 3.75
  CHECK(contains(text, "<p class=\"scale\">0.00 V <svg"));
  CHECK(contains(text, "</svg> 2.00 V</p>"));
  CHECK(contains(text, "<p class=\"scale\">0 % FS <svg"));
  CHECK(contains(text, "</svg> 30 % FS</p>"));
  CHECK(contains(
      text, "that of the chamber run, 4.000 V and " + html::pressure(40.0, PressureUnit::kKilopascal, 1).value + ";"));
  CHECK_FALSE(contains(text, "larger than"));
  contact.compensated_distance = {0.076, kNoReading};
  CHECK(contains(page(), "indication</span> at 2 N.</p>"));
  contact.raw_distance[1] = 0.01;
  contact.compensated_distance[1] = 0.02;
  CHECK(contains(page(), "indication</span> at 2 N, 6 N.</p>"));
  contact.compensated_distance = contact.raw_distance;  // alike is not larger
  CHECK_FALSE(contains(page(), "larger than"));
  // Below 1 V the highest output ends the scale, too.
  for (ContactLevel& level : contact.levels) level.raw_v = {0.25, 0.5};
  CHECK(contains(page(), "</svg> 0.50 V</p>"));
  // Nothing above 0: the scale has a length all the same.
  for (ContactLevel& level : contact.levels) level.raw_v = level.compensated_psi = {0.0, kNoReading};
  CHECK(contains(page(), "</svg> 1.00 V</p>"));
}
