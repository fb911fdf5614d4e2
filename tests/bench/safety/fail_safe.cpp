// The fail-safe layers of a bench, exclusive use of a line, and the unloaded frame.

#include "bench/safety/safe_state.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/config/config.h"
#include "bench/guard/dead_man_process.h"
#include "bench/safety/retract.h"
#include "tests/bench/run/press/press_rig.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;
using bench::RetractProof;
using std::chrono::milliseconds;

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

// The retraction on an ideal stage: what proves it and what does not, to the last micrometre and millinewton.

namespace {

struct Retreat {
  explicit Retreat(double z_mm, double force_n = 0.0) : bed([=](double) { return force_n; }) {
    bed.stage.put(devices::Axis::kZ, z_mm);
  }
  RetractProof go(const std::function<void(devices::Nanoseconds)>& wait = {}, bool sensor = true) {
    return bench::retract(bed.stage, sensor ? &bed.force : nullptr, bed.clock, {10.0, 2.0, 0.5, 37}, wait);
  }
  IdealBed bed;
};

}  // namespace

TEST_CASE("retract on an ideal stage: halts, arms, moves to clear at its speed, settles, reads the force") {
  Retreat high(13.0, 0.2);
  const RetractProof proof = high.go();
  CHECK(proof.verified);
  CHECK(proof.halted);
  CHECK(proof.z_mm == 10.0);
  CHECK(proof.force_n == 0.2);
  CHECK_THAT(proof.text, Catch::Contains("10.000 mm") && Catch::Contains("0.20 N"));
  CHECK(high.bed.stage.sent_mm == std::vector<double>{10.0});
  CHECK(high.bed.stage.speeds == std::vector<double>{2.0});
  CHECK(high.bed.stage.halts == 1);
  CHECK(high.bed.stage.arms == 1);
  CHECK(high.bed.clock.now() == milliseconds(1500 + 100));  // 3 mm at 2 mm/s, and the settling
  REQUIRE(high.bed.force.reads.size() == 1);
  CHECK(high.bed.force.reads[0].records == 37);
}

TEST_CASE("retract on an ideal stage: z at clear does not move, arrival has a tolerance of one micrometre") {
  for (const double z_mm : {0.0, 10.0, 10.001}) {
    Retreat there(z_mm);
    CHECK(there.go().verified);
    CHECK(there.bed.stage.sent_mm.empty());
    CHECK(there.bed.clock.now() == milliseconds(100));
  }
  Retreat beyond(std::nextafter(10.001, 11.0));
  CHECK(beyond.go().verified);
  CHECK(beyond.bed.stage.sent_mm.size() == 1);
}

TEST_CASE("retract on an ideal stage: the force must be below the safe limit in both directions, and finite") {
  const auto at = [](double force_n) {
    const RetractProof proof = Retreat(12.0, force_n).go();
    CHECK(proof.z_mm == (std::abs(force_n) < 0.5 ? 10.0 : 0.0));  // pressed at clear: goes home
    if (!proof.verified) CHECK_THAT(proof.text, Catch::StartsWith("NOT SAFE"));
    return proof.verified;
  };
  for (const double light : {std::nextafter(0.5, 0.0), -0.49}) CHECK(at(light));
  for (const double pressed : {0.5, -0.5, -3.0, std::numeric_limits<double>::quiet_NaN()}) CHECK_FALSE(at(pressed));
}

TEST_CASE("retract on an ideal stage: a stage that does not arm and a silent force sensor are tried twice") {
  Retreat once(12.0);
  once.bed.stage.refuses_arms = 1;
  CHECK(once.go().verified);
  CHECK(once.bed.stage.halts == 2);
  Retreat never(12.0);
  never.bed.stage.refuses_arms = 5;
  const RetractProof proof = never.go();
  CHECK_FALSE(proof.verified);
  CHECK_FALSE(proof.z_mm);
  CHECK(never.bed.stage.arms == 2);
  CHECK_THAT(proof.text, Catch::Contains("0.00 N") && Catch::Contains("does not arm"));
  Retreat mute(12.0);
  mute.bed.force.failures = 1;
  CHECK(mute.go().verified);
  mute.bed.force.failures = 2;
  const RetractProof silent = mute.go();
  CHECK_FALSE(silent.verified);
  CHECK_FALSE(silent.force_n);
  CHECK(silent.z_mm == 10.0);
  CHECK_THAT(silent.text, Catch::Contains("10.000 mm") && Catch::Contains("no record"));
  const RetractProof blind = Retreat(12.0).go({}, false);
  CHECK_FALSE(blind.verified);
  CHECK(blind.z_mm == 10.0);
  CHECK_FALSE(blind.force_n);
  Retreat disobeys(12.0);
  disobeys.bed.stage.obeys = false;
  CHECK_FALSE(disobeys.go().halted);
}

TEST_CASE("retract on an ideal stage: z without a home position is homed, whatever the clear position is") {
  Retreat lost(12.0);
  lost.bed.stage.homed = false;
  const RetractProof proof = lost.go();
  CHECK(proof.verified);
  CHECK(proof.z_mm == 0.0);
  CHECK(lost.bed.stage.homed_order == std::vector<devices::Axis>{devices::Axis::kZ});
  CHECK(lost.bed.stage.sent_mm.empty());
}

TEST_CASE("retract on an ideal stage: if the object still presses at clear, z goes home") {
  for (const auto& [z_mm, surface_mm] :
       {std::pair(6.0, 5.0), std::pair(10.0, 5.0), std::pair(13.0, 5.0), std::pair(10.0, 9.8), std::pair(13.0, 9.8)}) {
    Retreat tall(z_mm);
    tall.bed.force.law = [top = surface_mm](double at_mm) { return 20.0 * std::max(0.0, at_mm - top); };
    const RetractProof proof = tall.go();
    REQUIRE(proof.verified);
    CHECK(proof.z_mm == 0.0);
    CHECK(proof.force_n == 0.0);
    CHECK(tall.bed.stage.sent_mm.back() == 0.0);
  }
}

TEST_CASE("retract on an ideal stage: waits in slices of 100 ms, and uses the clock if the wait throws") {
  std::vector<devices::Nanoseconds> asked;
  Retreat fed(10.5);  // 250 ms
  CHECK(fed.go([&](devices::Nanoseconds time) { asked.push_back(time); }).verified);
  CHECK(asked ==
        std::vector<devices::Nanoseconds>{milliseconds(100), milliseconds(200), milliseconds(250), milliseconds(350)});
  Retreat thrown(10.5);
  CHECK(thrown.go([](devices::Nanoseconds) { throw std::runtime_error("stop"); }).verified);
  CHECK(thrown.bed.clock.now() == milliseconds(350));
}
