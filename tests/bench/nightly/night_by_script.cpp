// A night's processes: their words, how many run at a time, what becomes of those that fail or do not end, and files of
// others. By scripts in the place of the program.
#include <signal.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "bench/common/error.h"
#include "bench/common/stop_request.h"
#include "bench/nightly/night.h"
#include "db/run_store.h"
#include "tests/support/endless_run.h"
#include "tests/support/process.h"
#include "tests/support/refusal.h"
#include "tests/support/variable.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;
namespace fs = std::filesystem;

namespace {

using TalkLines = std::vector<std::string>;

// Scenarios do as they are called: good, bad (exit code 3), struck (by a signal), endless.
class ScriptedNight {
 public:
  explicit ScriptedNight(const std::vector<std::string>& names) {
    options.program = folder.path("program");
    options.stores = folder.path("stores/of/it");
    suite.file = "./s.toml";
    for (const std::string& name : names) {
      Scenario& scenario = suite.scenarios.emplace_back();
      scenario.name = name.substr(0, name.find('-'));
      scenario.label = name;
      scenario.about = "about " + name;
      scenario.seed = 40 + suite.scenarios.size();
    }
    ScenarioResult good;
    good.name = "of the process";
    good.about = "as measured";
    good.figures = {{"frames", 60.0}};
    good.seconds = 1.25;
    write_file(folder.path("good.json"), to_json(good));
    write_file(options.program,
               "#!/bin/sh\ncd '" + folder.path() +
                   "'\nfor last in \"$@\"; do :; done\n"
                   "printf '%s\\n' \"$TACTBENCH_RUNTIME_DIR\" \"$@\" >\"words-$6\"\necho $$ >\"process-$6\"\n"
                   "mkdir \"now-$6\"\nls -d now-* | wc -l >>counts\n"
                   "case $4 in\n  good) sleep 0.2; rmdir \"now-$6\"; echo talk; cp good.json \"$last\" ;;\n"
                   "  bad) rmdir \"now-$6\"; echo 'it says this'; echo 'and this' >&2; exit 3 ;;\n"
                   "  struck) rmdir \"now-$6\"; kill -9 $$ ;;\n"
                   "  endless) sleep 600 & echo $! >sleeper; wait ;;\nesac\n");
    fs::permissions(options.program, fs::perms::owner_all);
  }
  std::vector<ScenarioResult> carry_out() {
    return carry_out_night(suite, options, [&](const std::vector<ScenarioResult>& results) {
      std::string names;
      for (const ScenarioResult& result : results) names += result.name + " ";
      told.push_back(names);
    });
  }
  // "code id place"
  [[nodiscard]] std::string refusal() {
    const auto error = refusal_by([&] { (void)carry_out(); });
    if (!error) return "carried out";
    CHECK_FALSE(error->remedy().empty());
    return std::to_string(static_cast<int>(error->code())) + " " + error->id() + " " + error->where();
  }
  [[nodiscard]] TalkLines lines_of(const std::string& name) const {
    std::istringstream text(read_file(folder.path(name)));
    TalkLines lines;
    for (std::string line; std::getline(text, line);) lines.push_back(line);
    return lines;
  }
  [[nodiscard]] std::string kept(const std::string& name) const { return options.stores + "/" + name; }
  // At most that many processes at a time.
  [[nodiscard]] int most_at_once() const {
    int most = 0;
    for (const std::string& line : lines_of("counts")) most = std::max(most, std::stoi(line));
    return most;
  }
  TemporaryFolder folder;
  Suite suite;
  NightOptions options;
  TalkLines told;
};

}  // namespace

TEST_CASE("night by script: each scenario in a process of its own by these words, reported in the suite's order") {
  ScriptedNight night({"good-a", "bad", "struck"});
  const std::vector<ScenarioResult> results = night.carry_out();
  REQUIRE(results.size() == 3);
  CHECK(results[0].name == "good-a");
  CHECK(results[0].about == "as measured");
  CHECK(results[0].seconds == 1.25);
  CHECK(results[0].figures.at("frames") == 60.0);
  CHECK(results[0].wrong.empty());
  CHECK(results[1].name == "bad");
  CHECK(results[1].about == "about bad");
  CHECK(results[1].seconds > 0.0);
  CHECK(results[1].seconds < 60.0);
  REQUIRE((results[1].wrong.size() == 2 && results[2].wrong.size() == 2));
  CHECK_THAT(results[1].wrong[0], Catch::Contains("exit code 3"));
  CHECK(results[1].wrong[1] == "it says this\nand this\n");
  CHECK_THAT(results[2].wrong[0], Catch::Contains("signal 9"));
  REQUIRE(night.told.size() == 3);
  CHECK(night.told[2] == "good-a bad struck ");
  CHECK(night.most_at_once() <= 2);
  const TalkLines words = night.lines_of("words-41");
  REQUIRE(words.size() == 11);
  const std::string scope = words[0];
  CHECK_THAT(scope, Catch::Contains("tactbench-night"));
  CHECK(words == TalkLines{scope, "nightly", "./s.toml", "--only", "good", "--seed", "41", "--db",
                           night.kept("good-a.db"), "--result", scope + "/good-a.json"});
  CHECK_FALSE(fs::exists(scope));
  CHECK_THAT(read_file(night.kept("good-a.log")), Catch::StartsWith("# ") && Catch::EndsWith("\ntalk\n"));
  CHECK_THAT(read_file(night.kept("bad.log")), Catch::EndsWith("\nit says this\nand this\n"));
}

