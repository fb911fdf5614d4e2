// run, resume and devices calibrate-reference: what is refused, or warned of, before a device is opened.

#include <unistd.h>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>
#include <vector>

#include "bench/cli/rig/control.h"
#include "bench/common/error.h"
#include "bench/config/config.h"
#include "bench/run/control/locks.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/bench/run/stored_past.h"
#include "tests/support/process.h"
#include "tests/support/refusal.h"
#include "tests/support/text.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

// A bench whose simulated rig is another program's.
constexpr const char* kFarRig =
    "schema = 1\n[bench]\nid = \"far-rig\"\norigin = \"simulated\"\nsimulator = \"external\"\n[module]\nprofile = "
    "\"beckhoff-ek9000\"\nhost = \"127.0.0.1\"\nport = 1\n[regulator]\nserial = \"R\"\n[reference]\nmodel = \"m\"\n"
    "serial = \"s\"\n[scanner]\nsocket = \"/nonexistent/scanner\"\n";

struct RunToRefuse {
  RunToRefuse() { write_file(folder.path("far.toml"), kFarRig); }
  [[nodiscard]] Finished run(const std::string& bench, const std::vector<std::string>& more) const {
    return verb_here(bench::add_run, joined({"run", "equilibration", "--bench", bench, "--sensor", "S-9", "--operator",
                                             "me", "-q", "--db", folder.path("runs.db")},
                                            more));
  }
  [[nodiscard]] Finished calibrate(const std::vector<std::string>& more) const {
    return verb_here(bench::add_devices, joined({"devices", "calibrate-reference", "--bench", "simulated.toml",
                                                 "--gauge", "g", "--uncertainty", "0.05"},
                                                more));
  }
  TemporaryFolder folder;
};

// A store whose one run has these settings and is of the simulated bench.
struct StoreToResume : OpenStoreHere {
  explicit StoreToResume(const std::string& overrides) {
    db::RunRecord run = example_run();
    run.overrides_json = overrides;
    run.bench_id = "another-rig";
    run.bench_toml = read_file(bench::find_config("simulated.toml"));
    (void)begin_example(store, run);
  }
  Finished resume(const std::vector<std::string>& more = {}) const {
    return say(bench::add_control, joined({"resume", "1"}, more));
  }
};

}  // namespace

TEST_CASE("run: --specimen-state and --rate are accepted only for a bench simulated in this process") {
  const RunToRefuse of;
  check_refusal(of.run(of.folder.path("far.toml"), {"--specimen-state", "film.bin"}), 2, "TB-USAGE",
                "--specimen-state");
  check_refusal(of.run(of.folder.path("far.toml"), {"--rate", "10"}), 2, "TB-USAGE", "--rate");
  CHECK_FALSE(std::filesystem::exists(of.folder.path("runs.db")));
  for (const std::vector<std::string>& more :
       std::vector<std::vector<std::string>>{{"--rate", "10"}, {"--specimen-state", "film.bin"}})
    CHECK_THAT(of.run("simulated.toml", more).err, Catch::Contains("[TB-SENSOR-UNKNOWN]"));
}

TEST_CASE("run: warns about an overdue instrument before any other error, and not about a valid one") {
  const RunToRefuse of;
  const auto said = [&](const std::string& due) {
    return of.run("simulated.toml", {"--set", "reference.due=\"" + due + "\""}).err;
  };
  CHECK_THAT(said("2020-01-31"), Catch::Contains("2020-01-31") && Catch::Contains("[TB-SENSOR-UNKNOWN]"));
  CHECK_THAT(said("2999-01-31"), !Catch::Contains("2999") && Catch::Contains("[TB-SENSOR-UNKNOWN]"));
}

