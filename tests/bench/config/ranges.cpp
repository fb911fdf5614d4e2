// Numbers that a rig is driven by lie in a stated range, which the refusal of a number far outside names. The others'
// stand in docs/reference-keys.md alone.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "analysis/statistics/uncertainty/reference_uncertainty.h"
#include "bench/config/config_calibration.h"
#include "bench/config/config_laboratory.h"
#include "bench/config/config_profile.h"
#include "bench/config/operator_profile.h"
#include "bench/rig/device_records.h"
#include "tests/bench/config/bench_text.h"
#include "tests/support/process.h"
#include "tests/support/refusal.h"

using namespace tactbench;
using tests::Changes;

namespace {

struct Range {
  const char *key, *range;
};

const std::string kSimulated = tests::bench_text("simulated");

void check_ranges(const Changes& before, const std::string& table, const std::vector<Range>& ranges) {
  for (const Range& range : ranges) {
    INFO(table << range.key);
    Changes changes = before;
    changes.push_back({table + range.key, "1e300"});
    CHECK_THAT(tests::refusal_of(kSimulated, changes).remedy, Catch::EndsWith(std::string(" ") + range.range));
  }
}

}  // namespace

TEST_CASE("config ranges: the refusal of a number that drives the rig names its range") {
  REQUIRE(tests::bench_accepts(kSimulated, {}));
  check_ranges({}, "limits.",
               {{"command_psi", "1 to 100"},
                {"trip_psi", "60 to 110"},
                {"safe_psi", "0.1 to 1"},
                {"disagreement_psi", "0.1 to 50"},
                {"disagreement_s", "0.2 to 60"},
                {"vent_timeout_s", "1 to 120"},
                {"rate_psi_per_s", "0.01 to 200"},
                {"step_psi", "0.01 to 100"},
                {"stale_s", "0.1 to 10"},
                {"contact_n", "0.05 to 5"},
                {"clear_z_mm", "0 to 1000"}});
  CHECK(tests::bench_accepts(kSimulated, {{"limits.force_n", "[1e-9, 5, 100]"}}));
  for (const char* no_limit : {"[5, 5]", "[5, 5, 35, 35]", "[0, 5, 35]", "[5, 0, 35]", "[5, 5, 100.1]"})
    CHECK_FALSE(tests::bench_accepts(kSimulated, {{"limits.force_n", no_limit}}));
  check_ranges({}, "dead_man.",
               {{"timeout_ms", "100 to 5000"}, {"progress_ms", "250 to 30000"}, {"back_off_mm", "0 to 50"}});
  check_ranges({}, "settling.",
               {{"band_psi", "0.01 to 5"},
                {"slope_psi_per_s", "0.01 to 100"},
                {"poll_s", "0.01 to 0.5"},
                {"trace_s", "0.05 to 10"},
                {"landing_s", "0 to 10"},
                {"timeout_s", "1 to 600"}});
  check_ranges({{"bench.simulator", "external"}}, "bench.", {{"rate", "0.1 to 100"}});
  check_ranges({}, "module.",
               {{"watchdog_ms", "500 to 60000"},
                {"outputs", "1 to 64"},
                {"inputs", "1 to 60"},
                {"port", "0 to 65535"},
                {"unit", "0 to 255"},
                {"response_timeout_ms", "10 to 10000"},
                {"dump_coil", "-1 to 65535"}});
  check_ranges(
      {{"module.transport", "rtu"}}, "module.",
      {{"baud", "110 to 921600"}, {"stop_bits", "1 to 2"}, {"unit", "1 to 247"}, {"max_reply_delay_ms", "1 to 60000"}});
  check_ranges({{"input_module.profile", "beckhoff-ek9000"}}, "input_module.", {{"unit", "0 to 247"}});
  check_ranges({}, "regulator.",
               {{"output_channel", "0 to 63"}, {"feedback_channel", "0 to 63"}, {"feed_interval_ms", "50 to 500"}});
  check_ranges({}, "reference.",
               {{"channel", "0 to 63"},
                {"expanded_uncertainty_psi", "0 to 10"},
                {"drift_psi", "0 to 10"},
                {"resolution_psi", "0 to 10"}});
  check_ranges({}, "stage.",
               {{"reply_timeout_ms", "20 to 10000"},
                {"poll_interval_ms", "20 to 1000"},
                {"expanded_uncertainty_mm", "0 to 10"}});
  for (const char* axis : {"stage.x.", "stage.y.", "stage.z."})
    check_ranges({}, axis,
                 {{"device", "1 to 254"},
                  {"device_id", "1 to 99999"},
                  {"low_mm", "0 to 1000"},
                  {"high_mm", "0 to 1000"},
                  {"maximum_speed_mm_per_s", "0.001 to 30"},
                  {"home_timeout_s", "1 to 600"}});
  check_ranges({}, "force.",
               {{"expanded_uncertainty_n", "0 to 10"},
                {"overload_share", "0.05 to 1"},
                {"records_per_reading", "1 to 1000"},
                {"port", "0 to 65535"},
                {"http_port", "0 to 65535"},
                {"reply_timeout_ms", "10 to 10000"}});
}

