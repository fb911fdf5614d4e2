// nightly: text, JSON and stored data of a small night, scenario by scenario; and one that cannot be started.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/nightly/suite.h"
#include "db/run_store.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"
#include "tests/support/text.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;
using Told = nlohmann::ordered_json;

namespace {

// The first is green after 60 frames, the second red at once, the third as long as it is given.
struct SmallNight {
  SmallNight() {
    write_file(folder.path("s.toml"),
               "schema = 1\nname = \"small\"\n"
               "[[scenario]]\nname = \"whole\"\nabout = \"nothing is wrong\"\nrecipes = [\"equilibration\"]\n"
               "fits = false\n[scenario.figures]\nframes = [60, 60.5]\n"
               "[[scenario]]\nname = \"misspelt\"\nabout = \"no such recipe\"\nrecipes = [\"no-such\"]\n");
  }
  Finished night(std::vector<std::string> more) const {
    more.insert(more.begin(), {"nightly", "./s.toml"});
    return call(folder, more);
  }
  [[nodiscard]] bool exists(const std::string& name) const { return std::filesystem::exists(folder.path(name)); }
  TemporaryFolder folder;
};

}  // namespace

TEST_CASE("nightly: writes the requested lists and page, and leaves no scenario store") {
  const SmallNight of;
  CHECK(of.night({"--jobs", "1", "--junit", "night.xml", "--html", "night.html"}).code == 1);
  CHECK_THAT(read_file(of.folder.path("night.xml")),
             Catch::Contains("tests=\"2\" failures=\"1\" errors=\"0\"") && Catch::Contains("name=\"misspelt\""));
  for (const char* name : {"whole.db", "misspelt.db", "whole.log"}) CHECK_FALSE(of.exists(name));
  const Finished quiet = of.night({"--only", "whole", "-q"});
  CHECK(quiet.code == 0);
  CHECK(quiet.err.empty());
  const Finished printed = of.night({"--only", "whole", "--json"});
  CHECK(printed.err.empty());
  const Told document = Told::parse(printed.out);
  check_members(document, R"({"schema": "tactbench.nightly", "suite": "small", "red": 0})");
  CHECK(document.at("scenarios").size() == 1);
}

TEST_CASE("nightly: --db keeps each night in one store, --stores keeps the stores and logs of the scenarios") {
  const SmallNight of;
  CHECK(of.night({"--only", "whole", "--db", "n.db", "--junit", "night.xml", "--html", "night.html"}).code == 0);
  CHECK(of.night({"--only", "whole", "--db", "n.db", "--stores", "kept"}).code == 0);
  CHECK((of.exists("kept/whole.db") && of.exists("kept/whole.log")));
  CHECK_FALSE(of.exists("whole.db"));
  const db::RunStore store = db::RunStore::open_read_only(of.folder.path("n.db"));
  CHECK(store.runs().size() == 2);
  const std::vector<db::NightRecord> nights = store.nights();
  REQUIRE(nights.size() == 2);
  CHECK(nights[1].suite == "small");
  CHECK(nights[1].shard == 1);
  CHECK(nights[1].shards == 1);
  CHECK(of.night({"--shard", "1/2", "--db", "p.db"}).code == 0);
}

TEST_CASE("nightly: the parts of a night are merged, reported as one and counted") {
  const SmallNight of;
  CHECK(of.night({"--shard", "1/2", "--db", "p1.db", "-q"}).code == 0);
  CHECK(of.night({"--shard", "2/2", "--db", "p2.db", "-q"}).code == 1);
  const auto merge = [&](const std::vector<std::string>& more) {
    return call(of.folder, joined({"runs", "merge", "p1.db", "p2.db", "--db", "all.db"}, more));
  };
  CHECK(merge({"--html", "night.html", "--junit", "night.xml"}).code == 1);
  CHECK_THAT(read_file(of.folder.path("night.xml")), Catch::Contains("failures=\"1\""));
  CHECK(merge({}).code == 1);
}

TEST_CASE("nightly: an unwritable output file ends it before a scenario starts") {
  const SmallNight of;
  write_file(of.folder.path("blocked"), "no folder");
  for (const char* file : {"--junit", "--metrics", "--html"}) {
    const Finished refused = of.night({"--only", "whole", "--stores", "kept", file, "blocked/file"});
    INFO(file);
    CHECK(refused.code == 2);
    CHECK(refused.out.empty());
    CHECK_FALSE(of.exists("kept/whole.db"));
  }
}

