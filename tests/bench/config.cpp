#include "bench/config.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>

#include "analysis/error.h"
#include "bench/error.h"
#include "db/run_store.h"
#include "devices/fault.h"

using namespace tactbench;
using namespace tactbench::bench;
using sequences::FileError;

namespace {

const std::string kBench = find_config("simulated.toml");

void refused(const sequences::Override& change, const std::string& message) {
  try {
    (void)read_bench(kBench, {change});
    FAIL("accepted " << change.key << " = " << change.value);
  } catch (const FileError& error) {
    INFO(change.key << ": " << error.what() << " at " << error.where());
    CHECK_THAT(error.what(), Catch::Contains(message));
    CHECK(!error.where().empty());
    CHECK(!error.remedy().empty());
  }
}

}  // namespace

TEST_CASE("the shipped bench, sensor and limits files read without complaint") {
  const BenchConfig config = read_bench(kBench, {});
  CHECK(config.origin == devices::Origin::kSimulated);
  CHECK(config.limits.command_psi == 60.0);
  CHECK(config.regulator.command_span.high.value() == Approx(130.534));
  CHECK(config.regulator.command_limit.value() == 60.0);
  CHECK(config.simulation->plant.specimen.rows == 16);
  const SensorType type = read_sensor_type(find_config("sensor.toml"));
  CHECK(type.rows * type.columns == 256);
  CHECK(type.pitch_mm == 2.54);
  const analysis::Limits limits = read_limits(find_config("limits.toml"));
  CHECK(limits.distance_of_mean_fs == Approx(0.015));
  CHECK(limits.sha256 == db::sha256_hex(limits.toml));
}

TEST_CASE("limits are read strictly, and their rule by its word") {
  const std::string whole =
      "schema = 1\nname = \"l\"\nmean_compensation_error_psi = 1\nworst_taxel_error_psi = 3\n"
      "distance_of_mean_percent_fs = 1.5\nunfit_taxels = 0\n";
  const auto complaint = [&](const std::string& more) {
    try {
      (void)parse_limits(whole + more, "l.toml");
    } catch (const sequences::FileError& error) {
      return error.id() + " " + error.where();
    }
    return std::string("none");
  };
  CHECK(parse_limits(whole, "l.toml").rule == analysis::DecisionRule::kDefault);
  CHECK(parse_limits(fmt::format("{}rule = \"four-way\"\n", whole), "l.toml").rule == analysis::DecisionRule::kFourWay);
  CHECK(parse_limits(fmt::format("{}rule = \"report-only\"\n", whole), "l.toml").rule ==
        analysis::DecisionRule::kReportOnly);
  CHECK_THAT(complaint("rule = \"4-way\"\n"), Catch::Contains("TB-FILE-VALUE") && Catch::Contains("l.toml:7"));
  CHECK_THAT(complaint("guard_band = 0.5\n"), Catch::Contains("TB-FILE-KEY") && Catch::Contains("l.toml:7"));
  CHECK_THAT(complaint("[[mismatch]]\npressure_psi = 10\nstd_percent_fs = 5\nrule = \"simple\"\n"),
             Catch::Contains("TB-FILE-KEY"));
}

TEST_CASE("bad bench values are refused with place and remedy") {
  refused({"regulator.feed_intervall_ms", "400"}, "unknown key");
  refused({"scaner.serial", "1"}, "unknown key");
  refused({"limits.command_psi", "\"60 psi\""}, "must be a number");
  refused({"limits.command_psi", "140"}, "outside");
  refused({"limits.trip_psi", "50"}, "outside");
  refused({"regulator.feed_interval_ms", "600"}, "outside");
  refused({"module.watchdog_ms", "600"}, "too slow for a watchdog");
  refused({"reference.drift_psi", "-1"}, "outside");
  refused({"reference.channel", "0"}, "shares the regulator's feedback channel");
  refused({"bench.origin", "real"}, "not one of simulated, hardware");
  refused({"bench.origin", "hardware"}, "has a [simulation] table");
  refused({"simulation.effects.row_cross", "0.1"}, "unknown key");
  refused({"regulator.span_v", "[10, 0]"}, "low < high");
  CHECK_THROWS_AS(read_bench(kBench, {{"module.profile", "beckhof"}}), sequences::FileError);
}