TEST_CASE("calibrate-reference: invalid options are rejected before a device is opened") {
  const RunToRefuse of;
  const auto refused = [&](const std::vector<std::string>& more) {
    const Finished done = of.calibrate(more);
    CAPTURE(more);
    CHECK(done.code == 2);
    CHECK(done.out.empty());
    CHECK_THAT(done.err, Catch::Contains("[TB-USAGE]\n  at: --levels\n"));
  };
  write_file(of.folder.path("none.toml"),
             "schema = 1\n[bench]\nid = \"b\"\norigin = \"simulated\"\n[module]\nprofile = \"beckhoff-ek9000\"\n"
             "[regulator]\nserial = \"R\"\n[reference]\nindependent = false\n");
  check_refusal(verb_here(bench::add_devices, {"devices", "calibrate-reference", "--bench", of.folder.path("none.toml"),
                                               "--gauge", "g", "--uncertainty", "0.05"}),
                2, "TB-USAGE");
  for (const char* levels : {"30", "0,20,20", "0,20,10", "0,60.5", "-0.5,5"})
    refused({std::string("--levels=") + levels});
  refused({"--levels=0,40", "--set", "limits.command_psi=39"});
  const std::string mine = of.folder.path("mine");
  write_file(mine, "mine\n");
  const Finished kept = of.calibrate({"--levels", "0,60", "-o", mine});
  CHECK(kept.code == 2);
  CHECK_THAT(kept.err, Catch::Contains("[TB-FILE-EXISTS]") && Catch::Contains("\n  at: " + mine + "\n"));
  CHECK(read_file(mine) == "mine\n");
  for (const char* wrong : {"-0.1", "10.1", "x"})
    CHECK(verb_here(bench::add_devices, {"devices", "calibrate-reference", "--bench", "simulated.toml", "--gauge", "g",
                                         std::string("--uncertainty=") + wrong})
              .code == 2);
}

TEST_CASE("dead-man: rejects a call without a socket name") {
  CHECK(verb_here(bench::add_dead_man, {"dead-man"}).code == 2);
}

TEST_CASE("resume: rejects invalid stored settings, and another bench") {
  for (const char* broken : {"{", "7", R"([{"key":"a"}])", R"([{"key":1,"value":"1"}])"}) {
    INFO(broken);
    const StoreToResume store(broken);
    check_refusal(store.resume(), 5, "TB-RESUME-SETTINGS");
  }
  const StoreToResume store("[]");
  CHECK_THAT(store.resume().err, Catch::Contains("[TB-RESUME-BENCH]"));
  check_refusal(store.resume({"--bench", "simulated.toml"}), 2, "TB-RESUME-BENCH", "simulated.toml");
  const StoreToResume settings(R"([{"key":"limits.comand_psi","value":"1"}])");
  CHECK_THAT(settings.resume().err, Catch::Contains("[TB-FILE-KEY]") && Catch::Contains("limits.comand_psi"));
  check_refusal(store.say(bench::add_control, {"resume", "9"}), 2, "TB-STORE-NOT-FOUND");
}

// Which live run a person means, and what is refused when none or several could be meant.

namespace {

constexpr uid_t kNobodysNumber = 3999999;  // no user of this machine

LiveRun live_run(std::int64_t number, const std::string& bench) {
  LiveRun live;
  live.name = live.bench = bench;
  live.server = {812, kNobodysNumber, false};
  live.status.run = number;
  live.status.state = RunState::kPaused;
  live.status.store = "/s/" + bench + ".db";
  live.status.step = 3;
  live.status.steps = 40;
  return live;
}

SilentBench silent_bench(std::int64_t run, bool stranger, bool with_process) {
  SilentBench silent;
  silent.name = silent.bench = "b-2";
  silent.run = run;
  silent.stranger = stranger;
  if (with_process) silent.server = Peer{77, kNobodysNumber, false};
  return silent;
}

// The identifier of what `choose` refuses; "taken" where it refuses nothing.
template <class Choose>
std::string named_run_refusal(const Choose& choose) {
  const auto error = tests::refusal_by(choose);
  if (!error) return "taken";
  CHECK(error->code() == ExitCode::kUsage);
  return error->id();
}

}  // namespace