TEST_CASE("nightly: the list files are updated after each scenario") {
  const SmallNight of;
  std::string suite = read_file(of.folder.path("s.toml"));
  suite +=
      "[[scenario]]\nname = \"endless\"\nabout = \"ended by a signal\"\nrecipes = [\"./long.toml\"]\nfits = "
      "false\n";
  write_file(of.folder.path("long.toml"),
             "schema = 1\nname = \"long\"\nunit = \"psi\"\nturning_points = [0, 60, 0]\nstep = 2\nrepeats = 1000\n");
  write_file(of.folder.path("s.toml"), suite);
  const std::string lists = of.folder.path("night.xml");
  const auto after_two = [&] {
    return std::filesystem::exists(lists) && read_file(lists).find("failures=\"1\"") != std::string::npos;
  };
  check_refusal(run_program(program_path(), {"nightly", "./s.toml", "--jobs", "1", "--junit", "night.xml"},
                            of.folder.path(), {SIGTERM, after_two}),
                143, "TB-NIGHTLY-STOPPED");
}

TEST_CASE("nightly: a scenario in its own process writes its result file and prints nothing") {
  const SmallNight of;
  const Finished one = of.night({"--only", "whole", "--db", "one.db", "--result", "r.json"});
  CHECK(one.code == 0);
  CHECK(one.out.empty());
  const Told result = Told::parse(read_file(of.folder.path("r.json")));
  CHECK(result.at("name") == "whole");
  CHECK(result.at("figures").at("frames") == 60.0);
  CHECK(db::RunStore::open_read_only(of.folder.path("one.db")).runs().size() == 1);
}

TEST_CASE("nightly: a scenario process that cannot be started ends the night with an error") {
  const SmallNight of;
  // An environment that the night's own process can be started with, and none whose words are longer.
  write_file(of.folder.path("full.sh"),
             "ulimit -s 2048\n"
             "A=$(printf %110000s)\nn=90000\n"
             "while [ $n -gt 70000 ]; do\n"
             "  E=$(printf %${n}s)\n"
             "  (A=$A B=$A C=$A D=$A E=$E exec \"$1\" nightly ./s.toml --only whole) >out 2>err\n"
             "  code=$?\n"
             "  [ $code -ne 126 ] && exit $code\n"
             "  n=$((n-64))\n"
             "done\n");
  CHECK(run_program("/usr/bin/env", {"-i", "/bin/sh", "full.sh", program_path()}, of.folder.path()).code == 70);
  CHECK_THAT(read_file(of.folder.path("err")), Catch::Contains("[TB-NIGHTLY-SPAWN]"));
}

TEST_CASE("nightly --copy: a suite of one's own with the scenarios named, which a night takes") {
  const SmallNight of;
  CHECK(of.night({"--copy", "mine", "--only", "whole"}).code == 0);
  const bench::Suite mine = bench::read_suite(of.folder.path("mine.toml"));
  CHECK(mine.name == "mine");
  REQUIRE(mine.scenarios.size() == 1);
  CHECK((mine.scenarios[0].name == "whole" && mine.scenarios[0].figures.size() == 1));
  CHECK(of.night({"--copy", "both.toml"}).code == 0);
  CHECK(bench::read_suite(of.folder.path("both.toml")).scenarios.size() == 2);
  check_refusal(of.night({"--copy", "mine"}), 2, "TB-FILE-EXISTS");
  check_refusal(of.night({"--copy", "a", "--only", "none"}), 2, "TB-NIGHTLY-SCENARIO");
  const Finished two = of.night({"--only", "misspelt", "--only", "whole", "--list", "--json"});
  CHECK(Told::parse(two.out).at("scenarios").size() == 2);
}

// A scenario carried out in this process on the simulated rig: what its store, its result and its expectations hold.

namespace {

class CarriedScenario {
 public:
  CarriedScenario() {
    write_file(folder_.path("short.toml"),
               "schema = 1\nname = \"short\"\nunit = \"psi\"\nturning_points = [0, 60, 20, 60, 0]\nstep = "
               "20\ndwell_s = 0.5\nrepeats = 1\n[conditioning]\ncycles = 1\npeak = 60\n");
    scenario = parse_suite(
                   "schema = 1\nname = \"s\"\n[[scenario]]\nname = \"one\"\nabout = \"first\"\nseed = "
                   "5\nsensor_seed = 17\n",
                   "s.toml")
                   .scenarios.at(0);
    scenario.label = "one-seed-5";
    scenario.recipes = {folder_.path("short.toml")};
  }
  ScenarioResult carry_out() { return bench::carry_out(scenario, path); }
  Scenario scenario;

 private:
  TemporaryFolder folder_;

 public:
  std::string path = folder_.path("one.db");
};

}  // namespace

