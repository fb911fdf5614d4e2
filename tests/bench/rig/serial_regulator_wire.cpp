// A bench whose pressure source is a controller on a serial line: whole runs, what is stored of it, what is refused.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/instruments/check.h"
#include "bench/pressure/pressure_kinds.h"
#include "bench/safety/safe_state.h"
#include "bench/simulation/plant.h"
#include "tests/bench/run/finished_run.h"
#include "tests/devices/fault_of.h"

using namespace tactbench;
using namespace tactbench::tests;

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
