// Instruments as they are read from a run's devices, by hand: the pressure reference's certificate, converter and
// limits; dates; force sensor and thermometer.

#include <catch2/catch.hpp>

#include <array>
#include <cmath>
#include <set>
#include <stdexcept>
#include <string>

#include "analysis/statistics/numbers/moments.h"
#include "analysis/statistics/uncertainty/instruments.h"
#include "analysis/statistics/uncertainty/reference_uncertainty.h"
#include "analysis/statistics/uncertainty/uncertainty.h"
#include "tests/analysis/support/straight_array.h"
#include "tests/analysis/support/uncertainty_example.h"

using namespace tactbench::analysis;
using namespace tactbench;

namespace {

// Members of the reference's calibration beside its span: 0 to 10 V are -20 to 180 psi, 20 psi a volt.
db::RunRecord read_by(const std::string& members, const std::string& module = R"({"raw_low":0,"raw_high":40000,)"
                                                                              R"("low":0,"high":10})") {
  db::RunRecord run;
  run.started_utc = "2026-05-06T07:08:09Z";
  run.devices = {{"analog module", "M", "1", "", "simulated", R"({"input_volts":)" + module + "}"},
                 {"pressure reference", "P", "2", "", "simulated",
                  R"({"volts_low":0,"volts_high":10,"psi_low":-20,"psi_high":180)" +
                      (members.empty() ? "" : "," + members) + "}"}};
  return run;
}

ReferenceUncertainty reference_of(const std::string& members) { return reference_uncertainty(read_by(members)); }

std::string correction(const std::string& readings, const std::string& expanded, const std::string& more = "") {
  return R"("correction":{"reading_psi":)" + readings + R"(,"expanded_uncertainty_psi":)" + expanded + more + "}";
}

}  // namespace

TEST_CASE("reference: U of the certificate is linear between its points, constant beyond, with its factor") {
  const ReferenceUncertainty found = reference_of(correction("[10,20,40]", "[0.3,0.6,0.3]", R"(,"coverage_factor":3)"));
  CHECK(found.coverage_factor == 3.0);
  for (const auto& [psi, u_psi] :
       {std::pair(-5.0, 0.1), {10.0, 0.1}, {12.5, 0.125}, {20.0, 0.2}, {35.0, 0.125}, {40.0, 0.1}, {41.0, 0.1}})
    CHECK(found.certificate_u(psi) == Approx(u_psi));
  CHECK(found.largest_certificate_u() == Approx(0.2));
  CHECK(found.rows(0.1, 0.0).front().width_psi == Approx(0.3));
  CHECK(found.rows(0.1, 0.0).front().divisor == 3.0);
  const ReferenceUncertainty one = reference_of(R"("expanded_uncertainty_psi":0.1)");
  CHECK((one.certificate_u(0) == 0.05 && one.certificate_u(60) == 0.05));
  CHECK(ReferenceUncertainty().certificate_u(10) == 0.0);
  CHECK(ReferenceUncertainty().largest_certificate_u() == 0.0);
}

TEST_CASE("reference: a certificate is valid between its ends, and a run beyond them is not traceable there") {
  const std::string stated = R"("expanded_uncertainty_psi":0.1)", range = R"("certificate_range_psi":[0,50])";
  const auto corrected = [](const std::string& readings, const std::string& corrections) {
    return correction(readings, "[0.1,0.1]", R"(,"correction_psi":)" + corrections);
  };
  struct Row {
    std::string members;
    double low_psi, high_psi;  // of the run
    bool beyond;
    double held_psi, not_held_psi;  // not held: NaN, none
  };
  const double none = std::nan("");
  const std::vector<Row> rows = {
      {stated, 0.0, 60.0, false, 1e6, none},
      {stated + "," + range, 0.0, 60.0, true, 50.4, 51.0},  // 1 % beyond the end counts as within
      {stated + "," + range, 0.0, 50.4, false, 0.0, -1.0},
      {corrected("[0,40]", "[0,1.2]"), 0.0, 60.0, true, 41.2, 44.0},
      {corrected("[0,40]", "[0,-2]"), 0.0, 40.0, true, 38.0, 40.0},
      {corrected("[10,60]", "[0,0]"), 0.0, 60.0, true, 10.0, 8.0},
      {corrected("[10,60]", "[0,0]"), 10.0, 60.0, false, 60.0, 61.0},
      {corrected("[0.01,59.95]", "[-0.01,0.05]"), 0.0, 60.1, false, 60.0, 61.0},  // 60 psi, as laboratories print it
      {corrected("[0.03,59.91]", "[0.0,0.0]"), 0.0, 60.08, false, 60.0, 61.0},    // by noise
      {corrected("[10,60.5]", "[0,0]"), 8.0, 60.0, true, 20.0, 8.0},
      {corrected("[0,60]", "[0,0]") + "," + range, 0.0, 60.0, true, 50.0, 52.0},
      {corrected("[0,40]", "[0,0]"), 0.0, 0.0, false, 40.0, 41.0},  // a run that presses
  };
  for (const Row& row : rows) {
    CAPTURE(row.members, row.low_psi, row.high_psi);
    db::RunRecord run = read_by(row.members);
    run.lowest_psi = row.low_psi;
    run.highest_psi = row.high_psi;
    const ReferenceUncertainty found = reference_uncertainty(run);
    CHECK(found.beyond.has_value() == row.beyond);
    CHECK(found.untraced() == found.beyond);
    CHECK(found.holds_at(row.held_psi));
    if (!std::isnan(row.not_held_psi)) CHECK_FALSE(found.holds_at(row.not_held_psi));
  }
}

