// Every verb that writes a file leaves stores alone, and files that are not its own.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <vector>

#include "tests/bench/cli/models/known_model.h"
#include "tests/support/run_recipe.h"
#include "tests/support/text.h"

using namespace tactbench::tests;

namespace {

using Words = std::vector<std::string>;

// Up and down, and a smaller loop inside.
std::string loop_table() {
  std::string text = "sequence,input,output\n";
  for (const PlaySample& sample : play_samples({0, 10, 0, 10, 4, 10, 0}, 20))
    text += "a," + std::to_string(sample.input) + "," + std::to_string(sample.output) + "\n";
  return text;
}

// A store with a run and its fit, a table and a model.
void prepare_files(const TemporaryFolder& folder) {
  begin_bench(folder);
  write_file(folder.path("t.csv"), loop_table());
  measure_small(folder);
  REQUIRE(call(folder, {"fit", "1"}).code == 0);
  REQUIRE(call(folder, {"fit", "t.csv", "--model", "mpi", "-o", "m.json"}).code == 0);
  write_file(folder.path("suite.toml"), "schema = 1\nname = \"s\"\n[[scenario]]\nname = \"a\"\nabout = \"b\"\n");
}

const std::vector<Words>& writing_verbs() {
  static const std::vector<Words> verbs = {
      {"runs", "export", "1", "-o"},
      {"runs", "export", "1", "--format", "json", "-o"},
      {"report", "1", "-o"},
      {"report", "sign", "1", "--by", "C. Chief", "-o"},
      {"report", "1", "--format", "json", "-o"},
      {"trend", "--html"},
      {"fit", "t.csv", "--model", "mpi", "-o"},
      {"model", "export", "1", "-o"},
      {"model", "adjust", "m.json", "t.csv", "--zero", "-o"},
      {"predict", "m.json", "t.csv", "-o"},
      {"compensate", "m.json", "t.csv", "-o"},
      {"selfcheck", "-o"},
      {"simulate", "--for", "0.1", "--write-bench"},
      {"demo", "-q", "-o"},
      {"nightly", "./suite.toml", "--junit"},
      {"nightly", "./suite.toml", "--metrics"},
      {"nightly", "./suite.toml", "--html"},
      {"live", "--bench", "bench.toml", "--model", "1", "--frames", "1", "--csv"},
      {"devices", "calibrate-reference", "--bench", "bench.toml", "--gauge", "G", "--uncertainty", "0.1", "-o"},
  };
  return verbs;
}

}  // namespace

TEST_CASE("output files: no verb overwrites a store, whatever its options") {
  const TemporaryFolder folder;
  prepare_files(folder);
  const std::string before = read_file(folder.path("runs.db"));
  std::filesystem::create_symlink("runs.db", folder.path("link"));
  for (const Words& verb : writing_verbs())
    for (const char* target : {"runs.db", "link"}) {
      INFO(verb[0] << " " << verb[1]);
      check_refusal(call(folder, joined(verb, {target, "--replace"})), 2, "TB-FILE-STORE");
      CHECK(read_file(folder.path("runs.db")) == before);
    }
  CHECK(std::filesystem::is_symlink(folder.path("link")));
  // init names its files itself.
  std::filesystem::create_directory(folder.path("sub"));
  std::filesystem::create_symlink("../runs.db", folder.path("sub/limits.toml"));
  check_refusal(call(folder, {"init", "sub", "--force"}), 2, "TB-FILE-STORE");
  CHECK(read_file(folder.path("runs.db")) == before);
}

TEST_CASE("output files: a verb overwrites its own earlier output, and another file only on request") {
  const TemporaryFolder folder;
  prepare_files(folder);
  const std::string target = folder.path("target");
  for (const Words& verb : writing_verbs()) {
    if (verb[0] == "devices" || verb[0] == "demo" || verb[0] == "nightly" || verb[1] == "adjust") continue;
    INFO(verb[0] << " " << verb[1]);
    if (verb == Words{"report", "sign", "1", "--by", "C. Chief", "-o"}) continue;  // once only
    const auto written = [&](bool replace) {
      return call(folder, joined(verb, replace ? Words{"target", "--replace"} : Words{"target"}));
    };
    write_file(target, "dear diary\n");
    const Finished refused = written(false);
    CHECK(refused.code == 2);
    CHECK_THAT(refused.err, Catch::Contains("[TB-FILE-EXISTS]") && Catch::Contains("--replace"));
    CHECK(read_file(target) == "dear diary\n");
    well(written(true));
    const std::string kept = read_file(target);
    CHECK(kept != "dear diary\n");
    CHECK(written(false).code == 0);  // its own kind
    std::filesystem::remove(target);
  }
}

// tactbench.toml, TACTBENCH_BENCH and TACTBENCH_DB as a person meets them.

using nlohmann::json;

