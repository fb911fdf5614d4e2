// What is stated of an instrument's calibration, field by field: units, dates, notes of another certificate, and
// scanners.
#include <catch2/catch.hpp>

#include "analysis/statistics/uncertainty/instrument_calibration.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

db::DeviceRecord instrument_with(const std::string& json) { return {"force sensor", "F", "S-1", "", "hardware", json}; }
std::string stated_u(const std::string& json) { return calibration_of(instrument_with(json)).uncertainty; }

InstrumentCalibration noted(const std::string& json, const InstrumentNote& note) {
  return calibration_of(instrument_with(json), std::vector<InstrumentNote>{note});
}

}  // namespace

TEST_CASE("calibration: U in each unit, the correction's largest with its factor, and what is no U") {
  CHECK(stated_u(R"({"expanded_uncertainty_psi":0.05})") == "U 0.05 psi (k = 2)");
  CHECK(stated_u(R"({"expanded_uncertainty_n":0.3})") == "U 0.3 N (k = 2)");
  CHECK(stated_u(R"({"expanded_uncertainty_mm":0.01})") == "U 0.01 mm (k = 2)");
  CHECK(stated_u(R"({"expanded_uncertainty_c":0.2})") == "U 0.2 K (k = 2)");
  CHECK(stated_u(R"({"correction":{"expanded_uncertainty_psi":[0.3,"x",0.2]}})") ==
        "U at most 0.3 psi (k = 2), of its correction");
  CHECK(stated_u(R"({"correction":{"expanded_uncertainty_psi":[0.1],"coverage_factor":-3}})") ==
        "U at most 0.1 psi (k = 2), of its correction");
  // A correction without U gives way to the one figure.
  for (const char* empty : {R"({})", R"({"expanded_uncertainty_psi":[]})", R"({"expanded_uncertainty_psi":[0]})",
                            R"({"expanded_uncertainty_psi":0.7})", "7"})
    CHECK(stated_u(std::string(R"({"expanded_uncertainty_psi":0.05,"correction":)") + empty + "}") ==
          "U 0.05 psi (k = 2)");
  for (const char* none : {"{}", R"({"expanded_uncertainty_n":0})", R"({"expanded_uncertainty_n":-0.1})",
                           R"({"expanded_uncertainty_n":"0.1"})", "[]", ""})
    CHECK(stated_u(none).empty());
}

TEST_CASE("calibration: a laboratory's certificate fills what is open, and speaks of nothing when it is another one") {
  const InstrumentNote note{"S-1", "C-2", "PTB", "2025-01-31", "2026-01-31", "shelf 3"};
  const InstrumentCalibration all = noted("{}", note);
  CHECK((all.certificate == "C-2" && all.calibrated_by == "PTB" && all.calibrated_on == "2025-01-31"));
  CHECK((all.due == "2026-01-31" && all.note == "shelf 3" && all.remarks.empty()));
  CHECK(all.traceable());
  // Another date is another calibration, too: certificate and maker stay open; the due date is filled in all the same.
  const InstrumentCalibration other = noted(R"({"calibrated":"2024-01-31"})", note);
  CHECK((other.certificate.empty() && other.calibrated_by.empty() && other.calibrated_on == "2024-01-31"));
  CHECK(other.due == "2026-01-31");
  CHECK(other.note == "shelf 3");
  REQUIRE(other.remarks.size() == 1);
  CHECK(other.remarks[0] ==
        "contradiction: calibrated 2024-01-31 by the run, 2025-01-31 by the laboratory file; that of the run counts");
  const InstrumentCalibration another = noted(R"({"certificate":"C-1"})", note);
  CHECK((another.certificate == "C-1" && another.calibrated_on.empty() && another.calibrated_by.empty()));
  CHECK(noted(R"({"due":"2025-12-31"})", note).due == "2025-12-31");
  CHECK(noted(R"({"due":"2026-02-01"})", note).due == "2026-01-31");
  CHECK(noted(R"({"due":"2026-02-01"})", note).remarks.size() == 1);
  // Of another instrument, and of one without a number.
  CHECK(noted("{}", {"S-2", "C-2", "PTB", "", "", ""}).certificate.empty());
  db::DeviceRecord unnamed = instrument_with("{}");
  unnamed.serial.clear();
  CHECK(calibration_of(unnamed, std::vector<InstrumentNote>{{"", "C-2", "", "", "", ""}}).certificate.empty());
  const InstrumentCalibration odd = noted("{}", {"S-1", "C-2", "", "soon", "FILL-IN", ""});
  CHECK(odd.remarks ==
        std::vector<std::string>{"calibrated: not a date: soon", "due: the laboratory file is not filled in"});
}

