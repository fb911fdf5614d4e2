// The pressure reference as it is read from a run's devices: certificate, converter, limits and their words, by hand.
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <string>

#include "analysis/statistics/numbers/moments.h"
#include "analysis/statistics/uncertainty/instruments.h"
#include "analysis/statistics/uncertainty/reference_uncertainty.h"
#include "analysis/statistics/uncertainty/uncertainty.h"
#include "tests/analysis/support/straight_array.h"

using namespace tactbench;
using namespace tactbench::analysis;

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
  CHECK(found.certificate_u(-5) == Approx(0.1));
  CHECK(found.certificate_u(10) == Approx(0.1));
  CHECK(found.certificate_u(12.5) == Approx(0.125));
  CHECK(found.certificate_u(20) == Approx(0.2));
  CHECK(found.certificate_u(35) == Approx(0.125));
  CHECK(found.certificate_u(40) == Approx(0.1));
  CHECK(found.certificate_u(41) == Approx(0.1));
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

TEST_CASE("conditions of use: each one and each source of uncertainty has its own name") {
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
