// Rows of the sections on objects, on the indication and on studies by hand: numbers given, cells printed.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"
#include "tests/analysis/report/report_example_full.h"
#include "tests/analysis/report/report_page.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

// A row of a table: its head, then cells of numbers or words.
std::string row_by_hand(const std::string& head, const std::vector<std::string>& cells, bool number_head = false) {
  std::string row =
      number_head ? "<tr><th scope=\"row\" class=\"n\">" + head + "</th>" : "<tr><th scope=\"row\">" + head + "</th>";
  for (const std::string& cell : cells) row += "<td class=\"n\">" + cell + "</td>";
  return row + "</tr>";
}

void check_row(const std::string& page, const std::string& row) {
  INFO(row);
  CHECK(count(page, row) == 1);
}

ContactResult pressed() {
  ContactResult contact;
  contact.run = 21;
  contact.sequence = "ring";
  contact.positions = 3;
  contact.repeats = 2;
  contact.full_scale_v = 4.0;
  contact.full_scale_psi = 40.0;
  ContactLevel up, down;
  up.target_n = 2.5;
  up.frames = 6;
  up.force_n = 2.4567;
  up.torque_nmm = 1.2344;
  up.raw = {3.0, 0.126, -0.254, 1.26, -2.34, 64.52, 0.5};
  up.compensated = {2.25, 0.5, 0.75, -1.14, 3.36, 51.61, 0.5};
  up.raw_place_error_mm = 0.456;
  up.compensated_place_error_mm = std::numeric_limits<double>::quiet_NaN();
  up.raw_wander_mm = 0.0214;
  up.compensated_wander_mm = 0.0336;
  up.clamped_taxels = 1.27;
  down = up;
  down.rising = false;
  down.target_n = 1.0;
  down.clamped_taxels = 0.5;
  contact.levels = {up, down};
  contact.raw_mean_error_n = 0.516;
  contact.raw_max_error_n = 0.766;
  contact.compensated_mean_error_n = 0.504;
  contact.compensated_max_error_n = 0.626;
  return contact;
}

}  // namespace

TEST_CASE("objects by hand: forces less the sensor's, areas, places, moments, and the errors in words") {
  ReportInput input = example::example_input();
  input.more.contacts = {pressed()};
  const auto page = [&] { return objects_section(input).value; };
  std::string text = page();
  check_row(text, row_by_hand("2.5", {"increasing", "2.457", "3.00", "0.54", "64.5", "2.25", "−0.21", "51.6"}, true));
  check_row(text, row_by_hand("1.0", {"decreasing", "2.457", "3.00", "0.54", "64.5", "2.25", "−0.21", "51.6"}, true));
  check_row(text, row_by_hand("2.5", {"increasing", "0.021", "0.46", "0.034", "–", "1.234"}, true));
  CHECK(contains(text, "means over 6 frames a level"));
  CHECK(contains(text, "places: 3, repeats: 2."));
  CHECK(contains(text, "indication 0.52 N on average, at most 0.77 N; corrected 0.50 N on average, at most 0.63 N."));
  CHECK(contains(text, "Up to 1.3 taxels stood at the highest pressure"));
  CHECK(contains(text, "sum of pressure times 6.4516 mm², the effective area of a taxel, pitch 2.54 mm."));
  CHECK(count(text, "colspan=\"2\">indication</th>") == 1);
  CHECK_FALSE(contains(text, "The corrected total force is worse"));
  CHECK_FALSE(contains(text, "<table class=\"strip\">"));
  CHECK(contains(text, "U of the force sensor: not assessed, none is stored with the run."));
  CHECK(contains(text, "not assessed, no registration"));
  // At one place the centre and the moments have their columns, and the frames their strips.
  input.more.contacts[0].positions = 1;
  input.more.contacts[0].mount_run = 8;
  input.more.contacts[0].compensated_mean_error_n = 0.517;
  for (ContactLevel& level : input.more.contacts[0].levels) level.clamped_taxels = 0.0;
  text = page();
  check_row(text, row_by_hand("2.5",
                              {"increasing", "0.13", "−0.25", "1.3", "−2.3", "0.021", "0.46", "0.50", "0.75", "−1.1",
                               "3.4", "0.034", "–", "1.234"},
                              true));
  CHECK(count(text, "colspan=\"6\">indication</th>") == 1);
  CHECK(contains(text, "The corrected total force is worse"));
  CHECK(count(text, "<table class=\"strip\">") == 2);
  CHECK(contains(text, "by the registration of run 8.</p>"));
  CHECK_FALSE(contains(text, "stood at the highest pressure"));
}

