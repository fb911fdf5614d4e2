// Certificates and dates, and which of them take precedence: known answers.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>

#include "analysis/statistics/uncertainty/instruments.h"
#include "analysis/statistics/uncertainty/reference_uncertainty.h"
#include "tests/analysis/support/uncertainty_example.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

db::DeviceRecord reference_with(const std::string& json) {
  return {"pressure reference", "PT-150", "P-22", "", "hardware", json};
}

InstrumentCalibration dated(const std::string& calibrated, const std::string& due) {
  InstrumentCalibration calibration;
  calibration.calibrated_on = calibrated;
  calibration.due = due;
  return calibration;
}

constexpr const char* kStated =
    R"({"certificate":"C-1","calibrated":"2025-01-31","due":"2026-01-31","expanded_uncertainty_psi":0.05})";

}  // namespace

TEST_CASE("dates: only calendar dates as year, month, day are accepted, and days between them are counted") {
  for (const char* date : {"2026-01-31", "2024-02-29", "2000-12-01"}) CHECK(is_date(date));
  for (const char* none :
       {"",           "soon",       "31.01.2025", "2025-02-29", "2025-02-30", "2026-13-01", "2026-00-10",
        "0000-00-00", "2026-04-31", "2026-1-31",  "2025-1-001", "2026/01/31", "2025x01-01", "2025-01x01",
        "202a-01-31", "2025-01-3x", "2025-01-:1", "2025-01-/1", "-025-01-01", "2026-01-310"}) {
    CHECK_FALSE(is_date(none));
    CHECK_FALSE(day_of(none));
  }
  CHECK_FALSE(is_date("2026-01-31T12:00:00Z"));
  CHECK(day_of("2026-03-01T00:00:00Z") == day_of("2026-03-01"));
  for (const char* none : {"2026-03-01 00:00", "2025-01-01t00", "2025-01-01 "}) CHECK_FALSE(day_of(none));
  CHECK((day_of("2025-01-01T") && day_of("0999-09-09")));
  const auto days = [](const char* from, const char* to) { return (*day_of(to) - *day_of(from)).count(); };
  CHECK(days("2025-12-31", "2026-01-01") == 1);
  CHECK(days("2024-01-01", "2025-01-01") == 366);
  CHECK(days("1999-12-31", "2000-03-01") == 61);
  CHECK(days("2019-08-27", "2029-08-27") == 3653);
}

TEST_CASE("instrument calibration: the run's stored values come first, a laboratory file fills the gaps") {
  const std::vector<InstrumentNote> notes = {
      {"OTHER", "C-9", "somebody", "2020-01-01", "2021-01-01", "of another instrument"},
      {"P-22", "C-1", "PTB", "2025-01-31", "", "in its case"}};
  const InstrumentCalibration both = calibration_of(reference_with(kStated), notes);
  CHECK(both.certificate == "C-1");
  CHECK(both.calibrated_by == "PTB");
  CHECK(both.calibrated_on == "2025-01-31");
  CHECK(both.due == "2026-01-31");
  CHECK(both.note == "in its case");
  CHECK(both.remarks.empty());

  const InstrumentCalibration filled = calibration_of(reference_with(R"({"certificate":"","due":""})"), notes);
  CHECK(filled.certificate == "C-1");
  CHECK(filled.calibrated_on == "2025-01-31");
  CHECK(filled.due.empty());
  CHECK(filled.remarks.empty());
  CHECK_FALSE(calibration_of(reference_with("{}")).traceable());
}

TEST_CASE("instrument calibration: contradictions are reported, the run's certificate and the earlier due date count") {
  const auto resolved = [](const std::string& certificate, const std::string& calibrated, const std::string& due) {
    return calibration_of(reference_with(kStated),
                          std::vector<InstrumentNote>{{"P-22", certificate, "PTB", calibrated, due, ""}});
  };
  const InstrumentCalibration other = resolved("PTB-30123-26", "2019-05-01", "2020-01-31");
  CHECK(other.certificate == "C-1");
  CHECK(other.calibrated_on == "2025-01-31");
  CHECK(other.calibrated_by.empty());  // who made the other certificate did not make this one
  CHECK(other.due == "2020-01-31");
  REQUIRE(other.remarks.size() == 3);
  const InstrumentCalibration later = resolved("C-1", "", "2030-01-31");
  CHECK(later.due == "2026-01-31");
  CHECK(later.remarks.size() == 1);
  CHECK(resolved("C-1", "2025-01-31", "2026-01-31").remarks.empty());
}