// No table of any configuration file takes a key that it does not know, and each file says of which schema it is.

using namespace tactbench::tests;

namespace {

std::string id_with(const std::string& text, const Changes& changes) { return refusal_of(text, changes).id; }

}  // namespace

TEST_CASE("strict tables: each table of a bench file rejects an unknown key") {
  const std::string simulated = bench_text("simulated"), hardware = bench_text("hardware");
  const auto strict = [](const std::string& text, Changes changes, const std::string& table) {
    INFO(table);
    changes.push_back({table + "oddly", "1"});
    CHECK(id_with(text, changes) == "TB-FILE-KEY");
  };
  for (const char* table : {"",
                            "bench.",
                            "limits.",
                            "dead_man.",
                            "settling.",
                            "module.",
                            "regulator.",
                            "reference.",
                            "environment.",
                            "scanner.",
                            "stage.",
                            "stage.x.",
                            "stage.y.",
                            "stage.z.",
                            "force.",
                            "simulation.",
                            "simulation.chamber.",
                            "simulation.contact.",
                            "simulation.front_end.",
                            "simulation.effects.",
                            "simulation.wire_faults."})
    strict(simulated, {}, table);
  strict(simulated, {{"reference.gauge.unit", "2"}, {"reference.gauge.address", "7"}}, "reference.gauge.");
  strict(simulated,
         {{"reference.correction.reading_psi", "[0]"},
          {"reference.correction.correction_psi", "[0]"},
          {"reference.correction.expanded_uncertainty_psi", "[0]"}},
         "reference.correction.");
  for (const char* kind : {"digital", "net"}) strict(simulated, {{"force.kind", kind}}, "force.");
  for (const char* kind : {"hid", "frame-source"}) strict(simulated, {{"scanner.kind", kind}}, "scanner.");
  strict(hardware, {{"scanner.kind", "daqmx"}}, "scanner.");
  strict(hardware, {{"force.kind", "daq"}, {"force.calibration_file", "f"}}, "force.tool.");
  strict(simulated,
         {{"module.profile", "moxa-iologik-e1241"},
          {"input_module.profile", "moxa-iologik-e1240"},
          {"input_module.unit", "2"}},
         "input_module.");
  for (const auto& [list, row] :
       {std::pair<std::string, std::string>("environment.sensor", "quantity = 'supply_bar', unit = 2, address = 3"),
        std::pair<std::string, std::string>("simulation.defect", "kind = 'dead', row = 1, column = 2"),
        std::pair<std::string, std::string>("simulation.faults", "kind = 'leak'")}) {
    INFO(list);
    CHECK(id_with(simulated, {{list, "[{" + row + "}]"}}) == "accepted");
    CHECK(id_with(simulated, {{list, "[{" + row + ", oddly = 1}]"}}) == "TB-FILE-KEY");
  }
}

