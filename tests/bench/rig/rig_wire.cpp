// The rig at its edges: what it refuses without an instrument, and that each exchange with each of them counts.

#include <fmt/format.h>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <chrono>
#include <cmath>
#include <fstream>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bench/instruments/check.h"
#include "bench/pressure/pressure_kinds.h"
#include "bench/rig/rig.h"
#include "bench/safety/safe_state.h"
#include "bench/simulation/plant.h"
#include "sequences/toml/strict_toml.h"
#include "tests/bench/run/finished_run.h"
#include "tests/devices/fault_of.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

const std::string kLineOfSensors =
    "[{quantity = 'temperature_c', unit = 9, address = 7, type = 'i16', raw_span = [-1000, 1000], span_c = [-100, "
    "100]}, "
    "{quantity = 'supply_bar', unit = 9, address = 20, type = 'f32'}]";

}  // namespace

TEST_CASE("rig: reading a device that is not open or not present is a logic error") {
  bench::BenchConfig config = small_request().bench;
  {
    bench::Rig rig(config);
    CHECK_THROWS_AS(rig.array(), std::logic_error);
    CHECK_FALSE(rig.has_array());
    rig.open_array();
    CHECK(rig.array().rows() == 16);
    rig.close_array();
    CHECK_THROWS_AS(rig.array(), std::logic_error);
    CHECK(rig.force() == nullptr);
    CHECK(rig.relay_operations().empty());
    CHECK(rig.plant() != nullptr);
    CHECK(rig.dead_man() == nullptr);
  }
  bench::BenchConfig no_force = config, no_stage = config;
  no_force.force.reset();
  no_stage.stage.reset();
  bench::Rig without_force(no_force), without_stage(no_stage);
  CHECK_THROWS_AS(without_force.open_force(), std::logic_error);
  CHECK_THROWS_AS(without_force.name_press_instruments(), std::logic_error);
  CHECK(without_force.stage_gate() != nullptr);
  CHECK_THROWS_AS(without_stage.name_press_instruments(), std::logic_error);
  CHECK(without_stage.stage_gate() == nullptr);
}

TEST_CASE("rig: every exchange is counted, for each instrument") {
  bench::Rig rig(small_request({{"environment.sensor", kLineOfSensors}}).bench);
  rig.open();
  (void)rig.open_force();
  rig.stage_gate()->arm();
  const auto counted = [&](const std::function<void()>& exchange) {
    rig.clock().wait_until(rig.clock().now() +
                           std::chrono::milliseconds(100));  // an image of the module may be read twice
    const std::uint64_t before = rig.exchanges();
    exchange();
    return static_cast<std::int64_t>(rig.exchanges() - before);
  };
  CHECK(counted([] {}) == 0);
  CHECK(counted([&] { (void)rig.environment(0); }) == 1);
  CHECK(counted([&] { (void)rig.environment(); }) == 2);
  CHECK(counted([&] { (void)rig.reference().read(); }) > 0);
  CHECK(counted([&] { (void)rig.source().feedback(); }) > 0);
  CHECK(counted([&] { (void)rig.array().read(1); }) > 0);
  CHECK(counted([&] { (void)rig.stage_gate()->state(devices::Axis::kZ); }) > 0);
  CHECK(counted([&] { (void)rig.force()->read(10); }) > 0);
  CHECK(rig.environment(0).quantity == "temperature_c");
  CHECK(rig.environment(0).value == Approx(23.0).margin(0.11));
  CHECK(rig.environment(1).value == Approx(8.0));
}

TEST_CASE("rig: press instruments are recorded, and closed again if they were not open before") {
  bench::Rig rig(small_request().bench);
  const std::size_t before = rig.devices().size();
  rig.name_press_instruments();
  CHECK(rig.force() == nullptr);
  CHECK(rig.devices().size() == before + 4);  // three axes and the force sensor
  (void)rig.open_force();
  rig.name_press_instruments();
  CHECK(rig.force() != nullptr);
  CHECK(rig.devices().size() == before + 4);
  rig.open_array();
  REQUIRE(rig.devices().size() == before + 5);
  std::vector<std::string> roles;
  for (const db::DeviceRecord& device : rig.devices()) roles.push_back(device.role);
  CHECK(std::vector<std::string>(roles.end() - 5, roles.end()) ==
        std::vector<std::string>{"stage x", "stage y", "stage z", "force sensor", "tactile scanner"});
}

