#include "bench/config/config.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>
#include <string>

#include "analysis/error.h"
#include "bench/common/error.h"
#include "bench/common/overrides.h"
#include "bench/config/config_calibration.h"
#include "db/run_store.h"
#include "devices/fault.h"
#include "tests/bench/config/bench_text.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;
using sequences::FileError;

namespace {

const std::string kBench = find_config("simulated.toml");

// `place`: what the error points at, where that is not the key that was changed.
void refused(const sequences::Override& change, const std::string& place = {}) {
  INFO(change.key << " = " << change.value);
  const tests::Refusal refusal = tests::file_refusal([&] { (void)read_bench(kBench, {change}); });
  CHECK(refusal.id.starts_with("TB-"));
  CHECK(refusal.id != "TB-FILE-KEY");  // the key is known, its value is not taken
  CHECK_THAT(refusal.where, Catch::Contains(place.empty() ? change.key : place));
  CHECK_FALSE(refusal.remedy.empty());
}

BenchConfig bench_with(const std::string& typed) {
  return read_bench(find_config("simulated.toml"), split_overrides({typed}).bench);
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

TEST_CASE("limits are read strictly, and the decision rule by name") {
  const std::string whole =
      "schema = 1\nname = \"l\"\nmean_compensation_error_psi = 1\nworst_taxel_error_psi = 3\n"
      "distance_of_mean_percent_fs = 1.5\nunfit_taxels = 0\n";
  CHECK(parse_limits(whole, "l.toml").rule == analysis::DecisionRule::kDefault);
  CHECK(parse_limits(fmt::format("{}rule = \"four-way\"\n", whole), "l.toml").rule == analysis::DecisionRule::kFourWay);
  CHECK(parse_limits(fmt::format("{}rule = \"report-only\"\n", whole), "l.toml").rule ==
        analysis::DecisionRule::kReportOnly);
  for (const auto& [more, id] :
       {std::pair("rule = \"4-way\"\n", "TB-FILE-VALUE"), {"guard_band = 0.5\n", "TB-FILE-KEY"}}) {
    const tests::Refusal refusal = tests::file_refusal([&] { (void)parse_limits(whole + more, "l.toml"); });
    CHECK(refusal.id == id);
    CHECK_THAT(refusal.where, Catch::Contains("l.toml:7"));
  }
}

TEST_CASE("bad bench values are refused with place and remedy") {
  refused({"limits.command_psi", "\"60 mbar\""});
  refused({"reference.channel", "0"});
  refused({"bench.id", "\" \""});
  refused({"bench.origin", "real"});
  refused({"bench.origin", "hardware"}, "simulation");
  refused({"regulator.span_v", "[10, 0]"});
  // 0 V is 65.3 psi, -14.5 psi, 7.3 psi; then 0 psi is out of reach.
  for (const char* span_bar : {"[-1, 9]", "[0.5, 9]", "[0.05, 9]"}) refused({"regulator.span_bar", span_bar}, "span_v");
  for (const char* span_v : {"[-10, 10]", "[-5, 5]"}) refused({"regulator.span_v", span_v}, "span_v");
  refused({"settling.trace_s", "1e-9"});
  refused({"module.profile", "beckhof"}, "[module] profile");
  refused({"module.profile", std::string(300, 'a')}, "[module] profile");
  refused({"module.profile", "\".\""}, "[module] profile");
  refused({"scanner.kind", "daqmx"});
  refused({"scanner.kind", "camera"});
  refused({"stage.x.device_id", "7"});
  refused({"stage.z.low_mm", "60"}, "stage.z.high_mm");
  refused({"force.kind", "daq"});
  refused({"bench.simulator", "somewhere"});
  refused({"environment.sensor", "[{quantity = 'humidity', address = 1}]"});
}

TEST_CASE(
    "a regulator that 0 V does not vent needs something named that relieves the chamber, and a voltage for 0 psi") {
  const auto reads = [](const std::vector<sequences::Override>& changes) { return read_bench(kBench, changes); };
  const std::vector<sequences::Override> vacuum = {{"regulator.span_bar", "[-1, 9]"}};
  std::vector<sequences::Override> named = vacuum;
  named.push_back({"regulator.relief", "'vacuum breaker'"});
  CHECK(tests::file_refusal([&] { (void)reads(vacuum); }).id == "TB-FILE-VALUE");
  const BenchConfig config = reads(named);
  CHECK(zero_volt_psi(config) == Approx(-14.5038).margin(0.001));
  CHECK_FALSE(zero_volt_vents(config));
  CHECK(config.regulator.rest.value() == Approx(1.0));
  named.push_back({"dead_man.blind", "'warn'"});  // nothing else would vent
  CHECK(tests::file_refusal([&] { (void)reads(named); }).id == "TB-FILE-VALUE");
  CHECK(tests::file_refusal([&] {  // of a module that reaches 0 to 10 V
          (void)reads({{"regulator.span_v", "[-10, 10]"}, {"regulator.relief", "'valve'"}});
        })
            .id == "TB-FILE-VALUE");
  for (const char* live_zero : {"[1, 5]", "[2, 10]", "[0, 5]"}) {  // below its span a regulator stays at the low end
    const BenchConfig sound = reads({{"regulator.span_v", live_zero}});
    CHECK(zero_volt_psi(sound) == 0.0);
    CHECK(sound.regulator.rest.value() == 0.0);
  }
  CHECK(zero_volt_vents(reads({{"limits.safe_psi", "0.2"}})));
  for (const char* ordinary : {"[0, 6]", "[-0.01, 9]"})  // the zero is within safe_psi
    CHECK(zero_volt_vents(reads({{"regulator.span_bar", ordinary}})));
}

TEST_CASE("dates are refused unless they are dates, each at its key") {
  for (const char* table : {"reference", "force", "stage"}) {
    for (const char* key : {"due", "calibrated"}) {
      const std::string dotted = fmt::format("{}.{}", table, key);
      for (const char* no_date : {"\"31.01.2025\"", "\"soon\"", "\"2025-02-30\"", "\"2025-01-31T00:00:00Z\""}) {
        refused({dotted, no_date});
      }
    }
  }
  refused({"force.due", "20250131"});
  const tests::Refusal dated = tests::refusal_of(tests::bench_text("simulated") + "due = \"31.01.2025\"\n", {});
  CHECK_THAT(dated.where, Catch::Contains("b.toml:12:") && Catch::Contains("reference.due"));
  const BenchConfig config =
      read_bench(kBench, {{"reference.calibrated", "\"2025-01-31\""}, {"reference.due", "2026-01-31"}});
  CHECK(config.reference_stated.calibrated == "2025-01-31");
  CHECK(config.reference_stated.due == "2026-01-31");  // TOML's own date
  CHECK_THROWS_AS(read_bench(kBench, {{"force.calibrated", "2026-01-31"}, {"force.due", "2026-01-31"}}), FileError);
}

TEST_CASE("force sensor and stage take certificate, dates and U, and config knows them") {
  const BenchConfig config = read_bench(kBench, {{"force.certificate", "F-1"},
                                                 {"force.expanded_uncertainty_n", "0.1"},
                                                 {"stage.certificate", "Z-1"},
                                                 {"stage.due", "\"2030-01-31\""},
                                                 {"stage.expanded_uncertainty_mm", "0.02"}});
  CHECK(config.force->stated.certificate == "F-1");
  CHECK(config.force->stated.expanded_uncertainty == 0.1);
  CHECK(config.stage->stated.due == "2030-01-31");
  CHECK(config.stage->stated.expanded_uncertainty == 0.02);
  std::set<std::string> keys;
  for (const sequences::Setting& setting : config.settings) keys.insert(setting.key);
  for (const char* table : {"reference", "force", "stage"})
    for (const char* key : {"certificate", "calibrated", "due"}) CHECK(keys.contains(fmt::format("{}.{}", table, key)));
  CHECK(keys.contains("force.expanded_uncertainty_n"));
  CHECK(keys.contains("stage.expanded_uncertainty_mm"));
  CHECK(tests::file_refusal([] {
          (void)read_bench(kBench, {{"force.expanded_uncertainty_psi", "0.1"}});
        }).id == "TB-FILE-KEY");
}

TEST_CASE("a bench that drives hardware is refused until it is filled in, a simulated one is only named") {
  const BenchConfig rig = read_bench(find_config("paper-rig.example.toml"), {});
  const std::vector<std::string> places = placeholders_of(rig);
  CHECK(places.size() >= 8);
  CHECK(std::any_of(places.begin(), places.end(), [](const std::string& place) {
    return place.find("reference.certificate (") == 0 && place.find("paper-rig.example.toml:") != std::string::npos;
  }));
  try {
    refuse_placeholders(rig);
    FAIL("accepted");
  } catch (const Error& error) {
    CHECK(error.id() == "TB-BENCH-FILL-IN");
    CHECK(error.code() == ExitCode::kUsage);
    CHECK_THAT(error.what(), Catch::Contains("stage.x.serial") && Catch::Contains("regulator.serial"));
    CHECK_FALSE(error.remedy().empty());
  }
  std::vector<sequences::Override> filled;
  for (const std::string& place : places) filled.push_back({place.substr(0, place.find(' ')), "\"\""});
  CHECK_NOTHROW(refuse_placeholders(read_bench(find_config("paper-rig.example.toml"), filled)));
  const BenchConfig simulated = read_bench(kBench, {{"reference.certificate", "FILL-IN"}});
  CHECK_NOTHROW(refuse_placeholders(simulated));
  CHECK(placeholders_of(simulated) == std::vector<std::string>{"reference.certificate (--set)"});
}

TEST_CASE("an irregular, overlong or unreadable file is refused wherever a document is read") {
  const auto accepted = [](const std::string& path) {
    const tests::Refusal refusal = tests::file_refusal([&] { (void)sequences::TomlDocument::from_file(path); });
    if (refusal.id != "accepted") CHECK((refusal.id == "TB-FILE-MISSING" && refusal.where == path));
    return refusal.id == "accepted";
  };
  for (const char* odd : {"/dev/zero", "/dev", "/proc/self/mem"}) CHECK_FALSE(accepted(odd));
  CHECK_THROWS_AS(read_bench(find_config(std::string(300, 'a')), {}), FileError);
  const tests::TemporaryFolder folder;
  REQUIRE(mkfifo(folder.path("pipe").c_str(), 0600) == 0);
  CHECK_FALSE(accepted(folder.path("pipe")));
  tests::write_file(folder.path("long.toml"), std::string(16'000'001, '\n'));
  CHECK_FALSE(accepted(folder.path("long.toml")));
  tests::write_file(folder.path("fits.toml"), std::string(15'999'999, '\n'));
  CHECK(accepted(folder.path("fits.toml")));
}

TEST_CASE("a NUL in a value does not truncate the message") {
  try {
    (void)sequences::TomlDocument::from_text("a = \"x\\u0000y\"\n", "t").root().word("a", {"z"});
    FAIL("accepted");
  } catch (const FileError& error) {
    CHECK_THAT(error.what(), Catch::Contains("x\\x00y"));
  }
}

TEST_CASE("a complaint about an overridden value names --set") {
  const tests::Refusal refusal = tests::file_refusal([] { (void)read_bench(kBench, {{"limits.comand_psi", "3"}}); });
  CHECK_THAT(refusal.where, Catch::Contains("--set limits.comand_psi"));
  CHECK_THAT(refusal.remedy, Catch::Contains("command_psi"));
}

TEST_CASE("dead-man setting blind = warn is accepted only for a module with its own watchdog") {
  CHECK(read_bench(kBench, {}).dead_man.blind_ends);
  CHECK_FALSE(read_bench(kBench, {{"dead_man.blind", "\"warn\""}}).dead_man.blind_ends);
  refused({"dead_man.blind", "\"perhaps\""});
  std::string text = read_bench(kBench, {}).text;
  text.erase(text.find("watchdog_ms"), text.find('\n', text.find("watchdog_ms")) - text.find("watchdog_ms"));
  const sequences::Override module{"module.profile", "\"advantech-adam-6024\""};
  CHECK(parse_bench(text, "bench.toml", {module}).watchdog_s == 0.0);
  CHECK_THROWS_AS(parse_bench(text, "bench.toml", {module, {"dead_man.blind", "\"warn\""}}), FileError);
}

TEST_CASE("seeds of the command line take precedence over those of the file") {
  const BenchConfig config = read_bench(kBench, {}, {42, 43});
  CHECK(config.simulation->plant.seed == 42);
  CHECK(config.simulation->plant.specimen.sensor_seed == 43);
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

TEST_CASE("a pressure typed in another unit is refused with both what it is and what was typed") {
  try {
    (void)bench_with("limits.trip_psi=9bar");
    FAIL("accepted");
  } catch (const FileError& error) {
    CHECK_THAT(error.what(), Catch::Contains("130.534") && Catch::Contains("9bar") && Catch::Contains("60 to 110"));
    CHECK_THAT(error.where(), Catch::Contains("--set limits.trip_psi"));
  }
  CHECK(bench_with("limits.trip_psi=450kPa").limits.trip_psi == Approx(65.267).epsilon(1e-4));
}
