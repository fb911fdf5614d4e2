// No table of any configuration file takes a key that it does not know, and each file says of which schema it is.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "bench/config/config_laboratory.h"
#include "bench/config/config_profile.h"
#include "bench/config/operator_profile.h"
#include "tests/bench/config/bench_text.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

std::string id_with(const std::string& text, const Changes& changes) { return refusal_of(text, changes).id; }

}  // namespace

TEST_CASE("strict tables: each table of a bench file refuses a key that it does not know") {
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

TEST_CASE("strict tables: channels are counted where a module has them, a watchdog's time where it can be set") {
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

TEST_CASE("strict tables: module profiles and corrections in files of their own") {
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

TEST_CASE("strict tables: sensor types, limits, laboratory and profile") {
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

TEST_CASE("strict tables: a profile that is a folder or has no name of a shipped one") {
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