// The pressure side as the bench file describes it: other modules, a serial line, a digital gauge, the environment.

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

TEST_CASE("bench file: an impossible pressure configuration is rejected, and the error names the key") {
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

// A bench whose pressure source is a controller on a serial line: whole runs, what is stored of it, what is refused.

namespace {

using Overrides = std::vector<sequences::Override>;

constexpr const char* kShipped = "simulated-serial.toml";

bench::RunRequest request_of(const Overrides& overrides = {}) { return small_request(overrides, {}, kShipped); }

// The shipped file with its [reference] replaced by other tables.
bench::RunRequest request_with(const std::string& tables) {
  std::string text = read_file(bench::find_config(kShipped));
  const std::size_t at = text.find("\n[reference]") + 1;
  text.replace(at, text.find("\n[scanner]") + 1 - at, tables);
  bench::RunRequest request = request_of();
  request.bench = bench::parse_bench(text, kShipped, {});
  return request;
}

const db::DeviceRecord& record_of(const db::RunRecord& run, const std::string& role) {
  return *std::ranges::find(run.devices, role, &db::DeviceRecord::role);
}

// The error's place and text; "taken" where there is none.
template <class Act>
std::string refusal_of(Act&& act) {
  try {
    (void)act();
    return "taken";
  } catch (const sequences::FileError& error) {
    CHECK_FALSE(error.remedy().empty());
    return error.where() + " " + error.what();
  }
}

}  // namespace

TEST_CASE("serial regulator: a run against an independent gauge completes, follows its levels and ends vented") {
  double psi_at_end = -1.0;
  bench::RunRequest request = request_of();
  request.on_rig = [&](bench::Rig& rig, bench::RigMoment moment) {
    if (moment == bench::RigMoment::kLeft) psi_at_end = rig.plant()->true_pressure().value();
  };
  const FinishedRun run(request);
  if (run.result.error) FAIL(run.result.error->what());
  CHECK(run.result.frames == 30);
  CHECK(run.result.safe == db::SafeState::kVerified);
  CHECK(std::abs(psi_at_end) < 1.0);
  CHECK(run.result.most_exchanges_a_step <= 30);
  for (const db::FrameRecord& frame : run.frames) {
    INFO(frame.setpoint_psi);
    CHECK(std::abs(frame.reference_psi - frame.setpoint_psi) < 1.0);
    CHECK(std::abs(frame.feedback_psi - frame.setpoint_psi) < 0.5);
  }
  const db::RunRecord row = run.store.run(run.result.run);
  const db::DeviceRecord& regulator = record_of(row, "regulator");
  CHECK(regulator.serial == "SIM-PC-1");
  CHECK(regulator.origin == "simulated");
  const auto kept = nlohmann::json::parse(regulator.calibration_json);
  CHECK(kept.at("psi_high") == 100.0);
  CHECK_FALSE(kept.contains("volts_high"));
  CHECK(std::ranges::count(row.devices, "analog module", &db::DeviceRecord::role) == 0);
}

TEST_CASE("serial regulator: its own transducer, or one behind a module, serves as the reference") {
  const auto [tables, model, modules] = GENERATE(table<std::string, std::string, int>(
      {{"[reference]\nindependent = false\n", "Alicat PCD-100PSIG-D (feedback)", 0},
       {"[module]\nprofile = \"moxa-iologik-e1240\"\n[reference]\nmodel = \"m\"\nserial = \"s\"\nchannel = 1\n"
        "span_v = [0, 10]\nspan_psi = [0, 100]\ncertificate_covers = \"chain\"\n",
        "m", 1}}));
  INFO(tables);
  const FinishedRun run(request_with(tables));
  if (run.result.error) FAIL(run.result.error->what());
  CHECK(run.result.safe == db::SafeState::kVerified);
  for (const db::FrameRecord& frame : run.frames) CHECK(std::abs(frame.reference_psi - frame.setpoint_psi) < 1.0);
  const db::RunRecord row = run.store.run(run.result.run);
  CHECK(record_of(row, "pressure reference").model == model);
  CHECK(std::ranges::count(row.devices, "analog module", &db::DeviceRecord::role) == modules);
}

TEST_CASE("serial regulator: an invalid bench file is refused with the key at fault") {
  CHECK(refusal_of([] { return request_of(); }) == "taken");
  const std::vector<std::pair<Overrides, std::string>> rows = {
      {{{"regulator.relief", "''"}}, "relief"},
      {{{"regulator.setpoint_field", "1"}}, "setpoint_field"},
      {{{"regulator.span_v", "[0, 10]"}}, "span_v"},
      {{{"regulator.unit", "'a'"}}, "unit"},
      {{{"regulator.kind", "'io-link'"}}, "kind"},
      {{{"input_module.profile", "moxa-iologik-e1240"}}, "input_module"},
      {{{"module.profile", "moxa-iologik-e1241"}}, "profile"},  // no inputs
      {{{"module.profile", "moxa-iologik-e1240"}, {"module.watchdog_ms", "1000"}}, "watchdog_ms"},
      {{{"dead_man.blind", "'warn'"}}, "blind"},
      {{{"bench.origin", "'hardware'"}, {"regulator.baud", "9600"}}, "simulation"}};
  for (const auto& [overrides, key] : rows) {
    INFO(key);
    CHECK_THAT(refusal_of([&] { return request_of(overrides); }), Catch::Contains(key));
  }
  const std::string one = "[reference]\nmodel = \"m\"\nserial = \"s\"\ncertificate_covers = \"chain\"\n";
  CHECK_THAT(refusal_of([&] { return request_with(one); }), Catch::Contains("independent"));
  CHECK_THAT(refusal_of([&] { return request_with(one + "[reference.gauge]\nunit = 5\naddress = 0\n"); }),
             Catch::Contains("reference.gauge"));
}

TEST_CASE("serial regulator: its reach and its step limit a recipe as its own numbers say") {
  const bench::BenchConfig config = request_of({{"regulator.full_scale_psi", "50"}, {"regulator.decimals", "1"}}).bench;
  CHECK(bench::pressure_kind(config).highest_psi(config) == 50.0);
  CHECK(bench::pressure_kind(config).step_psi(config) == Approx(0.1));
}

TEST_CASE("serial regulator: the fail-safe layers warn of a failed line or power, and name the relief device") {
  bench::BenchConfig config = request_of({{"regulator.relief", "'RV-7'"}}).bench;
  const auto warnings = [&] {
    std::vector<std::string> all = bench::fail_safe_layers(config);
    std::erase_if(all, [](const std::string& line) { return !line.starts_with("WARNING"); });
    return all;
  };
  REQUIRE(warnings().size() == 2);
  for (const std::string& line : warnings()) {
    CHECK_THAT(line, Catch::Contains("RV-7"));
    CHECK_THAT(line, Catch::Contains("Alicat"));
  }
  CHECK_THAT(bench::when_source_is_lost(config), Catch::Contains("RV-7"));
  const std::size_t layers = bench::fail_safe_layers(config).size();
  config.controller.exhausts = false;
  CHECK(bench::fail_safe_layers(config).size() == layers - 1);
  CHECK(warnings().size() == 2);
  config.in_process = false;
  config.dead_man.enabled = false;
  CHECK(warnings().size() == 3);
}

TEST_CASE("serial regulator: devices check finds it, reads it, and writes nothing to it") {
  bench::Rig rig(request_of().bench);
  rig.plant()->drive(devices::Volts(4.0), devices::Nanoseconds::max(), devices::Volts(4.0));
  rig.clock().wait_until(rig.clock().now() + std::chrono::seconds(5));
  const std::vector<bench::DeviceCheck> all = bench::check_devices(rig, "2026-01-31");
  const auto regulator = std::ranges::find(all, "regulator", &bench::DeviceCheck::role);
  REQUIRE(regulator != all.end());
  CHECK(regulator->state == bench::DeviceCheck::State::kWrong);  // 40 psi is not zero
  CHECK_THAT(regulator->reading, Catch::Contains("40.") || Catch::Contains("39."));
  CHECK(std::ranges::count(all, "analog module", &bench::DeviceCheck::role) == 0);
  CHECK(rig.plant()->true_pressure().value() == Approx(40.0).margin(1.0));
  rig.plant()->inject(bench::FaultKind::kControllerSilent);
  rig.clock().wait_until(rig.clock().now() + std::chrono::seconds(1));  // its last answer is too old to stand in
  const std::vector<bench::DeviceCheck> later = bench::check_devices(rig, "2026-01-31");
  CHECK(std::ranges::find(later, "regulator", &bench::DeviceCheck::role)->state == bench::DeviceCheck::State::kAbsent);
}