namespace {

struct SetVariable {
  SetVariable(const char* variable, const char* value) : name(variable) { setenv(name, value, 1); }
  ~SetVariable() { unsetenv(name); }
  SetVariable(const SetVariable&) = delete;
  SetVariable& operator=(const SetVariable&) = delete;
  const char* name;
};

}  // namespace

TEST_CASE("profile: after init --operator, run takes bench, recipe, operator and store from the profile") {
  const TemporaryFolder folder;
  REQUIRE(call(folder, {"init", "--operator", "A. \"Q\" Person"}).code == 0);
  REQUIRE(call(folder, {"sensors", "add", "S-1"}).code == 0);
  well(call(folder, {"run", "--sensor", "S-1", "-q"}));
  const json shown = json::parse(call(folder, {"runs", "show", "1", "--json"}).out);
  CHECK(shown.at("operator") == "A. \"Q\" Person");
  REQUIRE(shown.at("recipes").size() == 3);  // of `production`
  CHECK(shown.at("recipes").at(0).at("name") == "loops");
  CHECK(call(folder, {"init", "--operator", " "}).code == 2);
}

TEST_CASE("profile: the store of the environment outranks that of the file, --db outranks both") {
  const TemporaryFolder folder;
  write_file(folder.path("tactbench.toml"), "db = \"file.db\"\n");
  const auto made = [&](const char* name) { return std::filesystem::exists(folder.path(name)); };
  REQUIRE(call(folder, {"init", "types"}).code == 0);
  const std::vector<std::string> add = {"sensors", "add", "S-1", "--type", "types/sensor.toml"};
  REQUIRE(call(folder, add).code == 0);
  CHECK(made("file.db"));
  const SetVariable db("TACTBENCH_DB", "environment.db");
  REQUIRE(call(folder, add).code == 0);
  CHECK(made("environment.db"));
  REQUIRE(call(folder, joined(add, {"--db", "typed.db"})).code == 0);
  CHECK(made("typed.db"));
  CHECK(!made("runs.db"));
}

TEST_CASE("config: --origin shows where each value of the profile comes from") {
  const TemporaryFolder folder;
  write_file(folder.path("tactbench.toml"), "operator = \"me\"\nbench = \"no-such.toml\"\n");
  const SetVariable bench("TACTBENCH_BENCH", "simulated.toml");
  const Finished shown = call(folder, {"config", "--origin"});
  INFO(shown.err);
  REQUIRE(shown.code == 0);
  CHECK_THAT(shown.out, Catch::Contains("profile.bench = \"simulated.toml\"") && Catch::Contains("# TACTBENCH_BENCH") &&
                            Catch::Contains("profile.operator = \"me\"") && Catch::Contains("# tactbench.toml:1"));
  const json list = json::parse(call(folder, {"config", "--json"}).out).at("profile");
  REQUIRE(list.size() == 2);
  CHECK(list.at(0) == json{{"key", "profile.bench"}, {"value", "\"simulated.toml\""}, {"origin", "TACTBENCH_BENCH"}});
}

TEST_CASE("profile: an invalid file is an error with its line, but help and stopping a run still work") {
  const TemporaryFolder folder;
  write_file(folder.path("tactbench.toml"), "bench = \"simulated.toml\"\noperater = \"me\"\n");
  const Finished list = call(folder, {"runs", "list"});
  CHECK(list.code == 2);
  CHECK_THAT(list.err,
             Catch::Contains("[TB-FILE-KEY]") && Catch::Contains("tactbench.toml:2") && Catch::Contains("'operator'"));
  CHECK(call(folder, {"runs", "list", "--help"}).code == 0);
  for (const char* command : {"pause", "stop", "panic"})
    CHECK_THAT(call(folder, {command}).err, Catch::Contains("[TB-RUN-NOT-LIVE]"));
}

TEST_CASE("profile: judge uses its limits and reports the file, fit uses no limits") {
  const TemporaryFolder folder;
  begin_bench(folder, small_loop_text(10, 2));
  write_file(folder.path("hard.toml"), limits_text("simple", 0.000001));
  for (const char* seed : {"1", "2"}) measure_small(folder, seed);
  write_file(folder.path("tactbench.toml"), "limits = \"hard.toml\"\n");
  well(call(folder, {"fit", "1"}));
  CHECK_THAT(well(call(folder, {"fit", "1"}, {"judge", "1", "2"}), 1).err, Catch::Contains("tactbench.toml:1"));
  well(call(folder, {"report", "1"}), 1);
}

// --units as a person meets it: every verb that prints pressures, the profile's key, typed pressures, and what stays
// psi.

namespace {

// A number with psi behind it, or psi as the unit of a column.
bool shows_psi(const std::string& text) { return std::regex_search(text, std::regex(R"(\d psi\b|, psi\b)")); }

}  // namespace