TEST_CASE("names that no file can have, and a folder, are refused as missing files") {
  refused({"module.profile", std::string(300, 'a')}, "no module profile");
  refused({"module.profile", "\".\""}, "no module profile");
  CHECK_THROWS_AS(read_bench(find_config(std::string(300, 'a')), {}), FileError);
  CHECK_THROWS_AS(read_bench(".", {}), FileError);
}

TEST_CASE("a complaint about an overridden value names --set") {
  try {
    (void)read_bench(kBench, {{"limits.comand_psi", "3"}});
    FAIL("accepted");
  } catch (const FileError& error) {
    CHECK_THAT(error.where(), Catch::Contains("--set limits.comand_psi"));
    CHECK_THAT(error.remedy(), Catch::Contains("command_psi"));
  }
}

TEST_CASE("seeds of the command line win over the file") {
  const BenchConfig config = read_bench(kBench, {}, {42, 43});
  CHECK(config.simulation->plant.seed == 42);
  CHECK(config.simulation->plant.specimen.sensor_seed == 43);
}

TEST_CASE("every room's error becomes the contract's exit code") {
  const auto code = [](const auto& thrown) {
    try {
      throw thrown;
    } catch (...) {
      return as_error(std::current_exception()).code();
    }
  };
  CHECK(code(devices::Fault("TB-MODBUS-TIMEOUT", "d", "m", "r")) == ExitCode::kDevice);
  CHECK(code(devices::Fault("TB-CHAMBER-TRIP", "d", "m", "r")) == ExitCode::kStopped);
  CHECK(code(FileError("TB-FILE-KEY", "m", "w", "r")) == ExitCode::kUsage);
  CHECK(code(db::StoreError("TB-STORE-NEWER", "m", "r")) == ExitCode::kStore);
  CHECK(code(db::StoreError("TB-STORE-NOT-FOUND", "m", "r")) == ExitCode::kUsage);
  CHECK(code(analysis::AnalysisError("TB-ANALYSIS-EMPTY", "m", "r")) == ExitCode::kInconclusive);
  CHECK(code(std::runtime_error("x")) == ExitCode::kInternal);
}

TEST_CASE("an error says what, where, how to mend it and how the rig was left") {
  const Error error(ExitCode::kDevice, "TB-X", "what", "where", "mend", "vented");
  CHECK(error_text(error) == "error: what [TB-X]\n  at: where\n  try: mend\n  state: vented\n");
  CHECK_THAT(error_json(error), Catch::Contains("\"exit_code\": 3"));
}

TEST_CASE("the example of the paper's rig reads without complaint, and names hardware only") {
  const BenchConfig config = read_bench(find_config("paper-rig.example.toml"), {});
  CHECK(config.origin == devices::Origin::kHardware);
  CHECK_FALSE(config.in_process);
  CHECK_FALSE(config.simulation);
  CHECK(config.scanner_kind == ScannerKind::kDaqmx);
  REQUIRE(config.stage);
  CHECK(config.stage->options.axes[2].device_id == 5082);
  REQUIRE(config.force);
  CHECK(config.force->kind == ForceKind::kNet);
  CHECK(config.force->net.port == 49152);
}

TEST_CASE("bad instrument values are refused with place and remedy") {
  refused({"scanner.kind", "daqmx"}, "no NI-DAQmx device");
  refused({"scanner.kind", "camera"}, "not one of");
  refused({"stage.x.device_id", "7"}, "not a device id");
  refused({"stage.z.low_mm", "60"}, "high_mm");
  refused({"force.kind", "daq"}, "no NI-DAQmx device");
  refused({"force.overload_share", "1.5"}, "outside");
  refused({"bench.simulator", "somewhere"}, "not one of");
  refused({"bench.simulator", "external"}, "external simulator");
  refused({"environment.sensor", "[{quantity = 'humidity', address = 1}]"}, "not one of");
}