TEST_CASE("named run: a command goes to the only live run, or if a bench is silent only to a run that is named") {
  const LiveRunSelector unnamed;
  LiveRunSelector by_bench, by_store, by_number;
  by_bench.bench = "b-1";
  by_store.db_given = true;
  by_number.run = 7;
  Candidates found;
  found.runs = {live_run(7, "b-1")};
  for (const LiveRunSelector& named : {unnamed, by_bench, by_store, by_number})
    for (const bool urgent : {false, true}) CHECK(require_single_run(found, named, "stop", urgent).status.run == 7);
  found.silent = {silent_bench(9, true, false)};  // a stranger's could not be commanded anyway
  CHECK(require_single_run(found, unnamed, "stop", false).status.run == 7);
  found.silent.push_back(silent_bench(9, false, false));
  for (const LiveRunSelector& named : {by_bench, by_store})
    CHECK(require_single_run(found, named, "stop", false).status.run == 7);
  CHECK(require_single_run(found, unnamed, "panic", true).status.run == 7);
  found.silent = {silent_bench(9, false, false)};
  for (const LiveRunSelector& named : {unnamed, by_number})
    CHECK(named_run_refusal([&] { (void)require_single_run(found, named, "stop", false); }) == "TB-RUN-AMBIGUOUS");
  found.silent.clear();
  found.runs.push_back(live_run(8, "b-3"));
  for (const bool urgent : {false, true})
    CHECK(named_run_refusal([&] { (void)require_single_run(found, by_bench, "pause", urgent); }) == "TB-RUN-AMBIGUOUS");
}

TEST_CASE("named run: a silent bench is reported before the absence of a live run") {
  const LiveRunSelector unnamed;
  LiveRunSelector by_number;
  by_number.run = 12;
  Candidates found;
  CHECK(named_run_refusal([&] { (void)require_single_run(found, unnamed, "stop", false); }) == "TB-RUN-NOT-LIVE");
  found.others = {live_run(7, "b-1")};
  CHECK(named_run_refusal([&] { (void)require_single_run(found, by_number, "stop", false); }) == "TB-RUN-NOT-LIVE");
  found.silent = {silent_bench(9, false, true), silent_bench(0, false, false)};
  CHECK(named_run_refusal([&] { (void)require_single_run(found, by_number, "stop", true); }) == "TB-RUN-SILENT");
  const std::string stranger = named_run_refusal([&] { refuse_silent({silent_bench(9, true, true)}); });
  if (::geteuid() == 0) {
    CHECK(stranger == "TB-RUN-SILENT");
  } else {
    CHECK(stranger == "TB-RUN-DENIED");
  }
}

TEST_CASE("named run: two paths of one store are equal, a bench is named by its file or its id") {
  const tests::TemporaryFolder folder;
  std::filesystem::create_directory(folder.path("in"));
  tests::write_file(folder.path("runs.db"), "x");
  std::filesystem::create_symlink("runs.db", folder.path("link.db"));
  CHECK(same_store(folder.path("runs.db"), folder.path("in/../runs.db")));
  CHECK(same_store(folder.path("runs.db"), folder.path("link.db")));
  CHECK_FALSE(same_store(folder.path("runs.db"), folder.path("other.db")));
  CHECK(bench_id_of("simulated.toml") == "simulated-rig");
  CHECK(bench_id_of("b-1").size() == 3);
  CHECK(bench_id_of("").empty());
}

// Output of plan for small recipes, with hand-computed figures: 20 psi/s, and 0.65 s to settle.

namespace {

// One cycle to 20 psi, then a frame at 0, 5, 10, 5 and 0 psi, twice.
constexpr const char* kTwoLoops =
    "schema = 1\nname = \"two\"\nunit = \"psi\"\nturning_points = [0, 10, 0]\nstep = 5\nrepeats = 2\ndwell_s = 3\n"
    "[conditioning]\ncycles = 1\npeak = 20\n";
constexpr const char* kOneTouch =
    "schema = 1\nname = \"touch\"\nkind = \"press\"\ndwell_s = 1\n[press]\nobject = \"ring\"\nforces_n = [2, 4]\n"
    "positions_mm = [[20, 30]]\n[prompt]\nbefore = \"Ready?\"\n";
struct PlanFolder {
  PlanFolder() {
    write_file(folder.path("two.toml"), kTwoLoops);
    write_file(folder.path("touch.toml"), kOneTouch);
  }
  // Recipes are named by their files in this folder.
  [[nodiscard]] Finished plan(const std::vector<std::string>& recipes,
                              const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words = {"plan", "--db", folder.path("runs.db"), "--bench", "simulated.toml"};
    for (const std::string& recipe : recipes) words.push_back(folder.path(recipe + ".toml"));
    words.insert(words.end(), more.begin(), more.end());
    return verb_here(bench::add_plan, words);
  }
  [[nodiscard]] nlohmann::json json(const std::vector<std::string>& recipes, std::vector<std::string> more = {}) const {
    more.emplace_back("--json");
    return nlohmann::json::parse(plan(recipes, more).out);
  }
  TemporaryFolder folder;
};

}  // namespace