TEST_CASE("days: of each month's end and of leap years, by their distance") {
  const auto days = [](const char* from, const char* to) { return (*day_of(to) - *day_of(from)).count(); };
  CHECK(days("2025-01-31", "2025-02-01") == 1);
  CHECK(days("2025-12-31", "2026-01-01") == 1);
  CHECK(days("2024-01-01", "2025-01-01") == 366);
  CHECK(days("1999-12-31", "2000-03-01") == 61);
  CHECK(days("2025-03-09", "2025-10-19") == 224);
  CHECK(days("2019-08-27", "2029-08-27") == 3653);
  for (const char* none : {"2025-02-30", "0000-00-00", "2025-1-001", "2025-01-3x", "2025-01-:1", "2025-01-/1",
                           "-025-01-01", "2025-01-01t00", "2025-01-01 ", "2025x01-01", "2025-01x01"})
    CHECK_FALSE(day_of(none));
  CHECK(day_of("2025-01-01T"));
  CHECK(day_of("0999-09-09"));
}

TEST_CASE("drift growth: the day at which it begins, and dates of which one is no date") {
  const auto growth = [](const char* calibrated, const char* due, const char* utc) {
    InstrumentCalibration calibration;
    calibration.calibrated_on = calibrated;
    calibration.due = due;
    return drift_growth(calibration, utc);
  };
  CHECK(growth("2025-01-01", "2025-01-11", "2025-01-11T23:59:59Z") == 1.0);
  CHECK(growth("2025-01-01", "2025-01-11", "2025-01-12T00:00:00Z") == Approx(1.1));
  CHECK(growth("2025-01-01", "2025-01-11", "2025-01-31") == Approx(3.0));
  CHECK(growth("2025-01-01", "", "2026-01-01") == 1.0);  // 365 of 365.25 days
  CHECK(growth("2025-01-01", "", "2026-01-02") == Approx(366.0 / 365.25));
  CHECK(growth("", "2025-01-11", "2025-01-11") == 1.0);
  CHECK(growth("", "2025-01-11", "2025-01-12") == Approx(366.25 / 365.25));
  // The wrong way round, or on one day: a year from the due date on.
  CHECK(growth("2025-01-11", "2025-01-01", "2025-01-02") == Approx(366.25 / 365.25));
  CHECK(growth("2025-01-01", "2025-01-01", "2025-01-02") == Approx(366.25 / 365.25));
  CHECK(growth("x", "y", "2025-01-02") == 1.0);
}

TEST_CASE("placeholders are left out of a calibration, with whatever holds one, and the rest stays in its order") {
  CHECK(without_placeholders(R"({"b":1,"a":"FILL-IN","c":["FILL-IN",2],"d":{"e":3}})") == R"({"b":1,"d":{"e":3}})");
  CHECK(without_placeholders("FILL-IN").empty());
  CHECK(without_placeholders(R"(["FILL-IN"])").empty());
  CHECK(is_placeholder("the FILL-IN value"));
  CHECK_FALSE(is_placeholder("fill-in"));
}

TEST_CASE("the scanner's number: the first scanner that answered by one, whatever its role is called besides") {
  db::RunRecord run;
  run.scanner_serial = "THEN";
  run.devices = {{"force sensor", "", "F", "", "", ""},
                 {"tactile scanner", "", "", "", "", ""},
                 {"second scanner", "", "B", "", "", ""},
                 {"tactile scanner", "", "C", "", "", ""}};
  CHECK(scanner_serial_of(run) == "B");
  run.devices.resize(2);
  CHECK(scanner_serial_of(run) == "THEN");
}