TEST_CASE("reference: a correction with unsorted, unequal or non-positive points is ignored") {
  CHECK(reference_of(correction("[10]", "[0.3]")).certificate_missing.empty());
  for (const std::string& odd :
       {correction("[10,10]", "[0.3,0.3]"), correction("[20,10]", "[0.3,0.3]"), correction("[10,20]", "[0.3]"),
        correction("[10,20]", "[0.3,0]"), correction("[10,20]", "[0.3,-1]"), correction("[10,\"x\"]", "[0.3,0.3]"),
        correction("7", "[0.3]"), correction("[]", "[]")}) {
    INFO(odd);
    const ReferenceUncertainty found = reference_of(odd);
    CHECK((found.reading_psi.empty() && found.expanded_psi.empty()));
    CHECK_THAT(found.certificate_missing, Catch::Contains("expanded_uncertainty_psi"));
  }
  CHECK(reference_of(correction("[10]", "[0.3]", R"(,"coverage_factor":-1)")).coverage_factor == 2.0);
}

TEST_CASE("reference: a member that is not a number counts as missing") {
  const ReferenceUncertainty found = reference_of(
      R"("drift_psi":"0.05","resolution_psi":"0.25","hysteresis_psi":"0.1","zero_psi":[0.1],"temperature_psi":null)");
  CHECK((found.drift_stated_psi == 0.0 && found.resolution_psi == Approx(20.0 * 10.0 / 40000.0)));
  for (const ReferenceLimit& limit : found.limits) CHECK(limit.half_width_psi == 0.0);
  CHECK(reference_of(R"("expanded_uncertainty_psi":"0.1")").reading_psi.empty());
  CHECK_FALSE(reference_of(R"("expanded_uncertainty_psi":"0.1")").certificate_missing.empty());
  const ReferenceUncertainty factor = reference_of(correction("[10]", "[0.3]", R"(,"coverage_factor":"3")"));
  CHECK((factor.coverage_factor == 2.0 && factor.expanded_psi == std::vector<double>{0.3}));
  db::RunRecord run;
  for (const char* calibration : {R"({"volts_per_count":"0.25"})", "{}", "[0.25]", ""}) {
    run.devices = {{"tactile scanner", "T", "3", "", "simulated", calibration}};
    CHECK(scanner_step_v(run) == 0.0);
  }
}

TEST_CASE("reference: one step of its converter is the step's volts times the span's psi per volt") {
  const auto step = [](const std::string& module, const std::string& members = "") {
    return reference_uncertainty(read_by(members, module)).resolution_psi;
  };
  const std::string whole = R"({"raw_low":0,"raw_high":40000,"low":0,"high":10})";
  // An end that is not stated is 0.
  for (const std::string& module :
       {whole, std::string(R"({"raw_low":-10000,"raw_high":30000,"low":-2,"high":8})"),
        std::string(R"({"raw_high":40000,"low":0,"high":10})"), std::string(R"({"raw_low":-40000,"low":0,"high":10})"),
        std::string(R"({"raw_low":0,"raw_high":40000,"high":10})"),
        std::string(R"({"raw_low":0,"raw_high":40000,"low":-10})")})
    CHECK(step(module) == Approx(20.0 * 10.0 / 40000.0));
  CHECK(step(R"({"raw_low":100,"raw_high":100,"low":0,"high":10})") == 0.0);
  CHECK(step(R"({"raw_low":0,"raw_high":100,"low":10,"high":0})") == 0.0);
  CHECK(step(whole, R"("resolution_psi":0.25)") == 0.25);
  CHECK(step(whole, R"("volts_high":0)") == 0.0);
  // Of two modules the later one reads.
  db::RunRecord two = read_by("");
  two.devices.push_back({"input module", "N", "3", "", "simulated",
                         R"({"input_volts":{"raw_low":0,"raw_high":1000,"low":0,"high":10}})"});
  CHECK(reference_uncertainty(two).resolution_psi == Approx(0.2));
  two.devices[0].calibration_json = two.devices[2].calibration_json = "{}";
  CHECK_THAT(reference_uncertainty(two).resolution_missing, Catch::Contains("resolution_psi"));
}