TEST_CASE("instrument calibration: invalid dates and FILL-IN count as not stated, and are reported") {
  const InstrumentCalibration odd =
      calibration_of(reference_with(R"({"certificate":"FILL-IN","calibrated":"last spring","due":"31.01.2025"})"),
                     std::vector<InstrumentNote>{{"P-22", "FILL-IN", "", "", "", ""}});
  CHECK(odd.certificate.empty());
  CHECK(odd.calibrated_on.empty());
  CHECK(odd.due.empty());
  CHECK(odd.remarks.size() == 4);
  CHECK(due_state(odd, "2026-05-06T07:08:09Z") == DueState::kNotStated);
  db::DeviceRecord unnamed = reference_with("{}");
  unnamed.serial = "FILL-IN";
  CHECK(calibration_of(unnamed).serial.empty());
  for (const char* broken : {"", "[]", "{", "7", R"({"certificate":7,"due":[]})"})
    CHECK_FALSE(calibration_of(reference_with(broken)).traceable());
  CHECK(without_placeholders(R"({"a":1,"certificate":"FILL-IN"})") == R"({"a":1})");
  CHECK(without_placeholders(kStated) == kStated);
}

TEST_CASE("instrument calibration: the last day of validity is in date, the next one is overdue") {
  const InstrumentCalibration calibration = dated("", "2026-01-31");
  CHECK(due_state(calibration, "2026-01-31T23:59:59Z") == DueState::kInDate);
  CHECK(due_state(calibration, "2026-02-01") == DueState::kOverdue);
  CHECK(due_state(calibration, "") == DueState::kInDate);
  CHECK(due_state(dated("2025-01-31", ""), "2030-01-01") == DueState::kNotStated);
}

TEST_CASE("drift limit: grows with the time since the calibration, and is never less than stated") {
  // 2024-01-01 to 2025-12-31: 730 days. Twice that, and a day after the due date.
  CHECK(drift_growth(dated("2024-01-01", "2025-12-31"), "2025-12-31") == 1.0);
  CHECK(drift_growth(dated("2024-01-01", "2025-12-31"), "2024-06-01") == 1.0);
  CHECK(drift_growth(dated("2024-01-01", "2025-12-31"), "2026-01-01") == Approx(731.0 / 730.0));
  CHECK(drift_growth(dated("2024-01-01", "2025-12-31"), "2027-12-31") == Approx(1460.0 / 730.0));
  // One of the dates alone: a year.
  CHECK(drift_growth(dated("", "2026-01-01"), "2027-01-01") == Approx((365.25 + 365.0) / 365.25));
  CHECK(drift_growth(dated("2024-01-01", ""), "2024-12-01") == 1.0);
  CHECK(drift_growth(dated("2024-01-01", ""), "2026-01-01") == Approx(731.0 / 365.25));
  CHECK(drift_growth(dated("", ""), "2026-01-01") == 1.0);
  CHECK(drift_growth(dated("2026-01-01", "2025-01-01"), "2026-06-01") > 1.0);  // dates the wrong way round
  CHECK(drift_growth(dated("2024-01-01", "2025-12-31"), "") == 1.0);
}

TEST_CASE("drift limit: of the reference grows when overdue, also by the due date of a laboratory file") {
  using namespace uncertainty_example;
  const auto reference = [](const std::string& due, const std::string& more = {}) {
    return reference_uncertainty(record_with_reference(kWithCertificate + more, due));  // run of 2026-05-06
  };
  for (const char* due : {"2027-01-31", "", "soon"}) {
    CHECK_FALSE(reference(due).overdue);
    CHECK(reference(due).drift_psi == 0.05);
  }
  const ReferenceUncertainty overdue = reference("2025-05-06", R"(,"calibrated":"2024-05-06")");
  CHECK(overdue.overdue);
  CHECK(overdue.drift_missing.empty());
  CHECK(overdue.drift_psi == Approx(0.05 * 730.0 / 365.0));
  CHECK(overdue.drift_stated_psi == 0.05);
  // A laboratory file brings the due date that the run does not state.
  const ReferenceUncertainty noted = reference_uncertainty(
      record_with_reference(kWithCertificate, ""), std::vector<InstrumentNote>{{"2", "", "", "", "2020-01-31", ""}});
  CHECK(noted.overdue);
  CHECK(noted.drift_psi > 0.3);
}

