// The pressure side as the bench file describes it: other modules, a serial line, a digital gauge, the environment.
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>

#include "sequences/toml/strict_toml.h"
#include "tests/bench/run/finished_run.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

using Overrides = std::vector<sequences::Override>;

std::string value_of(const std::vector<db::EventRecord>& events, const std::string& kind, const std::string& id) {
  for (const db::EventRecord& event : events) {
    if (event.kind == kind && event.id == id) return event.detail;
  }
  return "none";
}

const Overrides kWaveshare = {{"module.profile", "waveshare-analog-output-8ch-b"},
                              {"module.transport", "rtu"},
                              {"module.baud", "115200"},
                              {"input_module.profile", "waveshare-analog-input-8ch-b"},
                              {"input_module.unit", "2"}};

// The shipped bench file without the lines that begin with one of `keys`, from `table` on.
bench::RunRequest request_without(const std::string& table, const std::vector<std::string>& keys,
                                  const Overrides& overrides) {
  const TemporaryFolder folder;
  std::string text = bench::read_bench(bench::find_config("simulated.toml"), {}).text;
  for (const std::string& key : keys) {
    const std::size_t at = text.find("\n" + key + " =", text.find("[" + table + "]"));
    text.erase(at, text.find('\n', at + 1) - at);
  }
  std::ofstream(folder.path("bench.toml")) << text;
  bench::RunRequest request = small_request();
  request.bench = bench::read_bench(folder.path("bench.toml"), overrides);
  return request;
}

// The keys that only a module with a watchdog, on TCP, has.
bench::RunRequest rtu_request() {
  return request_without("module", {"watchdog_ms", "host", "port", "profile"}, kWaveshare);
}

}  // namespace

TEST_CASE("rig: a run works over Modbus RTU with outputs and inputs in two modules") {
  const FinishedRun run(rtu_request());
  const bench::RunResult& result = run.result;
  if (result.error) FAIL(result.error->what());
  CHECK(result.frames == 30);
  CHECK(result.safe == db::SafeState::kVerified);
  CHECK(result.most_exchanges_a_step <= 30);
  CHECK(run.store.run(result.run).devices.size() == 5);
  for (const db::FrameRecord& frame : run.frames) {
    CHECK(std::abs(frame.reference_psi - frame.setpoint_psi) < 1.0);
  }
}

TEST_CASE("rig: a digital gauge serves as reference with its correction, and the environment is stored with the run") {
  const Overrides overrides = {{"reference.gauge.unit", "5"},
                               {"reference.gauge.address", "100"},
                               {"reference.gauge.type", "f32"},
                               {"reference.gauge.word_order", "low-first"},
                               {"reference.correction.reading_psi", "[0, 60]"},
                               {"reference.correction.correction_psi", "[0.0, 3.0]"},
                               {"reference.correction.expanded_uncertainty_psi", "[0.02, 0.05]"},
                               {"environment.sensor",
                                "[{quantity = 'temperature_c', unit = 9, address = 7, type = 'i16', raw_span = [-1000, "
                                "1000], span_c = [-100, 100]}, {quantity = 'supply_bar', unit = 9, address = 20, "
                                "type = 'f32'}]"},
                               {"simulation.temperature_c", "25.5"}};
  const FinishedRun run(request_without("reference", {"channel", "span_v", "span_psi"}, overrides));
  const bench::RunResult& result = run.result;
  if (result.error) FAIL(result.error->what());
  for (const db::FrameRecord& frame : run.frames) {
    CHECK(frame.reference_psi == Approx(1.05 * frame.feedback_psi).margin(0.6));
  }
  const auto events = run.store.events(result.run);
  CHECK(value_of(events, "environment", "temperature_c") == "25.500");
  CHECK(value_of(events, "environment", "supply_bar") == "8.000");
  const db::RunRecord row = run.store.run(result.run);
  CHECK(row.devices.size() == 6);
  CHECK_THAT(row.devices[2].calibration_json, Catch::Contains("correction_psi"));
}

TEST_CASE("rig: an impossible pressure configuration is rejected, and the error names the key") {
  const std::vector<std::pair<Overrides, std::string>> rows = {
      {{{"module.profile", "moxa-iologik-e1241"}}, "watchdog"},
      {{{"module.profile", "moxa-iologik-e1240"}}, "profile"},  // no outputs
      {{{"module.transport", "rtu"}}, "profile"},
      {{{"module.baud", "9600"}}, "baud"},
      {{{"reference.correction.reading_psi", "[0, 60]"},
        {"reference.correction.correction_psi", "[0.0]"},
        {"reference.correction.expanded_uncertainty_psi", "[0.02, 0.05]"}},
       "correction"},
      {{{"reference.gauge.address", "3"}, {"reference.independent", "false"}}, "independent"},
      {{{"reference.gauge.address", "3"}, {"reference.gauge.unit", "3"}}, "reference"}};
  for (const auto& [overrides, key] : rows) {
    INFO(key);
    try {
      (void)small_request(overrides);
      FAIL("it was taken");
    } catch (const sequences::FileError& error) {
      CHECK_THAT(error.where() + " " + error.what(), Catch::Contains(key));
      CHECK_FALSE(error.remedy().empty());
    }
  }
}
