// Objects by hand: the charts of force and area, the budget of the force sensor, the words of each press.
#include <catch2/catch.hpp>
#include <string>

#include "analysis/report/sections/sections.h"
#include "tests/analysis/report/sections/printed.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace tactbench::analysis::printed;

namespace {

ContactLevel pressed_level(double target, bool rising, double force, double raw, double corrected) {
  ContactLevel level;
  level.target_n = target;
  level.rising = rising;
  level.frames = 1;
  level.force_n = force;
  level.raw.force_n = raw;
  level.raw.area_mm2 = 10.0 * raw;
  level.compensated.force_n = corrected;
  level.compensated.area_mm2 = 20.0 * corrected;
  return level;
}

ReportInput under_an_object() {
  ReportInput input;
  input.unit = PressureUnit::kPsi;
  ContactResult contact;
  contact.run = 21;
  contact.sequence = "ring";
  contact.positions = 2;
  contact.repeats = 3;
  contact.levels = {pressed_level(1.0, true, 1.1, 1.5, 1.2), pressed_level(2.0, true, 2.2, 2.6, 2.3),
                    pressed_level(1.0, false, 0.9, 1.9, 1.0), pressed_level(0.5, false, 0.4, 0.7, 0.5)};
  contact.raw_mean_error_n = contact.compensated_mean_error_n = 0.5;
  input.more.contacts = {contact};
  return input;
}

InstrumentRow budget_line(const char* name, double width, double divisor, ChainPart part = {}) {
  InstrumentRow line;
  line.name = name;
  line.distribution = "rectangular";
  line.width = width;
  line.divisor = divisor;
  line.part = std::move(part);
  return line;
}

}  // namespace

TEST_CASE("objects by hand: force of the array over the sensor's, each way, beside an ideal line, and areas as dots") {
  const std::string page = objects_section(under_an_object()).value;
  LineChart chart{.title = "Total force of the array against the force sensor, ring",
                  .x_label = "force sensor, N",
                  .y_label = "array, N",
                  .series = {{"force sensor", {0.0, 2.2}, {0.0, 2.2}, 0},
                             {"indication, incr.", {1.1, 2.2}, {1.5, 2.6}, 1},
                             {"indication, decr.", {0.9, 0.4}, {1.9, 0.7}, 4},
                             {"corrected, incr.", {1.1, 2.2}, {1.2, 2.3}, 2},
                             {"corrected, decr.", {0.9, 0.4}, {1.0, 0.5}, 3}},
                  .width = 335,
                  .height = 260,
                  .y_from_zero = true};
  check_once(page, line_chart(chart).value);
  ReportInput light = under_an_object();
  light.more.contacts[0].levels.resize(1);
  light.more.contacts[0].levels[0] = pressed_level(0.5, true, 0.6, 0.7, 0.65);
  LineChart lighter = chart;
  lighter.series = {{"force sensor", {0.0, 0.6}, {0.0, 0.6}, 0},
                    {"indication, incr.", {0.6}, {0.7}, 1},
                    {"indication, decr.", {}, {}, 4},
                    {"corrected, incr.", {0.6}, {0.65}, 2},
                    {"corrected, decr.", {}, {}, 3}};
  check_once(objects_section(light).value, line_chart(lighter).value);
  const std::vector<double> x = {1.1, 2.2, 0.9, 0.4};
  chart.title = "Contact area over the force, ring";
  chart.y_label = "area, mm²";
  chart.series = {{"indication", x, {15.0, 26.0, 19.0, 7.0}, 1, true},
                  {"corrected", x, {24.0, 46.0, 20.0, 10.0}, 2, true}};
  check_once(page, line_chart(chart).value);
}

TEST_CASE("objects by hand: the words of a press: its object, frames, what is worse, whose certificate") {
  ReportInput input = under_an_object();
  ContactResult& contact = input.more.contacts[0];
  std::string page = objects_section(input).value;
  check_once(page, "<h3>ring, run 21</h3>");
  check_once(page, "means over 1 frame a level");
  check_none(page, "The corrected total force is worse");  // alike is not worse
  check_none(page, "taxels stood at the highest pressure");
  check_none(page, "Under the object: ");
  check_once(page, "not assessed, no registration of the stage");
  check_once(page, "highest pressure and of " + psi(0.5, 1) + "; centre");
  contact.object = "a ring";
  contact.force_traceability = "Force measured by a sensor.";
  contact.mount_run = 1;
  contact.levels[1].clamped_taxels = 0.25;
  contact.levels[2].clamped_taxels = 1.14;
  page = objects_section(input).value;
  check_once(page, "<h3>a ring, run 21</h3>");
  check_once(page, "<p>Sequence ring: places: 2, repeats: 3.");
  check_once(page, "<p>Force measured by a sensor.</p>");
  check_once(page, "by the registration of run 1.</p>");
  check_once(page, "Up to 1.1 taxels stood at the highest pressure");
  check_once(page, "colspan=\"2\">indication</th><th scope=\"colgroup\" colspan=\"2\">corrected</th>");
  CHECK(count(page, "class=\"n\">wanders, mm</th>") == 2);
  CHECK(count(page, "class=\"n\">less sensor, N</th>") == 2);
  check_none(page, "class=\"n\">x, mm</th>");
  contact.positions = 1;
  page = objects_section(input).value;
  CHECK(count(page, "class=\"n\">x, mm</th>") == 2);
  // x, y, Mx, My, wanders, off axis
  check_once(page, "colspan=\"6\">indication</th><th scope=\"colgroup\" colspan=\"6\">corrected</th>");
  input.more.contacts.clear();
  check_once(objects_section(input).value, "not assessed: no run with an object on the stage was given.");
}

TEST_CASE("objects by hand: the force sensor's budget, row by row, and U as twice the root of the sum of squares") {
  ReportInput input = under_an_object();
  InstrumentUncertainty& force = input.more.contacts[0].force_uncertainty;
  force.unit = "N";
  // 0.06 / 2 = 0.03 and 0.12345 / 3 = 0.04115 N: together 0.0509 N.
  force.rows = {budget_line("certificate", 0.06, 2.0), budget_line("drift", 0.12345, 3.0),
                budget_line("resolution", 0.0, 1.0, {"no certificate", ""}),
                budget_line("input", 0.0, 1.0, {"", "in the certificate"})};
  const auto page = [&] { return objects_section(input).value; };
  check_once(page(), "<tr><th scope=\"row\">certificate</th><td class=\"n\">0.06</td><td>rectangular</td>" +
                         numbers({"2", "0.030"}) + "</tr>");
  check_once(page(), "<tr><th scope=\"row\">drift</th><td class=\"n\">0.123</td><td>rectangular</td>" +
                         numbers({"3", "0.041"}) + "</tr>");
  check_once(page(), "<tr><th scope=\"row\">resolution</th><td colspan=\"4\">not assessed: no certificate</td></tr>");
  check_once(page(), "<tr><th scope=\"row\">input</th><td colspan=\"4\">in the certificate</td></tr>");
  check_once(page(), "<th scope=\"row\">expanded</th><td colspan=\"3\">U = 2 u_c</td><td class=\"n\">0.10</td></tr>");
  check_none(page(), "U of the force sensor: not assessed");
  force.rows.erase(force.rows.begin(), force.rows.begin() + 2);
  check_none(page(), "U = 2 u_c");
}
