// What a bench file states of calibrations: dates, limits and what the simulated instruments' errors are drawn within;
// files of sensor types and limits, number by number.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "analysis/statistics/uncertainty/reference_uncertainty.h"
#include "bench/config/config_calibration.h"
#include "bench/rig/device_records.h"
#include "tests/bench/config/bench_text.h"
#include "tests/support/refusal.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::BenchConfig;

namespace {

using Words = std::vector<std::string>;

std::string covers_refusal(const BenchConfig& config) {
  const auto error = refusal_by([&] { refuse_placeholders(config); });
  if (!error) return "accepted";
  CHECK((error->code() == bench::ExitCode::kUsage && error->where() == "b.toml"));
  return error->id();
}

const std::string kThermometer = "quantity = 'temperature_c', unit = 9, address = 7";

}  // namespace

TEST_CASE("stated: dates in their order, and what a certificate covers with what it asks for") {
  const std::string text = bench_text("hardware");
  const auto accepted = [&](const Changes& changes) { return bench_accepts(text, changes); };
  CHECK_FALSE(accepted({{"reference.calibrated", "2026-01-31"}, {"reference.due", "2026-01-30"}}));
  CHECK(accepted({{"reference.calibrated", "2026-01-31"}, {"reference.due", "2026-02-01"}}));
  CHECK(accepted({{"reference.calibrated", "2026-01-31"}, {"reference.due", "FILL-IN"}}));
  CHECK(accepted({{"reference.calibrated", "2026-01-31"}}));
  CHECK(accepted({{"reference.due", "2026-01-30"}}));
  // A supply's sensor states no calibration.
  CHECK(refusal_of(bench_text("simulated"),
                   {{"environment.sensor", "[{quantity = 'supply_bar', unit = 9, address = 7, drift_c = 1}]"}})
            .id == "TB-FILE-KEY");
  CHECK_FALSE(accepted({{"reference.certificate_covers", "chain"}, {"reference.input_limit_v", "0.03"}}));
  CHECK_FALSE(accepted({{"reference.certificate_covers", "transducer"}}));
  CHECK(accepted({{"reference.input_limit_v", "0.03"}}));
  CHECK(accepted({{"reference.certificate_covers", "chain"}}));
  CHECK(hardware_bench({{"reference.certificate_covers", "chain"}}).reference_stated.covers == "chain");
  CHECK(hardware_bench().reference_stated.covers.empty());
  CHECK(simulated_bench().reference_stated.covers == "chain");
  CHECK(simulated_bench({{"reference.certificate_covers", "transducer"}, {"reference.input_limit_v", "0.03"}})
            .reference_stated.covers == "transducer");
  const Changes gauge{{"reference.gauge.unit", "2"}, {"reference.gauge.address", "7"}};
  Changes covered = gauge;
  covered.push_back({"reference.certificate_covers", "transducer"});
  CHECK_FALSE(accepted(covered));
  covered.push_back({"reference.input_limit_v", "0.03"});
  CHECK_FALSE(accepted(covered));
  CHECK(hardware_bench(gauge).reference_stated.covers == "chain");
}

TEST_CASE("stated: a real bench's tables that do not say what their certificate covers, all of them") {
  const std::string thermometer = "[{" + kThermometer + ", certificate = 'T-1'}]";
  CHECK(covers_refusal(hardware_bench({{"reference.expanded_uncertainty_psi", "0.05"},
                                       {"force.kind", "net"},
                                       {"force.expanded_uncertainty_n", "0.1"},
                                       {"environment.sensor", thermometer}})) == "TB-BENCH-COVERS");
  const Changes correction{{"reference.correction.reading_psi", "[0]"},
                           {"reference.correction.correction_psi", "[0]"},
                           {"reference.correction.expanded_uncertainty_psi", "[0]"}};
  CHECK(covers_refusal(hardware_bench(correction)) == "TB-BENCH-COVERS");
  CHECK(covers_refusal(simulated_bench(correction)) == "accepted");
  CHECK(covers_refusal(hardware_bench({{"force.kind", "net"}})) == "accepted");
  CHECK(covers_refusal(hardware_bench({{"environment.sensor", "[{" + kThermometer + "}]"}})) == "accepted");
  Changes gauge = correction;
  gauge.push_back({"reference.gauge.unit", "2"});
  gauge.push_back({"reference.gauge.address", "7"});
  CHECK(covers_refusal(hardware_bench(gauge)) == "accepted");  // a gauge's certificate is of its chain
  std::string dependent = bench_text("hardware");
  dependent.erase(dependent.find("model = \"m\""));
  dependent += "independent = false\ncertificate = \"C-1\"\n";
  CHECK(covers_refusal(bench::parse_bench(dependent, "b.toml", {})) == "accepted");  // the regulator's own output
  // What is not filled in comes first.
  const BenchConfig open = hardware_bench({{"reference.certificate", "FILL-IN"}, {"bench.location", "FILL-IN"}});
  CHECK(placeholders_of(open) == Words{"bench.location (--set)", "reference.certificate (--set)"});
  CHECK(covers_refusal(open) == "TB-BENCH-FILL-IN");
}