TEST_CASE("the indication by hand: hysteresis, sensitivity, repeatability, zero deviation, creep") {
  ReportInput input = example::example_input();
  Behaviour& b = input.behaviour;
  b = {};
  b.taxels = {0, 1, 2};
  b.pressure_psi = {0.0, 20.0, 40.0};
  b.full_scale_v = 2.5;
  RawLoop mean;
  mean.name = "mean";
  mean.up_v = {0.0, 1.0, 2.5};
  mean.down_v = {0.0, 1.5, 2.5};
  mean.full_scale_v = 2.5;
  mean.hysteresis_max = 0.2;
  mean.hysteresis_mean = 0.0667;
  b.loops = {mean};
  b.gain = {0.9, 1.0, 1.15};
  b.equilibration_psi = 20.0;
  b.repeats = 4;
  b.repeatability = {{0.0, 1e-3, 2e-3, 3e-3, 4e-3}, {20.0, 5e-3, 1e-3, 2e-3, 8e-3}, {40.0, 2e-3, 6e-3, 7e-3, 1e-3}};
  b.zero_returns = {{"loop", 3, -0.00125, 0.00275, 0.0105, 18}};
  Creep creep;
  creep.sequence = "hold";
  creep.pressure_psi = 20.0;
  creep.from_s = 2.0;
  creep.to_s = 202.5;
  creep.first_v = 1.23456;
  creep.last_v = 1.25;
  creep.per_decade = 0.01234;
  creep.per_decade_u = 0.00056;
  creep.up = true;
  b.creep = {creep};
  input.evaluation.levels.clear();
  const std::string text = raw_section(input).value;
  CHECK(contains(text, "<td class=\"n\">20.0</td><td class=\"n\">6.7</td><td class=\"n\">2.500</td></tr>"));
  CHECK(contains(text, "<td class=\"n\">25.3</td><td class=\"n\">10.0</td>"));
  // 0.1 and 0.15 off 1 over n - 1: sqrt((0.01 + 0.0225) / 2) = 12.75 %.
  CHECK(contains(text, "Standard deviation 12.7 %, lowest 0.90, highest 1.15."));
  CHECK(contains(text, "Standard deviation over 4 repeats"));
  const std::string zero = html::pressure(0.0, input.unit, 0).value, at_20 = html::pressure(20.0, input.unit, 0).value,
                    at_40 = html::pressure(40.0, input.unit, 0).value;
  check_row(text, row_by_hand("mean taxel, increasing", {"5.00", "0.200", at_20}));
  check_row(text, row_by_hand("mean taxel, decreasing", {"6.00", "0.240", at_40}));
  check_row(text, row_by_hand("a taxel (rms over taxels), increasing", {"7.00", "0.280", at_40}));
  check_row(text, row_by_hand("a taxel (rms over taxels), decreasing", {"8.00", "0.320", at_20}));
  CHECK(contains(text,
                 "<tr><th scope=\"row\">loop</th><td class=\"n\">3</td><td class=\"n\">−1.25</td><td class=\"n\">−0.050"
                 "</td><td class=\"n\">2.75</td><td class=\"n\">10.50</td><td>row 1, column 2</td></tr>"));
  CHECK(contains(text,
                 "<td class=\"state\">increasing</td><td class=\"n\">2.0</td><td class=\"n\">202.5</td><td "
                 "class=\"n\">1.2346</td><td class=\"n\">1.2500</td><td class=\"n\">1.234 ± 0.056</td></tr>"));
  CHECK_FALSE(contains(text, "not assessed"));
  // One taxel that counts has no deviation; of nothing each part says so.
  b.gain = {std::numeric_limits<double>::quiet_NaN(), 1.5, std::numeric_limits<double>::quiet_NaN()};
  CHECK(contains(raw_section(input).value, "Standard deviation not available %, lowest 1.50, highest 1.50."));
  b.repeatability.clear();
  b.zero_returns.clear();
  b.creep.clear();
  b.loops.clear();
  const std::string none = raw_section(input).value;
  CHECK(count(none, "not assessed: ") == 3);
  CHECK(contains(none, "Loops and hysteresis: not assessed"));
}