TEST_CASE("night by script: as many at a time as jobs, and none after a red one on request") {
  ScriptedNight alone({"good-a", "good-b"});
  alone.options.jobs = 1;
  CHECK(alone.carry_out().size() == 2);
  CHECK(alone.most_at_once() == 1);
  CHECK(alone.told == TalkLines{"good-a ", "good-a good-b "});
  ScriptedNight stops({"good-a", "bad", "good-b"});
  stops.options.jobs = 1;
  stops.options.stop_on_red = true;
  const std::vector<ScenarioResult> results = stops.carry_out();
  REQUIRE(results.size() == 2);
  CHECK(results[1].name == "bad");
  CHECK_FALSE(fs::exists(stops.folder.path("words-43")));
  ScriptedNight goes_on({"bad", "good-b"});
  goes_on.options.jobs = 1;
  CHECK(goes_on.carry_out().size() == 2);
  ScriptedNight none({});
  CHECK(none.carry_out().empty());
}

TEST_CASE("night by script: one that does not end in its time is killed with all it started, and is red") {
  ScriptedNight night({"endless", "good-a"});
  night.options.limit_s = 1.4;
  const std::vector<ScenarioResult> results = night.carry_out();
  REQUIRE(results.size() == 2);
  REQUIRE_FALSE(results[0].wrong.empty());
  CHECK_THAT(results[0].wrong[0], Catch::Contains(" 1 s"));
  CHECK(results[0].seconds >= 1.4);
  CHECK(results[1].wrong.empty());
  CHECK(process_ends(night.lines_of("sleeper").at(0)));
}

TEST_CASE("night by script: a signal ends all scenarios, and the night tells after how many") {
  const StopRequest signals;
  ScriptedNight night({"bad", "endless"});
  night.options.signals = &signals;
  night.options.jobs = 1;
  const auto ended = refusal_by([&] {
    (void)carry_out_night(night.suite, night.options, [](const std::vector<ScenarioResult>&) { std::raise(SIGTERM); });
  });
  REQUIRE(ended);
  CHECK(ended->id() == "TB-NIGHTLY-STOPPED");
  CHECK(static_cast<int>(ended->code()) == 143);
  CHECK_THAT(ended->what(), Catch::Contains("1 of 2"));
}

TEST_CASE("night by script: a program that cannot be started, and a file that cannot be written, end the night") {
  ScriptedNight night({"good-a"});
  night.options.program = night.folder.path("none");
  CHECK(night.refusal() == "70 TB-NIGHTLY-SPAWN " + night.folder.path("none"));
  ScriptedNight folder({"good-a"});
  fs::create_directories(folder.kept("good-a.log"));
  CHECK(folder.refusal() == "2 TB-FILE-WRITE " + folder.kept("good-a.log"));
}

TEST_CASE("night by script: stores and talk of an earlier night are replaced, and files of others are not") {
  ScriptedNight night({"good-a"});
  CHECK(night.carry_out().size() == 1);
  {
    db::RunStore store = db::RunStore::open(night.kept("good-a.db"), db::Durability::kNormal);
    store.add_sensor({"SIM-0001", "t", "", db::sha256_hex(""), "", "simulated array of the nightly suite", ""});
  }
  for (const char* ending : {".db-wal", ".db-shm", ".db-lock"})
    write_file(night.kept(std::string("good-a") + ending), "");
  fs::remove(night.folder.path("counts"));
  CHECK(night.carry_out().size() == 1);
  for (const char* ending : {".db", ".db-wal", ".db-shm", ".db-lock"})
    CHECK_FALSE(fs::exists(night.kept(std::string("good-a") + ending)));
  write_file(night.kept("good-a.db"), "");  // an empty file is nobody's
  CHECK(night.carry_out().size() == 1);
  write_file(night.kept("good-a.db"), "dear diary\n");
  const std::string store = "2 TB-FILE-STORE " + night.kept("good-a.db");
  CHECK(night.refusal() == store);
  night.options.replace = true;
  CHECK(night.refusal() == store);
  fs::remove(night.kept("good-a.db"));
  night.options.replace = false;
  write_file(night.kept("good-a.log"), "dear diary\n");
  CHECK_THAT(night.refusal(), Catch::StartsWith("2 TB-FILE-EXISTS "));
  night.options.replace = true;
  CHECK(night.carry_out().size() == 1);
}