TEST_CASE("stated: what the simulated instruments' errors are drawn within") {
  const BenchConfig config = simulated_bench({
      {"simulation.instrument_seed", "7"},
      {"reference.span_v", "[1, 5]"},
      {"reference.span_psi", "[10, 90]"},
      {"reference.certificate_covers", "transducer"},
      {"reference.expanded_uncertainty_psi", "0.5"},
      {"reference.drift_psi", "0.25"},
      {"reference.input_limit_v", "0.125"},
      {"reference.hysteresis_psi", "0.3"},
      {"reference.zero_psi", "0.4"},
      {"reference.temperature_psi", "0.6"},
      {"force.certificate_covers", "transducer"},
      {"force.expanded_uncertainty_n", "3"},
      {"force.drift_n", "2"},
      {"force.input_limit_n", "1"},
      {"environment.sensor", "[{quantity = 'supply_bar', unit = 8, address = 7}, {" + kThermometer +
                                 ", certificate_covers = 'transducer', expanded_uncertainty_c = 0.25, drift_c = 0.75, "
                                 "input_limit_c = 1.5}]"},
  });
  const bench::InstrumentOptions& drawn = config.simulation->plant.instruments;
  const auto numbers = [](const bench::DrawnLimits& limits) {
    return std::vector<double>{limits.certificate_u, limits.drift, limits.input};
  };
  CHECK(drawn.seed == 7);
  CHECK(numbers(drawn.reference) == std::vector<double>{0.25, 0.25, 2.5});  // 80 psi on 4 V
  CHECK(drawn.reading_psi == std::vector<double>{0.0});
  CHECK(drawn.certificate_u_psi == std::vector<double>{0.25});
  CHECK(drawn.hysteresis_psi == 0.3);
  CHECK(drawn.zero_psi == 0.4);
  CHECK(drawn.temperature_psi == 0.6);
  CHECK(numbers(drawn.force_n) == std::vector<double>{1.5, 2.0, 1.0});
  CHECK(numbers(drawn.thermometer_c) == std::vector<double>{0.125, 0.75, 1.5});
  const auto drawn_of = [](const Changes& changes) { return simulated_bench(changes).simulation->plant.instruments; };
  CHECK(drawn_of({}).reading_psi.empty());
  CHECK(drawn_of({}).certificate_u_psi.empty());
  CHECK(numbers(drawn_of({}).force_n) == std::vector<double>{0.0, 0.0, 0.0});
  const bench::InstrumentOptions corrected = drawn_of({{"reference.expanded_uncertainty_psi", "0.5"},
                                                       {"reference.correction.coverage_factor", "4"},
                                                       {"reference.correction.reading_psi", "[0, 30]"},
                                                       {"reference.correction.correction_psi", "[0, 0]"},
                                                       {"reference.correction.expanded_uncertainty_psi", "[2, 1]"}});
  CHECK(corrected.reading_psi == std::vector<double>{0.0, 30.0});
  CHECK(corrected.certificate_u_psi == std::vector<double>{0.5, 0.25});
  const bench::InstrumentOptions gauged =
      drawn_of({{"reference.gauge.unit", "2"}, {"reference.gauge.address", "7"}, {"reference.drift_psi", "1"}});
  CHECK(numbers(gauged.reference)[1] == 1.0);
  CHECK(numbers(gauged.reference)[2] == 0.0);
  const bench::InstrumentOptions of_one_volt = drawn_of({{"reference.span_v", "[0, 1]"},
                                                         {"reference.span_psi", "[0, 80]"},
                                                         {"reference.certificate_covers", "transducer"},
                                                         {"reference.input_limit_v", "0.125"}});
  CHECK(numbers(of_one_volt.reference)[2] == 10.0);
}

TEST_CASE("the reference's chain becomes rows, and a run of before the word is read and says what it lacks") {
  const BenchConfig config = hardware_bench({{"reference.certificate_covers", "transducer"},
                                             {"reference.expanded_uncertainty_psi", "0.05"},
                                             {"reference.input_limit_v", "0.03"},
                                             {"reference.hysteresis_psi", "0.1"},
                                             {"reference.certificate_range_psi", "[0, 50]"}});
  db::RunRecord run;
  run.started_utc = "2026-05-06T07:08:09Z";
  run.devices = {reference_record({"pressure reference", "m", "s", "", config.origin}, config)};
  const analysis::ReferenceUncertainty known = analysis::reference_uncertainty(run);
  using analysis::ReferencePart;
  CHECK(known.covers == analysis::CertificateCovers::kTransducer);
  CHECK(known.limit(ReferencePart::kVoltageInput).half_width_psi == Approx(0.3));  // 0.3 % of 100 psi, the audit's
  CHECK(known.limit(ReferencePart::kHysteresis).half_width_psi == 0.1);
  CHECK((known.low_psi == 0.0 && known.high_psi == 50.0));
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