TEST_CASE("plan: the JSON document has every value, and each step on request") {
  const PlanFolder here;
  const nlohmann::json printed = here.json({"two"});
  CHECK(printed.at("schema") == "tactbench.plan");
  CHECK(printed.at("bench") == "simulated-rig");
  REQUIRE(printed.at("recipes").size() == 1);
  CHECK(printed.at("recipes").at(0).at("name") == "two");
  for (const nlohmann::json& time : {printed.at("recipes").at(0).at("time"), printed.at("time")}) {
    CHECK(time.at("p10_s").get<double>() == Approx(45.46));
    CHECK(time.at("p50_s").get<double>() == Approx(47.8));
    CHECK(time.at("p90_s").get<double>() == Approx(55.6));
    CHECK(time.at("runs") == 0);
    CHECK(time.at("prompts") == 0);
  }
  CHECK(printed.at("process_seconds").get<double>() == Approx(47.8));
  CHECK(printed.at("steps") == 12);
  CHECK(printed.at("frames") == 10);
  CHECK(printed.at("axes") ==
        nlohmann::json::parse(R"([{"axis": "pressure", "unit": "psi", "lowest": 0.0, "highest": 20.0, "limit": 60.0,
                                  "margin": 40.0}])"));
  check_members(printed, R"({"lowest_psi": 0.0, "highest_psi": 20.0, "largest_force_n": 0.0,
                          "command_limit_psi": 60.0, "margin_psi": 40.0, "store_bytes": 12440.0})");
  CHECK(printed.at("devices") == nlohmann::json({"pressure source", "pressure reference", "tactile array"}));
  CHECK(printed.at("instruments") == nlohmann::json::parse(R"json([{"role": "pressure reference",
      "model": "simulated transducer, 100 psi", "serial": "SIM-REF-1",
      "certificate": "SIM-CERT-1 (invented for the simulation)", "calibrated": "", "due": "", "overdue": false
}])json"));
  CHECK(printed.at("fail_safe").size() >= 4);
  CHECK_FALSE(printed.contains("limits"));
  CHECK_FALSE(printed.contains("step_list"));
  const nlohmann::json both = here.json({"two", "touch"}, {"--steps"});
  CHECK(both.at("recipes").at(1).at("time").at("prompts") == 1);
  CHECK(both.at("recipes").at(1).at("time").at("p50_s").get<double>() == Approx(57.8));
  CHECK(both.at("instruments").size() == 5);
  REQUIRE(both.at("step_list").size() == 22);
  const auto& measure = both.at("step_list").at(4);
  CHECK((measure.at("kind") == "measure" && measure.at("ordinal") == 2 && measure.at("frame") == true));
  CHECK((measure.at("setpoint_psi") == 10.0 && measure.at("dwell_s") == 3.0));
  const auto& press = both.at("step_list").at(18);
  CHECK((press.at("kind") == "press" && press.at("sequence") == 1 && press.at("ordinal") == 1));
  CHECK((press.at("force_n") == 4.0 && press.at("x_mm") == 20.0 && press.at("y_mm") == 30.0));
  CHECK(both.at("step_list").at(12).at("frame") == false);  // the prompt
}

TEST_CASE("plan: reports the levels of the limits that no recipe measures, with the nearest measured levels") {
  const PlanFolder here;
  const auto limits_at = [&](const std::string& psi) {
    write_file(here.folder.path("limits.toml"),
               "schema = 1\nname = \"mine\"\nmean_compensation_error_psi = 1\nworst_taxel_error_psi = 1\n"
               "distance_of_mean_percent_fs = 1\nunfit_taxels = 0\n[[mismatch]]\npressure_psi = " +
                   psi + "\nstd_percent_fs = 1\n");
  };
  const std::vector<std::string> given = {"--limits", here.folder.path("limits.toml")};
  limits_at("10");
  CHECK(here.plan({"two"}, given).code == 0);
  CHECK(here.json({"two"}, given).at("limits") == nlohmann::json::parse(R"({"name": "mine", "levels_lacking": []})"));
  limits_at("7");
  CHECK(here.plan({"two"}, given).code == 6);
  CHECK(here.json({"two"}, given).at("limits").at("levels_lacking") ==
        nlohmann::json::parse(R"([{"pressure_psi": 7.0, "nearest_psi": [5.0, 10.0]}])"));
}