TEST_CASE("mounting and uniformity by hand: shares, standard deviations, colour scales") {
  Remount remount;
  remount.not_assessed.clear();
  remount.runs = {12, 13, 17};
  remount.degrees = 2;
  remount.within_share = 0.0123;
  remount.s_share = 0.0345;
  remount.pressure_psi = {20.0};
  remount.within_psi = {0.1234};
  remount.between_psi = {0.2345};
  remount.mean_between_psi = {0.0456};
  remount.taxel_between_psi = {0.25, 0.5};
  const auto psi = [](double value, int digits) {
    return html::pressure(value, PressureUnit::kKilopascal, digits).value;
  };
  const std::string mounts = remount_part(remount, 1, 2, PressureUnit::kKilopascal).value;
  CHECK(contains(mounts, "<p>3 mounts of the sensor, runs 12, 13, 17,"));
  CHECK(contains(mounts, "within a mount 1.23 % of the reading, between mounts 3.45 % of the reading (2 degrees"));
  CHECK(contains(mounts, "<td class=\"n\">" + psi(0.1234, 3) + "</td><td class=\"n\">" + psi(0.2345, 3) +
                             "</td><td class=\"n\">" + psi(0.0456, 3) + "</td></tr>"));
  CHECK(contains(mounts, "width=\"190\" height=\"95\"><title>Standard deviation between mounts of each taxel"));

  Uniformity u;
  u.not_assessed.clear();
  u.runs = {12, 15};
  u.angles_deg = {0, 180};
  u.pressure_psi = {20.0};
  u.u_psi = {0.1};
  u.residual_psi = {0.01};
  u.chamber_share = {0.005, -0.0125};
  u.sensor_share = {-0.02, 0.01};
  u.u_share = 0.0067;
  u.u_offset_psi = 0.0123;
  u.residual_rms_psi = 0.02;
  u.undetermined = 2;
  const auto even = [&] { return uniformity_part(u, 1, 2, PressureUnit::kKilopascal).value; };
  u.residual_other_sense_psi = 0.0181;
  CHECK(contains(even(), "Runs 12, 15 of the sensor turned in the chamber by 0°, 180° (counter-clockwise"));
  CHECK(contains(even(), "0.67 % of the pressure"));
  CHECK(contains(even(), psi(0.0123, 3)));
  CHECK(contains(even(), "2 sets of places"));
  CHECK(contains(even(), "<p class=\"scale\">−1.25 % <svg"));  // as much below as above
  CHECK(contains(even(), "</svg> 1.25 %</p>"));
  CHECK(contains(even(), "<p class=\"scale\">−2.00 % <svg"));
  CHECK(contains(even(), "</svg> 2.00 %</p>"));
  CHECK_FALSE(contains(even(), "were the angles taken clockwise?"));
  u.residual_other_sense_psi = 0.0179;  // less than nine tenths
  CHECK(contains(even(), "were the angles taken clockwise?"));
  u.chamber_share = {0.0, std::numeric_limits<double>::quiet_NaN()};
  CHECK(contains(even(), "</svg> 1.00 %</p>"));
}
