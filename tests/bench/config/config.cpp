#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "analysis/error.h"
#include "bench/common/error.h"
#include "bench/common/overrides.h"
#include "bench/config/config.h"
#include "bench/config/config_calibration.h"
#include "db/run_store.h"
#include "devices/device.h"
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

TEST_CASE("config: the shipped bench, sensor and limits files are read without errors") {
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

TEST_CASE("limits: unknown keys are rejected, the decision rule is read by name") {
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

TEST_CASE("config: invalid bench values are rejected with place and remedy") {
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

TEST_CASE("config: if 0 V does not vent the regulator, a relief device must be named, and 0 psi needs a voltage") {
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

TEST_CASE("config: invalid dates are rejected, and the error names the key") {
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

TEST_CASE("config: force sensor and stage accept certificate, dates and U, and list them as settings") {
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

TEST_CASE("config: placeholders in the bench file of a hardware bench are rejected, of a simulated bench only listed") {
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

TEST_CASE("config: irregular, too large or unreadable files are rejected by every document reader") {
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

TEST_CASE("config: a NUL in a value does not truncate the error message") {
  try {
    (void)sequences::TomlDocument::from_text("a = \"x\\u0000y\"\n", "t").root().word("a", {"z"});
    FAIL("accepted");
  } catch (const FileError& error) {
    CHECK_THAT(error.what(), Catch::Contains("x\\x00y"));
  }
}

TEST_CASE("config: an error in an overridden value names --set") {
  const tests::Refusal refusal = tests::file_refusal([] { (void)read_bench(kBench, {{"limits.comand_psi", "3"}}); });
  CHECK_THAT(refusal.where, Catch::Contains("--set limits.comand_psi"));
  CHECK_THAT(refusal.remedy, Catch::Contains("command_psi"));
}

TEST_CASE("config: dead-man setting blind = warn is accepted only for a module with its own watchdog") {
  CHECK(read_bench(kBench, {}).dead_man.blind_ends);
  CHECK_FALSE(read_bench(kBench, {{"dead_man.blind", "\"warn\""}}).dead_man.blind_ends);
  refused({"dead_man.blind", "\"perhaps\""});
  std::string text = read_bench(kBench, {}).text;
  text.erase(text.find("watchdog_ms"), text.find('\n', text.find("watchdog_ms")) - text.find("watchdog_ms"));
  const sequences::Override module{"module.profile", "\"advantech-adam-6024\""};
  CHECK(parse_bench(text, "bench.toml", {module}).watchdog_s == 0.0);
  CHECK_THROWS_AS(parse_bench(text, "bench.toml", {module, {"dead_man.blind", "\"warn\""}}), FileError);
}

TEST_CASE("config: seeds of the command line outrank those of the file") {
  const BenchConfig config = read_bench(kBench, {}, {42, 43});
  CHECK(config.simulation->plant.seed == 42);
  CHECK(config.simulation->plant.specimen.sensor_seed == 43);
}

TEST_CASE("config: the example file of the paper rig is read without errors, and configures hardware only") {
  const BenchConfig config = read_bench(find_config("paper-rig.example.toml"), {});
  CHECK(config.origin == devices::Origin::kHardware);
  CHECK_FALSE(config.in_process);
  CHECK_FALSE(config.simulation);
  CHECK(config.scanner.kind == devices::ScannerKind::kDaqmx);
  REQUIRE(config.stage);
  CHECK(config.stage->options.axes[2].device_id == 5082);
  REQUIRE(config.force);
  CHECK(config.force->kind == devices::ForceKind::kNet);
  CHECK(config.force->net.port == 49152);
}

TEST_CASE("config: a rejected pressure in another unit is reported in psi and as typed") {
  try {
    (void)bench_with("limits.trip_psi=9bar");
    FAIL("accepted");
  } catch (const FileError& error) {
    CHECK_THAT(error.what(), Catch::Contains("130.534") && Catch::Contains("9bar") && Catch::Contains("60 to 110"));
    CHECK_THAT(error.where(), Catch::Contains("--set limits.trip_psi"));
  }
  CHECK(bench_with("limits.trip_psi=450kPa").limits.trip_psi == Approx(65.267).epsilon(1e-4));
}

// Which values a bench file may not combine, and which it may.

using tests::bench_accepts;
using tests::bench_text;
using tests::Changes;
using tests::simulated_bench;

namespace {

Changes with_change(Changes changes, const char* key, const char* value) {
  changes.push_back({key, value});
  return changes;
}

void check_refused_where_accepted(const std::string& text, const std::vector<Changes>& refused,
                                  const std::vector<Changes>& accepted) {
  for (const Changes& changes : refused) {
    INFO(changes.back().key << " = " << changes.back().value);
    CHECK_FALSE(bench_accepts(text, changes));
  }
  for (const Changes& changes : accepted) {
    INFO(changes.back().key << " = " << changes.back().value);
    CHECK(bench_accepts(text, changes));
  }
}

}  // namespace

TEST_CASE("config: contradictions between tables of a bench file are rejected") {
  const Changes both{{"module.profile", "moxa-iologik-e1241"}, {"input_module.profile", "moxa-iologik-e1240"}};
  std::vector<Changes> refused = {{{"bench.rate", "2"}},
                                  {{"module.watchdog_ms", "500"}, {"regulator.feed_interval_ms", "301"}},
                                  {{"module.profile", "generic"}, {"module.watchdog_ms", "1000"}},
                                  {{"module.transport", "rtu"}},
                                  {{"module.profile", "waveshare-analog-output-8ch-b"}},
                                  {{"module.profile", "moxa-iologik-e1240"}},
                                  {{"module.profile", "moxa-iologik-e1241"}},
                                  both,
                                  {{"input_module.profile", "moxa-iologik-e1241"}, {"input_module.unit", "2"}}};
  for (const char* key : {"serial_port", "baud", "parity", "stop_bits", "max_reply_delay_ms"})
    refused.push_back({{std::string("module.") + key, "1"}});
  const Changes unit = with_change(both, "input_module.unit", "2");
  check_refused_where_accepted(bench_text("simulated"), refused,
                               {{{"module.watchdog_ms", "500"}, {"regulator.feed_interval_ms", "300"}},
                                {{"module.profile", "generic"}, {"regulator.feed_interval_ms", "500"}},
                                unit});
  CHECK(simulated_bench(unit).input_module->same_line);
  CHECK_FALSE(simulated_bench(with_change(both, "input_module.host", "10.0.0.9")).input_module->same_line);
  check_refused_where_accepted(
      bench_text("hardware"),
      {{{"bench.simulator", "external"}},
       {{"bench.rate", "2"}},
       {{"module.transport", "rtu"}},
       {{"module.transport", "rtu"}, {"module.serial_port", "\"\""}},
       {{"force.kind", "digital"}},
       {{"stage.x.device", "1"}},
       {{"scanner.kind", "frame-source"}},
       {{"force.kind", "daq"}, {"force.calibration_file", "f"}, {"force.tool.rotation_deg", "[1, 2]"}}},
      {{{"force.kind", "digital"}, {"force.usb_serial", "A1"}},
       {{"force.kind", "digital"}, {"force.port", "/dev/ttyUSB1"}},
       {{"stage.usb_serial", "A1"}}});
}

TEST_CASE("config: the reference can be the regulator feedback, a gauge, or a transducer with a correction") {
  const std::string text = bench_text("simulated");
  std::string dependent = text;
  dependent.erase(dependent.find("model = \"m\""));
  dependent += "independent = false\n";
  const BenchConfig config = parse_bench(dependent, "b.toml", {{"regulator.feedback_channel", "1"}});
  CHECK_FALSE(config.reference_independent);
  CHECK(config.reference.channel == 1);
  CHECK(config.reference.serial == "R");
  CHECK(config.reference.span.high.value() == config.regulator.feedback_span.high.value());
  CHECK_FALSE(bench_accepts(dependent, {{"reference.gauge.unit", "2"}}));
  const Changes gauge{{"reference.gauge.unit", "2"}, {"reference.gauge.address", "7"}};
  CHECK_FALSE(simulated_bench(gauge).reference_gauge->own_line);
  CHECK(simulated_bench(gauge).reference_gauge->endpoint.unit == 2);
  CHECK(simulated_bench(with_change(gauge, "reference.gauge.port", "5020")).reference_gauge->own_line);
  CHECK(simulated_bench(with_change(gauge, "reference.gauge.host", "10.0.0.1")).reference_gauge->own_line);
  const auto correction = [](const char* reading, const char* added, const char* uncertainty) {
    return Changes{{"reference.correction.reading_psi", reading},
                   {"reference.correction.correction_psi", added},
                   {"reference.correction.expanded_uncertainty_psi", uncertainty}};
  };
  check_refused_where_accepted(text,
                               {with_change(gauge, "reference.channel", "2"),
                                with_change(gauge, "reference.span_v", "[0, 5]"),
                                with_change(gauge, "reference.span_psi", "[0, 50]"),
                                correction("[30, 30]", "[0.1, 0.2]", "[0.05, 0.05]"),
                                correction("[0, 30, 29]", "[0, 0, 0]", "[1, 1, 1]"),
                                correction("[0, 30]", "[0.1]", "[0.05, 0.05]"),
                                correction("[0, 10, 20]", "[0, 45, 0]", "[1, 1, 1]"),
                                correction("[0, 10]", "[0, -10]", "[1, 1]"),
                                {{"reference.certificate_range_psi", "[40, 0]"}},
                                correction("[0, 30]", "[0.1, 0.2]", "[0.05]"),
                                correction("[]", "[]", "[]"),
                                with_change(correction("[0]", "[0]", "[0]"), "reference.correction_file", "f.toml")},
                               {correction("[0, 30]", "[0.1, 0.2]", "[0.05, 0.05]")});
}

// Defaults of a bench file, and what each kind of instrument and each unit in a key is read as.

using namespace std::chrono_literals;
using tests::hardware_bench;

TEST_CASE("config defaults: limits, dead-man, settling, module, regulator, reference") {
  const BenchConfig config = simulated_bench();
  std::map<std::string, std::string> taken;
  for (const sequences::Setting& setting : config.settings)
    if (setting.origin == "default") taken[setting.key] = setting.value;
  const std::pair<const char*, const char*> safety[] = {
      {"limits.command_psi", "60"},     {"limits.trip_psi", "66"},      {"limits.safe_psi", "1"},
      {"limits.disagreement_psi", "5"}, {"limits.disagreement_s", "1"}, {"limits.vent_timeout_s", "20"},
      {"limits.rate_psi_per_s", "20"},  {"limits.step_psi", "2.5"},     {"limits.stale_s", "1"},
      {"limits.contact_n", "0.5"},      {"limits.clear_z_mm", "25"},    {"dead_man.enabled", "true"},
      {"dead_man.back_off_mm", "5"},    {"dead_man.blind", "\"end\""},  {"module.dump_coil", "-1"},
      {"settling.band_psi", "0.25"},    {"settling.timeout_s", "20"},   {"reference.independent", "true"}};
  for (const auto& [key, value] : safety) {
    INFO(key);
    CHECK(taken[key] == value);
  }
  CHECK(config.limits.force_n == std::array<double, 3>{5.0, 5.0, 35.0});
  CHECK(config.dead_man.timeout_s == 0.4);
  CHECK(config.dead_man.progress_s == 1.5);
  CHECK(config.watchdog_s == 1.0);
  CHECK(config.regulator.feed_interval == 450ms);
  CHECK(config.reference.span.high.value() == 100.0);
}

TEST_CASE("config defaults: simulated plant") {
  const BenchConfig config = simulated_bench();
  CHECK(config.simulation->plant.chamber.span_psi == Approx(130.534).epsilon(1e-5));
  const BenchConfig faulty =
      simulated_bench({{"simulation.faults", "[{kind = 'leak'}, {kind = 'row_stuck', at_psi = 0}]"}});
  const auto& faults = faulty.simulation->plant.faults;
  REQUIRE(faults.size() == 2);
  CHECK(faults[0].kind == FaultKind::kLeak);
  CHECK_FALSE((faults[0].at_s || faults[0].at_psi || faults[0].at_n || faults[0].value));
  CHECK(faults[0].times == 0);
  CHECK(faults[0].lasts_s > 1e300);
  CHECK(faults[1].kind == FaultKind::kRowStuck);
  CHECK(faults[1].at_psi == 0.0);
}

TEST_CASE("config values: orientation, edges, objects and defects of the simulated sensor") {
  const auto specimen = [](const Changes& changes) { return simulated_bench(changes).simulation->plant.specimen; };
  CHECK(specimen({{"simulation.mount_turn", "turned-90"}}).mount_turn == MountTurn::kBy90);
  CHECK(specimen({{"simulation.edge_outside", "first-column"}}).edge_outside == MountEdge::kFirstColumn);
  const Changes narrow{{"scanner.rows", "8"}, {"simulation.mount_turn", "turned-90"}};
  CHECK_FALSE(tests::bench_accepts(bench_text("simulated"), narrow));
  CHECK(specimen({{"scanner.rows", "8"}}).rows == 8);
  CHECK(simulated_bench({{"simulation.contact.object", "flat"}}).simulation->plant.contact.object == Footprint::kFlat);
  const char* const kinds[] = {"dead", "stuck", "saturated", "noisy"};
  for (int i = 0; i < 4; ++i) {
    const auto defects =
        specimen({{"simulation.defect", fmt::format("[{{kind = '{}', row = 3, column = 15}}]", kinds[i])}}).defects;
    REQUIRE(defects.size() == 1);
    CHECK(static_cast<int>(defects[0].kind) == i);
    CHECK(defects[0].row == 3);
    CHECK(defects[0].column == 15);
  }
  const auto swapped =
      specimen({{"simulation.defect", "[{kind = 'swapped', row = 0, column = 1, other_row = 2, other_column = 3}]"}});
  CHECK(swapped.defects[0].kind == TaxelDefect::Kind::kSwapped);
  CHECK(swapped.defects[0].other_row == 2);
  CHECK(swapped.defects[0].other_column == 3);
}

TEST_CASE("config values: milliseconds, bar and counts are converted to the units of the devices") {
  const BenchConfig config = simulated_bench({{"dead_man.timeout_ms", "200"},
                                              {"dead_man.progress_ms", "750"},
                                              {"module.response_timeout_ms", "250"},
                                              {"module.watchdog_ms", "2000"},
                                              {"regulator.feed_interval_ms", "300"},
                                              {"regulator.span_bar", "[0, 2]"},
                                              {"scanner.frame_timeout_ms", "120"},
                                              {"stage.reply_timeout_ms", "50"},
                                              {"stage.poll_interval_ms", "60"},
                                              {"stage.y.home_timeout_s", "2.5"},
                                              {"force.reply_timeout_ms", "70"}});
  CHECK(config.dead_man.timeout_s == 0.2);
  CHECK(config.dead_man.progress_s == 0.75);
  CHECK(config.module.endpoint.response_timeout == 250ms);
  CHECK(config.watchdog_s == 2.0);
  CHECK(config.regulator.feed_interval == 300ms);
  CHECK(config.regulator.command_span.high.value() == Approx(29.00755));  // 1 bar is 14.503774 psi
  CHECK(config.regulator.feedback_span.high.value() == Approx(29.00755));
  CHECK(config.scanner.frame_timeout == 120ms);
  CHECK(config.stage->options.reply_timeout == 50ms);
  CHECK(config.stage->options.poll_interval == 60ms);
  CHECK(config.stage->options.axes[1].home_timeout == 2500ms);
  CHECK(config.force->net.reply_timeout == 70ms);
  const BenchConfig line = simulated_bench({{"module.profile", "generic"},
                                            {"module.transport", "rtu"},
                                            {"module.max_reply_delay_ms", "40"},
                                            {"module.parity", "E"},
                                            {"module.stop_bits", "2"}});
  CHECK(line.module.endpoint.max_reply_delay == 40ms);
  CHECK(line.module.endpoint.parity == 'E');
  CHECK(line.module.endpoint.stop_bits == 2);
  CHECK(line.watchdog_s == 0.0);
  const BenchConfig card = hardware_bench({{"scanner.kind", "daqmx"}, {"scanner.settle_ms", "7"}});
  CHECK(card.scanner.daqmx.settle == 7ms);
  CHECK(card.scanner.daqmx.frame_timeout == 500ms);
}

TEST_CASE("config values: kinds of instruments and terminals are read by name") {
  CHECK(simulated_bench({{"scanner.kind", "frame-source"}}).scanner.kind == devices::ScannerKind::kFrameSource);
  CHECK(simulated_bench().scanner.kind == devices::ScannerKind::kHid);
  const auto terminal = [](const char* word) {
    return hardware_bench({{"scanner.kind", "daqmx"}, {"scanner.terminal", word}}).scanner.daqmx.terminal;
  };
  CHECK(terminal("rse") == devices::DaqmxTerminal::kRse);
  CHECK(terminal("nrse") == devices::DaqmxTerminal::kNrse);
  CHECK(terminal("differential") == devices::DaqmxTerminal::kDifferential);
  CHECK(simulated_bench({{"force.kind", "net"}}).force->kind == devices::ForceKind::kNet);
  CHECK(simulated_bench({{"force.kind", "digital"}}).force->kind == devices::ForceKind::kDigital);
  CHECK(simulated_bench({{"force.kind", "digital"}, {"force.parity", "O"}}).force->address.parity == 'O');
  const BenchConfig daq = hardware_bench({{"force.kind", "daq"},
                                          {"force.calibration_file", "f.cal"},
                                          {"force.range_v", "5"},
                                          {"force.tool.displacement_mm", "[1, 2, 3]"}});
  CHECK(daq.force->kind == devices::ForceKind::kDaq);
  CHECK(daq.force->daq.tool.displacement_mm == std::array<double, 3>{1, 2, 3});
  CHECK(daq.force->daq.tool.rotation_deg == std::array<double, 3>{0, 0, 0});
  CHECK(daq.force->daq.converter_limit.value() == 5.0);
  const auto type = [](const char* word) {
    return simulated_bench(
               {{"reference.gauge.unit", "2"}, {"reference.gauge.address", "0"}, {"reference.gauge.type", word}})
        .reference_gauge->quantity.format.type;
  };
  CHECK(type("i16") == devices::RegisterType::kI16);
  CHECK(type("f32") == devices::RegisterType::kF32);
  const BenchConfig external = simulated_bench({{"bench.simulator", "external"}, {"bench.rate", "10"}});
  CHECK_FALSE(external.in_process);
  CHECK_FALSE(external.simulation);
  CHECK(external.rate == 10.0);
  CHECK(simulated_bench({{"bench.simulator", "in-process"}}).in_process);
}