TEST_CASE(
    "nightly scenario: without a fit its result has the values of the rig, and its store is marked as a scenario") {
  CarriedScenario made;
  made.scenario.fits = false;
  made.scenario.figures = {{"frames", {11.0, 11.0}}, {"none", {0.0, 1.0}}};
  const ScenarioResult result = made.carry_out();
  CHECK(result.name == "one-seed-5");
  CHECK(result.about == "first");
  REQUIRE(result.wrong.size() == 1);
  CHECK_THAT(result.wrong[0], Catch::Contains("none"));
  REQUIRE(result.runs.size() == 1);
  CHECK(result.runs[0].run == 1);
  CHECK(result.runs[0].outcome == "completed");
  CHECK(result.runs[0].error.empty());
  CHECK(result.runs[0].safe == "verified");
  CHECK(result.figures.at("frames") == 11.0);
  CHECK(result.figures.at("branches_redone") == 0.0);
  CHECK(result.figures.at("flagged_frames") == 0.0);
  CHECK(result.verdicts.empty());
  CHECK(result.taxels.empty());
  CHECK(result.seconds > 0.0);
  CHECK(is_scenario_store(made.path));
  const db::RunStore store = db::RunStore::open_read_only(made.path);
  const db::RunRecord run = store.run(1);
  CHECK(result.figures.at("instruments") == static_cast<double>(run.devices.size()));
  CHECK(result.runs[0].content_sha256 == run.content_sha256);
  CHECK(run.sensor_serial == "SIM-0017");
  CHECK(run.operator_name == "nightly");
  CHECK(run.purpose == "nightly: one");
  CHECK((run.seed == 5 && run.sensor_seed == 17));
  CHECK(store.fits(1).empty());
}

TEST_CASE("nightly scenario: held-out runs have seeds of their own and are judged, the first one is void on request") {
  CarriedScenario made;
  made.scenario.held_out = {{"recipe.dwell_s=1"}, {}};
  made.scenario.void_held_out = true;
  made.scenario.verdicts = {{"unfit_taxels", "pass"}};
  const ScenarioResult result = made.carry_out();
  CHECK(result.wrong.empty());
  REQUIRE(result.runs.size() == 3);
  CHECK(result.figures.at("frames") == 33.0);
  CHECK(result.figures.contains("mean_error_psi"));
  CHECK(result.verdicts.contains("overall"));
  CHECK(result.verdicts.contains("mismatch 40 psi increasing"));
  CHECK(result.verdicts.at("unfit_taxels") == "pass");
  CHECK(result.taxels.empty());
  const db::RunStore store = db::RunStore::open_read_only(made.path);
  CHECK(store.run(2).seed == 1'000'005);
  CHECK(store.run(3).seed == 2'000'005);
  CHECK(store.run(2).overrides_json.find("dwell_s") != std::string::npos);
  CHECK(store.run(3).overrides_json.find("dwell_s") == std::string::npos);
  CHECK(store.run(2).void_by == "nightly");
  CHECK_FALSE(store.run(3).is_void());
  CHECK(store.verdicts(2).empty());
  CHECK(store.verdicts(3).size() == 8);
}

TEST_CASE("nightly scenario: only its own run is judged, an unexpected dead taxel is an error") {
  CarriedScenario made;
  made.scenario.own_run = true;
  made.scenario.set = {"simulation.defect=[{kind=\"dead\",row=3,column=4}]"};
  made.scenario.verdicts = {{"unfit_taxels", "fail"}};
  const ScenarioResult result = made.carry_out();
  REQUIRE(result.wrong.size() == 1);
  CHECK_THAT(result.wrong[0], Catch::Contains("dead") && Catch::Contains("52"));
  CHECK(result.taxels.at("dead") == std::vector<int>{52});
  CHECK_FALSE(result.verdicts.contains("overall"));
  CHECK(result.verdicts.size() == 8);
  CHECK(db::RunStore::open_read_only(made.path).verdicts(1).empty());
}

TEST_CASE("nightly scenario: a failed analysis is reported, and after a failed run no analysis is tried") {
  CarriedScenario made;
  made.scenario.set = {"recipe.turning_points=[0, 20]"};
  const ScenarioResult result = made.carry_out();
  REQUIRE(result.wrong.size() == 1);
  CHECK_THAT(result.wrong[0], Catch::Contains("TB-ANALYSIS-"));
  CarriedScenario failed;
  failed.scenario.held_out = {{}};
  failed.scenario.set = {"simulation.faults=[{kind=\"supply_lost\",at_s=20}]"};
  const ScenarioResult broken = failed.carry_out();
  CHECK(broken.runs.size() == 1);
  CHECK(broken.verdicts.empty());
  CHECK_FALSE(broken.figures.contains("instruments"));
  REQUIRE(broken.wrong.size() >= 2);
  CHECK_THAT(broken.wrong[0], Catch::Contains("failed") && Catch::Contains("completed"));
}
