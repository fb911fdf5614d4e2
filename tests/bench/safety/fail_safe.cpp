// The fail-safe layers of a bench, exclusive use of a line, and the unloaded frame.
#include "bench/safety/safe_state.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "bench/config/config.h"
#include "bench/guard/dead_man_process.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

BenchConfig plain_bench() {
  BenchConfig config;
  config.module.profile.model = "MODEL";
  return config;
}

// How many of the layers are warnings.
long warnings(const BenchConfig& config) {
  return std::ranges::count_if(fail_safe_layers(config), [](const auto& line) { return line.starts_with("WARNING"); });
}

}  // namespace

TEST_CASE("fail-safe layers: lists the layers of this program with their values, and warns about each missing one") {
  BenchConfig config = plain_bench();
  config.in_process = true;
  config.limits.trip_psi = 64.0;
  CHECK(fail_safe_layers(config).size() == 4);
  CHECK_THAT(fail_safe_layers(config)[0], Catch::Contains("64 psi"));
  CHECK(warnings(config) == 1);  // no watchdog
  config.in_process = false;
  config.dead_man.timeout_s = 0.35;
  config.dead_man.progress_s = 1.25;
  REQUIRE(fail_safe_layers(config).size() == 5);
  CHECK_THAT(fail_safe_layers(config)[1], Catch::Contains("350 ms") && Catch::Contains("1250 ms"));
  const std::string ends = fail_safe_layers(config)[1];
  config.dead_man.blind_ends = false;
  CHECK(fail_safe_layers(config)[1] != ends);
  config.stage.emplace();
  config.dead_man.back_off_mm = 4.5;
  const std::string own_line = fail_safe_layers(config)[1];
  CHECK_THAT(own_line, Catch::Contains("4.5 mm"));
  config.module.endpoint.serial_port = "/dev/ttyS0";  // nothing of its own to be blind on
  CHECK(fail_safe_layers(config)[1].size() < own_line.size());
  CHECK(warnings(config) == 1);
  config.dead_man.enabled = false;
  CHECK(warnings(config) == 2);
  CHECK_THAT(fail_safe_layers(config)[1], Catch::Contains("[dead_man] enabled"));
  config.in_process = true;
  CHECK(warnings(config) == 1);
}

TEST_CASE("fail-safe layers: lists dump valve, layers of the module, and its watchdog with the feed interval") {
  BenchConfig config = plain_bench();
  config.in_process = true;
  config.module.profile.dump_coil = 0;
  config.module.profile.fail_safe.layers = {"first", "second"};
  config.watchdog_s = 1.5;
  config.regulator.feed_interval = std::chrono::milliseconds(350);
  const std::vector<std::string> lines = fail_safe_layers(config);
  REQUIRE(lines.size() == 7);
  CHECK_THAT(lines[1], Catch::Contains("coil 0"));
  CHECK_THAT(lines[2], Catch::Contains("MODEL") && Catch::EndsWith("first"));
  CHECK_THAT(lines[3], Catch::Contains("MODEL") && Catch::EndsWith("second"));
  CHECK_THAT(lines[6], Catch::Contains("1500 ms") && Catch::Contains("350 ms"));
  CHECK(warnings(config) == 0);
  config.module.profile.dump_coil = -1;
  config.watchdog_s = 0.0;
  CHECK(fail_safe_layers(config).size() == 6);
  CHECK(warnings(config) == 1);
}

TEST_CASE("fail-safe layers: the pressures at 0 V and without supply are computed from the spans") {
  using devices::Psi, devices::Volts;
  BenchConfig config = plain_bench();
  config.in_process = true;
  config.watchdog_s = 1.0;
  const auto set = [](devices::LinearSpan& span, double v0, double v1, double psi0, double psi1) {
    span = {Volts(v0), Volts(v1), Psi(psi0), Psi(psi1)};
  };
  const auto told = [&](const std::string& number) {
    return std::ranges::count_if(fail_safe_layers(config),
                                 [&](const auto& line) { return line.find(number + " psi") != std::string::npos; });
  };
  set(config.regulator.command_span, 0, 10, 0, 130.5);
  set(config.reference.span, 1, 5, 0, 100);
  CHECK(warnings(config) == 0);
  CHECK(told("-25.0") == 1);  // of a transducer with a live zero
  set(config.regulator.command_span, -10, 10, 0, 130.5);
  CHECK(warnings(config) == 1);
  CHECK(told("65.2") == 2);  // without power, and with a silent bus
  CHECK_THAT(when_source_is_lost(config), Catch::Contains("1000 ms") && Catch::Contains("65.2 psi"));
  config.regulator.relief = "RV-1";
  CHECK_THAT(when_source_is_lost(config), Catch::Contains("RV-1"));
  config.watchdog_s = 0.0;
  CHECK_THAT(when_source_is_lost(config), Catch::Contains("RV-1") && !Catch::Contains("watchdog"));
}

TEST_CASE("shared lines: neither process keeps a line exclusively, and the dead-man takes no lock") {
  BenchConfig config = plain_bench();
  config.input_module.emplace();
  config.reference_gauge.emplace();
  config.environment.resize(2);
  const auto endpoints = [&] {
    return std::vector<devices::ModbusEndpoint*>{&config.module.endpoint, &config.input_module->endpoint,
                                                 &config.reference_gauge->endpoint, &config.environment[0].endpoint,
                                                 &config.environment[1].endpoint};
  };
  for (devices::ModbusEndpoint* endpoint : endpoints()) endpoint->exclusive = endpoint->lock = true;
  share_lines(config, false);
  for (const devices::ModbusEndpoint* endpoint : endpoints()) CHECK((!endpoint->exclusive && endpoint->lock));
  CHECK((!config.controller_address.exclusive && config.controller_address.lock));
  share_lines(config, true);
  for (const devices::ModbusEndpoint* endpoint : endpoints()) CHECK((!endpoint->exclusive && !endpoint->lock));
  CHECK((!config.controller_address.exclusive && !config.controller_address.lock));
}

TEST_CASE("unloaded frame: each taxel has the mean of all its scans") {
  devices::ScanSet scans;
  scans.rows = 1;
  scans.columns = 3;
  scans.scans = 2;
  scans.counts = {10, 20, 30, 14, 21, 65535};
  CHECK(unloaded_frame_of(scans) == UnloadedFrame{12.0, 20.5, 32782.5});
}