TEST_CASE("scanner serial: is that of the scanner that answered, else the run's, else the sensor's present one") {
  db::RunRecord run;
  const db::SensorRecord sensor{"S-1", "", "", "", "NOW", "", ""};
  CHECK(scanner_serial_of(run).empty());
  CHECK(scanner_serial_of(run, sensor) == "NOW");
  run.scanner_serial = "THEN";
  CHECK(scanner_serial_of(run, sensor) == "THEN");
  run.devices = {{"tactile scanner", "T", "ANSWERED", "", "simulated", "{}"}};
  CHECK(scanner_serial_of(run, sensor) == "ANSWERED");
}

// Budgets of the force sensor and the thermometer, row by row, and what a certificate covers: by hand.

namespace {

db::RunRecord run_with(const std::string& role, const std::string& json,
                       const std::string& utc = "2026-05-06T07:08:09Z") {
  db::RunRecord run;
  run.started_utc = utc;
  run.devices = {{"pressure reference", "PT", "1", "", "hardware", R"({"expanded_uncertainty_n":99})"},
                 {role, "F-1", "77", "", "hardware", json}};
  return run;
}

const InstrumentRow& row_named(const InstrumentUncertainty& budget, const std::string& name) {
  for (const InstrumentRow& row : budget.rows)
    if (row.name == name) return row;
  throw std::runtime_error("no row " + name);
}

constexpr const char* kForceSensorText =
    R"({"expanded_uncertainty_n":0.3,"drift_n":0.12,"input_limit_n":0.06,"certificate_covers":"transducer",)"
    R"("calibrated":"2026-01-31","due":"2027-01-31"})";

}  // namespace

TEST_CASE("force sensor: certificate, drift and input are divided as normal or rectangular and combined") {
  const InstrumentUncertainty budget =
      instrument_uncertainty(run_with("force sensor", kForceSensorText), "force sensor");
  CHECK(budget.unit == "N");
  CHECK(budget.covers == CertificateCovers::kTransducer);
  REQUIRE(budget.rows.size() == 3);
  const InstrumentRow &certificate = budget.rows[0], &drift = budget.rows[1], &input = budget.rows[2];
  CHECK((certificate.name == "certificate" && certificate.distribution == "normal"));
  CHECK((certificate.width == 0.3 && certificate.divisor == 2.0));
  CHECK(certificate.u() == Approx(0.15));
  CHECK((drift.name == "drift" && drift.distribution == "rectangular"));
  CHECK(drift.u() == Approx(0.12 / std::sqrt(3.0)));
  CHECK(input.distribution == "rectangular");
  CHECK(input.u() == Approx(0.06 / std::sqrt(3.0)));
  for (const InstrumentRow& row : budget.rows) CHECK(row.assessed());
  CHECK(budget.complete());
  // 0.0225 + 0.0048 + 0.0012
  CHECK(budget.u() == Approx(std::sqrt(0.0285)));
  CHECK(budget.expanded() == Approx(2.0 * std::sqrt(0.0285)));
}

TEST_CASE("force sensor: drift grows beyond the due date, and a laboratory's earlier date counts") {
  // 365 days from calibration to due date; 730 days after the calibration it is twice the limit.
  const db::RunRecord late = run_with("force sensor", kForceSensorText, "2028-01-31T00:00:00Z");
  CHECK(row_named(instrument_uncertainty(late, "force"), "drift").width == Approx(0.24));
  const std::vector<InstrumentNote> notes{{"77", "", "", "", "2026-03-02", ""}};  // 30 days, of 95 that have passed
  CHECK(row_named(instrument_uncertainty(run_with("force sensor", kForceSensorText), "force", notes), "drift").width ==
        Approx(0.12 * 95.0 / 30.0));
}