TEST_CASE("bench file: channel counts need as many channels in the module, a watchdog time a settable watchdog") {
  const std::string text = bench_text("simulated");
  const Changes pair{{"module.profile", "moxa-iologik-e1241"},
                     {"input_module.profile", "moxa-iologik-e1240"},
                     {"input_module.unit", "2"}};
  const auto with = [&](const char* key, const char* value) {
    Changes changes = pair;
    changes.push_back({key, value});
    return id_with(text, changes);
  };
  CHECK(with("module.outputs", "3") == "accepted");
  CHECK(with("input_module.inputs", "3") == "accepted");
  CHECK(with("module.inputs", "3") == "TB-FILE-KEY");
  CHECK(with("input_module.outputs", "3") == "TB-FILE-KEY");
  Changes counted = pair;
  counted.push_back({"module.outputs", "3"});
  counted.push_back({"input_module.inputs", "5"});
  const bench::BenchConfig config = bench::parse_bench(text, "b.toml", counted);
  CHECK(config.module.profile.outputs.channels == 3);
  CHECK(config.input_module->profile.inputs.channels == 5);
  CHECK(config.input_module->endpoint.unit == 2);
  const TemporaryFolder folder;
  for (const int address : {-1, 0, 1}) {
    write_file(folder.path("p.toml"),
               "schema = 1\nmodel = \"m\"\ntransport = \"tcp\"\n[inputs]\nchannels = 2\n[outputs]\nchannels = 1\n"
               "[fail_safe]\nwatchdog_address = " +
                   std::to_string(address) + "\n");
    const std::string profile = "\"" + folder.path("p.toml") + "\"";
    const std::string said = id_with(text, {{"module.profile", profile}, {"module.watchdog_ms", "1700"}});
    CHECK((said == "accepted") == (address >= 0));
    if (address >= 0)
      CHECK(bench::parse_bench(text, "b.toml", {{"module.profile", profile}, {"module.watchdog_ms", "1700"}})
                .watchdog_s == 1.7);
  }
}

TEST_CASE("strict tables: module profile and correction files reject unknown keys and other schemas") {
  const TemporaryFolder folder;
  const std::string path = folder.path("p.toml");
  const auto said = [&](const std::string& text) {
    write_file(path, text);
    return file_refusal([&] { (void)bench::read_module_profile(path); }).id;
  };
  const std::string head = "schema = 1\nmodel = \"m\"\ntransport = \"tcp\"\n", in = "[inputs]\nchannels = 1\n",
                    out = "[outputs]\nchannels = 1\n", safe = "[fail_safe]\n",
                    layer = "[[fail_safe.layer]]\ntext = \"vents\"\n";
  CHECK(said(head + in + out + safe + layer) == "accepted");
  CHECK(said(head + "oddly = 1\n" + in) == "TB-FILE-KEY");
  for (const std::string& table : {in, out, safe, layer}) CHECK(said(head + table + "oddly = 1\n") == "TB-FILE-KEY");
  for (const char* schema : {"0", "2"})
    CHECK(said("schema = " + std::string(schema) + head.substr(10) + in) == "TB-FILE-VALUE");

  const std::string correction =
      "reading_psi = [0, 30]\ncorrection_psi = [0.1, 0.2]\nexpanded_uncertainty_psi = [0.05, 0.06]\n";
  const auto corrected_by = [&](const std::string& text) {
    write_file(folder.path("c.toml"), text);
    return bench::parse_bench(bench_text("simulated"), folder.path("b.toml"), {{"reference.correction_file", "c.toml"}})
        .reference_correction;
  };
  const devices::PressureCorrection found = corrected_by("schema = 1\ncoverage_factor = 3\n" + correction);
  CHECK(found.reading_psi == std::vector<double>{0.0, 30.0});
  CHECK(found.correction_psi == std::vector<double>{0.1, 0.2});
  CHECK(found.expanded_uncertainty_psi == std::vector<double>{0.05, 0.06});
  CHECK(found.coverage_factor == 3.0);
  CHECK(corrected_by("schema = 1\n" + correction).coverage_factor == 2.0);
  for (const char* head_line : {"", "schema = 0\n", "schema = 2\n", "schema = 1\noddly = 1\n"})
    CHECK(file_refusal([&] { (void)corrected_by(head_line + correction); }).id != "accepted");
}