TEST_CASE("reference: limits of the chain convert to psi, and those that are missing are reported") {
  const ReferenceUncertainty all =
      reference_of(R"("expanded_uncertainty_psi":0.1,"input_limit_v":0.005,"hysteresis_psi":0.2,)"
                   R"("zero_psi":0.3,"temperature_psi":0.4)");
  CHECK(all.limit(ReferencePart::kVoltageInput).half_width_psi == Approx(0.1));  // 20 psi a volt
  CHECK(all.limit(ReferencePart::kHysteresis).half_width_psi == 0.2);
  CHECK(all.limit(ReferencePart::kZero).half_width_psi == 0.3);
  CHECK(all.limit(ReferencePart::kTemperature).half_width_psi == 0.4);
  for (const ReferenceLimit& limit : all.limits) CHECK((limit.part.missing.empty() && limit.part.from.empty()));
  // Rows: certificate, no drift, the digit of 5 mpsi, then the four limits in their order.
  const std::vector<ReferenceRow> rows = all.rows(0.05, 0.0);
  REQUIRE(rows.size() == 6);
  CHECK((rows[0].source == 0 && rows[0].u_psi == 0.05));
  CHECK((rows[1].source == 2 && rows[1].width_psi == Approx(0.0025)));
  for (std::size_t part = 0; part < 4; ++part) {
    CHECK(rows[2 + part].source == 3 + part);
    CHECK(rows[2 + part].u_psi == Approx(0.1 * static_cast<double>(part + 1) / std::sqrt(3.0)));
    CHECK(rows[2 + part].divisor == Approx(std::sqrt(3.0)));
  }
  const ReferenceUncertainty transducer =
      reference_of(R"("expanded_uncertainty_psi":0.1,"certificate_covers":"transducer","zero_psi":-1)");
  CHECK(transducer.covers == CertificateCovers::kTransducer);
  CHECK_FALSE(transducer.limit(ReferencePart::kVoltageInput).part.missing.empty());
  CHECK_FALSE(transducer.limit(ReferencePart::kZero).part.missing.empty());
  const ReferenceUncertainty bare = reference_of(R"("hysteresis_psi":0.2)");
  CHECK(bare.limit(ReferencePart::kHysteresis).part.missing.empty());
  CHECK(bare.limit(ReferencePart::kTemperature).part.missing == bare.certificate_missing);
}

TEST_CASE("reference: the device is found by its role, and the scanner's volts per count by the scanner's") {
  db::RunRecord run = read_by(R"("expanded_uncertainty_psi":0.1)");
  run.devices[1].role = "force reference";
  CHECK_FALSE(reference_uncertainty(run).certificate_missing.empty());
  run.devices[1].role = "pressure regulator";
  CHECK_FALSE(reference_uncertainty(run).certificate_missing.empty());
  run.devices[1].role = "chamber pressure, reference";
  CHECK(reference_uncertainty(run).certificate_missing.empty());
  // The first that says anything counts.
  run.devices.insert(run.devices.begin(), {"pressure reference", "", "", "", "", "broken"});
  run.devices.push_back({"pressure reference", "", "", "", "", R"({"expanded_uncertainty_psi":9})"});
  CHECK(reference_uncertainty(run).certificate_u(0) == 0.05);
  run.devices = {{"tactile scanner 2", "", "", "", "", R"({"volts_per_count":0.5})"},
                 {"tactile scanner", "", "", "", "", "x"},
                 {"tactile scanner", "", "", "", "", R"({"volts_per_count":0.25})"}};
  CHECK(scanner_step_v(run) == 0.25);
  run.devices[2].calibration_json = R"({"volts_per_count":-1})";
  CHECK(scanner_step_v(run) == 0.0);
  CHECK(scanner_step_v({}) == 0.0);
}

// U of a reading between levels, and what temperature adds, as functions of their own: by hand.

using namespace straight_array;