TEST_CASE("plan: lists parameters with value, default and range") {
  const PlanFolder here;
  write_file(here.folder.path("free.toml"),
             "schema = 1\nname = \"free\"\nunit = \"psi\"\nturning_points = [0, \"$level\", 0]\nstep = 5\n"
             "[parameters.level]\ndefault = 10\nlow = 5\nhigh = 40\nunit = \"psi\"\nhelp = \"the top\"\n");
  const std::vector<std::string> asked = {"--parameters", "--set", "recipe.level=20"};
  CHECK(here.plan({"free", "two"}, {"--parameters"}).code == 0);
  const nlohmann::json printed = here.json({"free"}, asked);
  CHECK(printed.at("schema") == "tactbench.plan.parameters");
  CHECK(printed.at("parameters") == nlohmann::json::parse(R"([{"recipe": "free", "name": "level", "value": 20.0,
      "default": 10.0, "low": 5.0, "high": 40.0, "unit": "psi", "help": "the top"}])"));
}

TEST_CASE("plan: estimates times from completed runs of the same bench") {
  const PlanFolder here;
  const sequences::Recipe recipe = recipe_named("known");
  write_file(here.folder.path("known.toml"), recipe.text);
  Past past;
  {
    db::RunStore store = db::RunStore::open(here.folder.path("runs.db"), db::Durability::kNormal);
    store.add_sensor({"S-1", "type", "", "", "", "", ""});
    for (const char* bench : {"simulated-rig", "another", "simulated-rig"}) {
      past.bench = bench;
      store_run(store, {recipe}, past);  // 20 steps of 3 s
    }
  }
  const nlohmann::json time = here.json({"known"}).at("time");
  CHECK(time.at("runs") == 2);
  CHECK(time.at("p50_s").get<double>() == Approx(60.0).margin(1.0));
}

// status and watch where no run is live.

namespace {

// Runs of bench-a, bench-b, and one of bench-a that has not ended.
struct StoreOfStatus : OpenStoreHere {
  StoreOfStatus() {
    (void)store_example(store);
    db::RunRecord other = example_run();
    other.bench_id = "bench-b";
    other.origin = "hardware";
    const Begun failed = begin_example(store, other);
    store.end_run(failed.run, db::Outcome::kFailed, "TB-X: it broke", db::SafeState::kVerified, "2024-05-02T00:00:00Z");
    (void)begin_example(store);
    write_file(path + "-lock", "");  // of a program that ran here: nobody holds it
  }
  Finished status(const std::vector<std::string>& words) const { return say(bench::add_status, words); }
};

}  // namespace

TEST_CASE("status: shows the last run of the store, of a bench, or the run that is named") {
  const StoreOfStatus store;
  CHECK(store.status({"status"}).code == 0);
  check_refusal(store.status({"status", "9"}), 2, "TB-STORE-NOT-FOUND");
  const auto printed = [&](std::vector<std::string> more) {
    more.insert(more.begin(), "status");
    return store.printed<nlohmann::json>(bench::add_status, more);
  };
  const nlohmann::json last = printed({});
  CHECK((last.at("live") == false && last.at("runs").empty() && last.at("silent").empty()));
  CHECK((last.at("last_run").at("run") == 3 && last.at("last_run").at("lives") == false));
  CHECK(printed({"--bench", "bench-b"}).at("last_run").at("run") == 2);
  CHECK(printed({"1"}).at("last_run").at("run") == 1);
  CHECK(printed({"--bench", "bench-c"}).at("last_run").is_null());
}

TEST_CASE("watch: for an ended run it ends with the exit code of that run") {
  const StoreOfStatus store;
  CHECK(store.status({"status", "--watch", "1"}).code == 0);
  CHECK(store.status({"status", "--watch", "2"}).code == 3);
  check_refusal(store.status({"status", "--watch", "--bench", "no-such-bench"}), 2, "TB-RUN-NOT-LIVE");
}