TEST_CASE("strict tables: sensor type, limits, laboratory and profile files reject unknown keys") {
  const std::string sensor = "name = \"s\"\nrows = 2\ncolumns = 3\nfull_scale = \"highest mean output of the run\"\n";
  const std::string limits =
      "name = \"l\"\nmean_compensation_error_psi = 1\nworst_taxel_error_psi = 3\ndistance_of_mean_percent_fs = 1.5\n"
      "unfit_taxels = 0\n";
  struct Row {
    const char* what;
    std::string text;
    std::function<void(const std::string&)> read;
  };
  const std::vector<Row> rows = {
      {"sensor", sensor, [](const std::string& text) { (void)bench::parse_sensor_type(text, "f"); }},
      {"limits", limits, [](const std::string& text) { (void)bench::parse_limits(text, "f"); }},
      {"laboratory", "place = \"here\"\n", [](const std::string& text) { (void)bench::parse_laboratory(text, "f"); }},
      {"profile", "db = \"x\"\n", [](const std::string& text) { (void)bench::parse_operator_profile(text, "f"); }},
      {"bench", bench_text("simulated").substr(11),
       [](const std::string& text) { (void)bench::parse_bench(text, "f", {}); }},
  };
  for (const Row& row : rows) {
    INFO(row.what);
    const auto id = [&](const std::string& head) { return file_refusal([&] { row.read(head + row.text); }).id; };
    CHECK(id("schema = 1\n") == "accepted");
    CHECK(id("schema = 1\noddly = 1\n") == "TB-FILE-KEY");
    for (const char* head : {"schema = 0\n", "schema = 2\n"}) CHECK(id(head) == "TB-FILE-VALUE");
  }
  CHECK(file_refusal([] { (void)bench::parse_operator_profile("db = \"x\"\n", "f"); }).id == "accepted");
  for (const char* row :
       {"[[mpe]]\npressure_psi = 2\nmpe_psi = 1\n", "[[mismatch]]\npressure_psi = 2\nstd_percent_fs = 1\n"})
    CHECK(file_refusal([&] { (void)bench::parse_limits("schema = 1\n" + limits + row + "oddly = 1\n", "f"); }).id ==
          "TB-FILE-KEY");
  CHECK(file_refusal([] {
          (void)bench::parse_laboratory("schema = 1\n[[instrument]]\nserial = \"1\"\nodd = 1\n", "f");
        }).id == "TB-FILE-KEY");
}

TEST_CASE("strict tables: a module profile that is a folder or has no shipped name is rejected") {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path("x.toml"));
  for (const std::string& name : {folder.path("x.toml"), std::string("zzzzzzzzzzzzzzzz"), std::string("generik")})
    CHECK(file_refusal([&] { (void)bench::read_module_profile(name); }).id == "TB-MODULE-PROFILE");
  const Refusal near = file_refusal([] { (void)bench::read_module_profile("generik"); });
  CHECK(near.where == "[module] profile");
  CHECK_THAT(near.remedy, Catch::Contains("'generic'") && Catch::Contains("advantech-adam-6024"));
  const std::vector<std::string> names = bench::shipped_profiles();
  CHECK(std::is_sorted(names.begin(), names.end()));
}

// What a bench file states of calibrations: dates, limits and what the simulated instruments' errors are drawn within;
// files of sensor types and limits, number by number.

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

TEST_CASE("stated values: the due date is not before the calibration, certificate_covers needs its further values") {
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

TEST_CASE("stated values: a hardware bench must state what each certificate covers, all missing ones are reported") {
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
  // Values still to be filled in come first.
  const BenchConfig open = hardware_bench({{"reference.certificate", "FILL-IN"}, {"bench.location", "FILL-IN"}});
  CHECK(placeholders_of(open) == Words{"bench.location (--set)", "reference.certificate (--set)"});
  CHECK(covers_refusal(open) == "TB-BENCH-FILL-IN");
}

TEST_CASE("stated values: the error limits of simulated instruments come from the stated values") {
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

TEST_CASE(
    "stated values: the reference chain becomes limits, a run stored without them is read with the parts missing") {
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
