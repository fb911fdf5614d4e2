// Instruments and the limits of the figures by hand: what is stated of each device, and which limits are named when.
#include <catch2/catch.hpp>
#include <string>

#include "analysis/report/sections/sections.h"
#include "tests/analysis/report/sections/printed.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace tactbench::analysis::printed;

namespace {

ReportInput with_device(const char* calibration) {
  ReportInput input;
  input.unit = PressureUnit::kPsi;
  input.run.origin = "hardware";
  input.run.started_utc = "2024-05-06T07:08:09Z";
  input.run.devices = {{"pressure reference", "PT-150", "P-22", "1.2", "hardware", calibration}};
  return input;
}

std::size_t limits_named(const ReportInput& input) { return count(meaning_section(input).value, "<li>"); }

}  // namespace

TEST_CASE("instruments by hand: certificate, who calibrated it, its due day, and what scaled its readings") {
  ReportInput input = with_device(
      R"({"certificate":"C-1","calibrated":"2023-05-06","due":"2024-05-06","span_psi":[0,150],"unit":"psi","note":""})");
  std::string page = instruments_part(input).value;
  check_once(page,
             "<tr><th scope=\"row\">pressure reference<br/>PT-150</th><td>P-22<br/>firmware: 1.2<br/>hardware</td>");
  check_once(page, "certificate: C-1<br/>calibrated by not stated on 2023-05-06<br/>due: 2024-05-06");
  check_once(page, "<td>note: not stated<br/>span_psi: [0,150]<br/>unit: psi</td></tr>");
  check_none(page, "OVERDUE");
  check_none(page, "At least one instrument was overdue");
  input.run.started_utc = "2024-05-07T00:00:00Z";
  page = instruments_part(input).value;
  check_once(page, "OVERDUE since 2024-05-06 when the run was made</span>");
  check_once(page, "At least one instrument was overdue");
  check_none(page, "<br/>due: ");
  input.laboratory.instruments = {{"P-22", "", "a laboratory", "", "", "two years old"}};
  page = instruments_part(input).value;
  check_once(page, "<br/>calibrated by a laboratory on 2023-05-06");
  check_once(page, "<br/>two years old</td>");
  const std::string bare = instruments_part(with_device("{}")).value;
  check_once(bare, "certificate: not stated<br/>due: not stated</td><td>not stated</td></tr>");
  check_once(instruments_part(with_device("as typed")).value, "<td>as typed</td></tr>");
  input.run.devices.clear();
  check_once(instruments_part(input).value, "<tr><td colspan=\"4\">not stated</td></tr>");
}

TEST_CASE("limits of the figures by hand: one for each thing that the run or the report does not have") {
  ReportInput input = with_device("{}");
  const auto page = [&] { return meaning_section(input).value; };
  check_once(page(), "Uncertainty of measurement: not assessed.");
  check_once(page(), "Uniformity of the pressure over the chamber: not assessed.");
  check_none(page(), "The devices and the sensor were simulated.");
  check_none(page(), "Pressure not independently traceable");
  check_none(page(), "U covers creep");
  const std::size_t before = limits_named(input);
  input.run.devices.clear();
  check_once(page(), "Pressure not independently traceable");
  CHECK(limits_named(input) == before + 1);
  input.run.origin = "simulated";
  check_once(page(), "The devices and the sensor were simulated.");
  CHECK(limits_named(input) == before + 2);
  input.more.studies.uniformity.not_assessed.clear();
  CHECK(limits_named(input) == before + 1);
  input.uncertainty.emplace();
  check_once(page(), "Uncertainty of measurement: U is valid for the conditions of use");
  check_none(page(), "U covers creep");
  input.uncertainty->creep.not_assessed.clear();
  input.uncertainty->creep.read_after_s = 2.14;
  input.uncertainty->creep.to_s = 601.6;
  check_once(page(), "U covers creep in indications from 2.1 s to 602 s after the level was commanded");
  CHECK(limits_named(input) == before + 1);
}