TEST_CASE("instruments: values that are not stated are reported as missing, and enter no sum") {
  const InstrumentUncertainty bare = instrument_uncertainty(run_with("force sensor", "{}"), "force sensor");
  REQUIRE(bare.rows.size() == 3);
  for (const InstrumentRow& row : bare.rows) CHECK_FALSE(row.part.missing.empty());
  CHECK_FALSE(bare.complete());
  CHECK(bare.u() == 0.0);
  const auto of_force = [](const std::string& json) {
    return instrument_uncertainty(run_with("force sensor", json), "force sensor");
  };
  const InstrumentUncertainty chain =
      of_force(R"({"expanded_uncertainty_n":0.3,"drift_n":0.12,"certificate_covers":"chain"})");
  CHECK_FALSE(chain.rows[2].part.from.empty());
  CHECK_FALSE(chain.rows[2].assessed());
  CHECK(chain.complete());
  CHECK(chain.u() == Approx(std::sqrt(0.0225 + 0.0048)));
  CHECK_FALSE(
      of_force(R"({"expanded_uncertainty_n":0.3,"certificate_covers":"transducer"})").rows[2].part.missing.empty());
  const InstrumentUncertainty unsaid = of_force(R"({"expanded_uncertainty_n":0.3})");
  CHECK_FALSE(unsaid.rows[2].part.missing.empty());
  CHECK(unsaid.u() == Approx(0.15));
  // Numbers that are none, and limits that are no limits.
  for (const char* odd : {R"({"expanded_uncertainty_n":"0.3"})", R"({"expanded_uncertainty_n":-0.3})",
                          R"({"expanded_uncertainty_n":0})", "[]", "", "{"})
    CHECK(of_force(odd).u() == 0.0);
}

TEST_CASE("thermometer: its budget is in kelvin, and only the requested device is used") {
  const db::RunRecord run = run_with("temperature_c ambient",
                                     R"({"expanded_uncertainty_c":0.2,"drift_c":0.06,"certificate_covers":"chain"})");
  const InstrumentUncertainty budget = instrument_uncertainty(run, "temperature_c");
  CHECK(budget.unit == "K");
  CHECK(budget.covers == CertificateCovers::kChain);
  CHECK(budget.u() == Approx(std::sqrt(0.01 + 0.0012)));
  CHECK(instrument_uncertainty(run, "force sensor").unit.empty());
  CHECK(instrument_uncertainty(run, "force sensor").rows.empty());
  CHECK_FALSE(instrument_uncertainty(run, "force sensor").complete());
  CHECK_FALSE(instrument_uncertainty(run_with("temperature_c", "{}"), "temperature_c").rows[1].part.missing.empty());
  CHECK(instrument_uncertainty({}, "temperature_c").unit.empty());
}

TEST_CASE("certificate coverage: is read from its text, and decides whether a missing part is allowed") {
  const auto covers = [](const std::string& json) { return covers_of({"force", "", "", "", "", json}); };
  CHECK(covers(R"({"certificate_covers":"chain"})") == CertificateCovers::kChain);
  CHECK(covers(R"({"certificate_covers":"transducer"})") == CertificateCovers::kTransducer);
  for (const char* other : {R"({"certificate_covers":"both"})", R"({"certificate_covers":7})", "{}", "[]", ""})
    CHECK(covers(other) == CertificateCovers::kNotStated);
  for (const CertificateCovers each :
       {CertificateCovers::kNotStated, CertificateCovers::kChain, CertificateCovers::kTransducer}) {
    const ChainPart stated = chain_part(each, 0.1, true, "k"), unknown = chain_part(each, 0.0, false, "k");
    CHECK((stated.missing.empty() && stated.from.empty()));
    CHECK_FALSE(unknown.missing.empty());
    const ChainPart open = chain_part(each, 0.0, true, "k");
    CHECK(open.missing.empty() == (each == CertificateCovers::kChain));
    CHECK(open.from.empty() == (each != CertificateCovers::kChain));
  }
}
