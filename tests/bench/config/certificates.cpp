// What a certificate covers: the word, what it asks for, and what follows where it is missing.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "analysis/statistics/uncertainty/reference_uncertainty.h"
#include "bench/common/error.h"
#include "bench/config/config_calibration.h"
#include "bench/rig/device_records.h"
#include "tests/bench/config/bench_text.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::BenchConfig;

namespace {

std::string refused(const BenchConfig& config) {
  try {
    refuse_placeholders(config);
  } catch (const bench::Error& error) {
    CHECK(error.code() == bench::ExitCode::kUsage);
    return error.id() + ": " + error.what();
  }
  return "accepted";
}

const Changes kForceOf = {{"force.kind", "net"}, {"force.host", "h"}, {"force.certificate", "F-1"}};

}  // namespace

TEST_CASE("a real bench that states a certificate says what it covers, or is refused before anything is touched") {
  const Changes certified = {{"reference.certificate", "C-1"}};
  CHECK_THAT(refused(hardware_bench(certified)), Catch::Contains("TB-BENCH-COVERS") && Catch::Contains("[reference]"));
  CHECK(refused(hardware_bench()) == "accepted");  // no certificate, nothing that it could cover
  for (const char* word : {"chain", "transducer"}) {
    Changes said = certified;
    said.push_back({"reference.certificate_covers", word});
    if (std::string(word) == "transducer") said.push_back({"reference.input_limit_v", "0.03"});
    CHECK(refused(hardware_bench(said)) == "accepted");
  }
  CHECK_THAT(refused(hardware_bench(kForceOf)), Catch::Contains("[force]"));
  const std::string thermometer =
      "[{quantity = 'temperature_c', unit = 9, address = 7, type = 'i16', raw_span = [0, 1], span_c = [0, 1], "
      "expanded_uncertainty_c = 0.1}]";
  CHECK_THAT(refused(hardware_bench({{"environment.sensor", thermometer}})),
             Catch::Contains("[[environment.sensor]] temperature_c"));
  // A simulated bench has a default, which is stored with its runs.
  const BenchConfig simulated = simulated_bench(certified);
  CHECK(refused(simulated) == "accepted");
  CHECK(simulated.reference_stated.covers == "chain");
}

TEST_CASE("what a certificate covers and the limit of the input that reads the instrument go together") {
  const auto refusal = [](const Changes& changes) { return refusal_of(bench_text("hardware"), changes); };
  CHECK_THAT(refusal({{"reference.certificate_covers", "transducer"}}).what, Catch::Contains("input_limit_v"));
  CHECK_THAT(refusal({{"reference.certificate_covers", "chain"}, {"reference.input_limit_v", "0.03"}}).remedy,
             Catch::Contains("remove input_limit_v"));
  CHECK_THAT(refusal({{"reference.certificate_covers", "all"}}).what, Catch::Contains("certificate_covers"));
  Changes force = kForceOf;
  force.push_back({"force.certificate_covers", "transducer"});
  CHECK_THAT(refusal(force).what, Catch::Contains("input_limit_n"));
}

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
  CHECK_THAT(chain.limit(ReferencePart::kVoltageInput).part.from, Catch::Contains("contained in the certificate"));
  json.erase("certificate_covers");
  run.devices.front().calibration_json = json.dump();
  CHECK_THAT(analysis::reference_uncertainty(run).limit(ReferencePart::kVoltageInput).part.missing,
             Catch::Contains("what the certificate covers"));
}
