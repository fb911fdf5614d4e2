// What a certificate covers: the word, what it asks for, and what follows where it is missing.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "analysis/statistics/uncertainty/reference_uncertainty.h"
#include "bench/rig/device_records.h"
#include "tests/bench/config/bench_text.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::BenchConfig;

TEST_CASE("the reference's chain becomes rows, and a run of before the word is read and says what it lacks") {
  const BenchConfig config = hardware_bench({{"reference.certificate_covers", "transducer"},
                                             {"reference.expanded_uncertainty_psi", "0.05"},
                                             {"reference.input_limit_v", "0.03"},
                                             {"reference.hysteresis_psi", "0.1"}});
  db::RunRecord run;
  run.started_utc = "2026-05-06T07:08:09Z";
  run.devices = {reference_record({"pressure reference", "m", "s", "", config.origin}, config)};
  const analysis::ReferenceUncertainty known = analysis::reference_uncertainty(run);
  using analysis::ReferencePart;
  CHECK(known.covers == analysis::CertificateCovers::kTransducer);
  CHECK(known.limit(ReferencePart::kVoltageInput).half_width_psi == Approx(0.3));  // 0.3 % of 100 psi, the audit's
  CHECK(known.limit(ReferencePart::kHysteresis).half_width_psi == 0.1);
  CHECK_THAT(known.limit(ReferencePart::kZero).part.missing, Catch::Contains("[reference] zero_psi"));
  // 0.3 psi / sqrt(3): the audit's u = 0.17 psi.
  CHECK(known.combined_u(30.0) == Approx(std::sqrt(0.3 * 0.3 / 3.0 + 0.01 / 3.0 + 0.025 * 0.025)));

  auto json = nlohmann::json::parse(run.devices.front().calibration_json);
  json["certificate_covers"] = "chain";
  json.erase("input_limit_v");
  run.devices.front().calibration_json = json.dump();
  const analysis::ReferenceUncertainty chain = analysis::reference_uncertainty(run);
  CHECK(chain.limit(ReferencePart::kVoltageInput).part.missing.empty());
  json.erase("certificate_covers");
  run.devices.front().calibration_json = json.dump();
  CHECK_FALSE(analysis::reference_uncertainty(run).limit(ReferencePart::kVoltageInput).part.missing.empty());
}