TEST_CASE("units: plan, recipes and errors are in kPa or bar, JSON is unchanged") {
  const TemporaryFolder folder;
  const std::vector<std::string> plan = {"plan", "production", "--steps", "--all"};
  const std::string kpa = call(folder, joined(plan, {"--units", "kpa"})).out;
  CHECK_THAT(kpa, Catch::Contains(" 413.7 kPa") && Catch::Contains("455.1 kPa"));
  CHECK_FALSE(shows_psi(kpa));
  CHECK(call(folder, joined(plan, {"--json"})).out == call(folder, joined(plan, {"--json", "--units", "bar"})).out);
  CHECK(call(folder, {"plan", "production", "--set", "recipe.conditioning.peak=5bar", "--units", "bar"}).code == 2);
  const Finished wrong = call(folder, joined(plan, {"--units", "mbar"}));
  CHECK(wrong.code == 2);
  CHECK_THAT(wrong.err, Catch::Contains("--units"));
}

TEST_CASE("units: the unit of the profile is used for a run, its verdicts and its report") {
  const TemporaryFolder folder;
  REQUIRE(call(folder, {"init", "--operator", "tester"}).code == 0);
  write_file(folder.path("tactbench.toml"), read_file(folder.path("tactbench.toml")) + "units = \"kPa\"\n");
  write_file(folder.path("small.toml"), small_loop_text(20, 2));
  REQUIRE(call(folder, {"sensors", "add", "S-1"}).code == 0);
  for (const char* seed : {"1", "2"}) {
    const Finished run =
        call(folder, {"run", "small.toml", "--sensor", "S-1", "-q", "--seed", seed, "--set", "settling.band_psi=2kPa"});
    REQUIRE(run.code == 0);
    CHECK_THAT(run.out, Catch::Contains("vented") && Catch::Contains("kPa"));
    CHECK_FALSE(shows_psi(run.out));
  }
  const Finished fit = call(folder, {"fit", "1", "-q"}, {"judge", "1", "2", "--all"});
  CHECK_THAT(fit.out, Catch::Contains("8.27 kPa") && Catch::Contains("275.8 kPa"));
  CHECK_FALSE(shows_psi(fit.out));
  CHECK_THAT(call(folder, {"runs", "show", "1"}).out, Catch::Contains("0.345 kPa"));

  // The page: kPa with psi behind, or the other way round, of one number; the data do not change.
  const auto report = [&](const char* unit, const char* file) {
    return json::parse(call(folder, {"report", "1", "-o", file, "--json", "--units", unit}).out).at("number");
  };
  const json number = report("kPa", "kpa.html");
  CHECK(report("psi", "psi.html") == number);
  CHECK(report("bar", "bar.html") == number);
  const std::string kpa = read_file(folder.path("kpa.html")), psi = read_file(folder.path("psi.html"));
  const auto data = [](const std::string& page) { return page.substr(page.find("id=\"report-data\">")); };
  CHECK(data(kpa) == data(psi));
  write_file(folder.path("tactbench.toml"), "units = \"atm\"\n");
  CHECK(call(folder, {"plan", "production"}).code == 2);
}

TEST_CASE("units: devices test and resume print kPa, with values equal to those in psi") {
  const TemporaryFolder folder;
  REQUIRE(call(folder, {"init", "--operator", "tester"}).code == 0);
  REQUIRE(call(folder, {"sensors", "add", "S-1"}).code == 0);
  write_file(folder.path("small.toml"), small_loop_text(20, 2));
  const auto check = [&](const char* unit) {
    return call(folder, {"devices", "test", "--standard", "S-1", "--recipe", "small.toml", "-q", "--units", unit}).out;
  };
  // One number behind a figure's name.
  const auto figure = [](const std::string& text, const std::string& name) {
    const std::size_t at = text.find("\n" + name + " ");
    REQUIRE(at != std::string::npos);
    return std::stod(text.substr(at + name.size() + 2));
  };
  const std::string kpa = check("kPa"), psi = check("psi");
  CHECK(kpa.find("psi") == std::string::npos);
  for (const std::string name : {"overshoot_", "reference_minus_feedback_", "mean_error_", "worst_taxel_error_"}) {
    INFO(name);
    CHECK(figure(kpa, name + "kpa") == Approx(6.894757 * figure(psi, name + "psi")).epsilon(0.002));
  }
  CHECK(figure(kpa, "elam_alpha_a1_per_kpa") == Approx(figure(psi, "elam_alpha_a1_per_psi") / 6.894757).epsilon(0.002));

  // Runs 1 to 4 are those of the two checks.
  const std::string unplugged = R"(simulation.faults=[{kind="scanner_unplugged",at_s=45}])";
  REQUIRE(call(folder, {"run", "small.toml", "--sensor", "S-1", "-q", "--no-seating", "--set", unplugged}).code == 3);
  const Finished resumed = call(folder, {"resume", "5", "-q", "--units", "kPa"});
  CHECK(resumed.code == 3);
  CHECK_THAT(resumed.err, Catch::Contains(" kPa"));
}