TEST_CASE("U of a reading: is linear between levels of its branch, constant beyond, and NaN without a level") {
  ConditionUncertainty condition;
  condition.pressure_psi = {20, 40, 60, 30, 50};
  condition.up = {true, true, true, false, false};
  condition.expanded_psi = {1, 10, 3, 30, 4, 40, 5, 50, 9, 90};  // two taxels
  condition.error_psi = {0.1, 1, 0.2, 2, 0.4, 4, -0.5, -5, -0.7, -7};
  const auto at = [&](double psi, bool up, std::size_t taxel = 0) {
    return reading_uncertainty(condition, taxel, psi, up);
  };
  CHECK((at(10, true).expanded_psi == 1.0 && at(10, true).error_psi == 0.1));
  CHECK((at(20, true).expanded_psi == 1.0 && at(40, true).expanded_psi == 3.0));
  CHECK(at(25, true).expanded_psi == Approx(1.5));
  CHECK(at(25, true).error_psi == Approx(0.125));
  CHECK(at(55, true, 1).expanded_psi == Approx(37.5));
  CHECK(at(55, true, 1).error_psi == Approx(3.5));
  CHECK(at(70, true).expanded_psi == 4.0);
  CHECK(at(35, false).expanded_psi == Approx(6.0));
  CHECK((at(20, false, 1).expanded_psi == 50.0 && at(55, false, 1).error_psi == -7.0));
  condition.pressure_psi.resize(3);
  condition.up.resize(3);
  condition.expanded_psi.resize(6);
  condition.error_psi.resize(6);
  CHECK(std::isnan(at(30, false).expanded_psi));
  CHECK(std::isnan(at(30, false).error_psi));
  CHECK(std::isnan(reading_uncertainty({}, 0, 30, true).expanded_psi));
}

TEST_CASE("conditions of use: names of conditions and of sources of uncertainty are distinct") {
  std::set<std::string> conditions, sources;
  for (std::size_t condition = 0; condition < kUseConditions; ++condition)
    conditions.insert(name_of(static_cast<UseCondition>(condition)));
  for (std::size_t source = 0; source < kUncertaintySources; ++source)
    sources.insert(text_of(static_cast<UncertaintySource>(source)).name);
  CHECK((conditions.size() == kUseConditions && !conditions.contains("")));
  CHECK((sources.size() == kUncertaintySources && !sources.contains("")));
}

namespace {

// Up and down over the levels at a temperature: 0.1 V a psi and `share` more of it, `zero` higher; of the repeats one
// has `off` less, the other more.
Dataset loop_at(double celsius, double share, double zero, const std::vector<double>& rising, double off = 0.0) {
  Dataset data = dataset_of({});
  data.temperatures_c = {celsius};
  SequenceData sequence{"loop", {}};
  for (const double side : {-off, off}) {
    std::vector<double> psi = rising;
    for (std::size_t i = rising.size() - 1; i-- > 0;) psi.push_back(rising[i]);
    Repeat repeat;
    for (const double level : psi) {
      repeat.steps.push_back({level, level});
      const double volts = 0.5 + zero + 0.1 * level * (1.0 + share + side);
      repeat.volts.insert(repeat.volts.end(), {volts, volts, 9.0});
    }
    sequence.repeats.push_back(repeat);
  }
  data.sequences = {sequence};
  return data;
}
const std::vector<double> kFive{0, 15, 30, 45, 60};

TemperatureEffect of_runs(const Dataset& calibration, const std::vector<Dataset>& others) {
  return temperature_effect_of(calibration, others, straight_fit(), 0.1);
}

}  // namespace

TEST_CASE("temperature effect: needs five common levels within 1e-6, and means two kelvin apart") {
  const auto assessed = [](double celsius, const std::vector<double>& rising) {
    return of_runs(loop_at(20, 0, 0, kFive, 0.01), {loop_at(celsius, 0.02, 0, rising, 0.01)}).assessed();
  };
  CHECK(assessed(22, kFive));
  CHECK_FALSE(assessed(21.99, kFive));
  CHECK(assessed(18, kFive));
  CHECK_FALSE(assessed(18.01, kFive));
  CHECK_FALSE(assessed(25, {0, 20, 40, 60}));
  CHECK(assessed(25, {0, 15 + 5e-7, 30, 45, 60}));
  CHECK_FALSE(assessed(25, {0, 15 + 2e-6, 30, 45, 60}));
  CHECK_FALSE(of_runs(loop_at(20, 0, 0, {0, 20, 40, 60}), {loop_at(25, 0, 0, kFive)}).not_assessed.empty());
  const std::vector<double> cold{19.0, 21.0}, warm{22.0}, close{21.9};
  CHECK(at_another_temperature(cold, warm));
  CHECK(at_another_temperature(warm, cold));
  CHECK_FALSE(at_another_temperature(cold, close));
  CHECK_FALSE(at_another_temperature(cold, {}));
}

// Certificates and dates, and which of them take precedence: known answers.

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
