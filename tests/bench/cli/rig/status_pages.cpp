// What status and watch print where no run is live, and what run refuses before a device is opened.
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/cli/verb_here.h"
#include "tests/db/store_example.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// Runs of bench-a, bench-b, and one of bench-a that has not ended.
struct StoreOfStatus {
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
  // Without the line on recipe and people, which the monitor's tests have.
  Finished say(const std::vector<std::string>& words) const {
    Finished finished = verb_here(bench::add_status, words);
    for (std::size_t at = 0; (at = finished.out.find("recipe ", at)) != std::string::npos;)
      finished.out.erase(at, finished.out.find('\n', at) + 1 - at);
    return finished;
  }
  TemporaryFolder folder;
  std::string path = folder.path("runs.db");
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
};

}  // namespace

TEST_CASE("status: the last run of the store, of a bench, or the one that is named, and what to do next") {
  const StoreOfStatus store;
  const std::string none = "no run is live\nlast run in " + store.path + ":\n";
  const Finished last = store.say({"status", "--db", store.path});
  CHECK(last.code == 0);
  CHECK_THAT(last.out,
             Catch::StartsWith(none + "run 3 on bench 'bench-a' (simulated): incomplete (no process carries it out), 0 "
                                      "frames\n") &&
                 Catch::EndsWith("\nnext: tactbench resume 3 --db " + store.path + "\n"));
  CHECK_THAT(store.say({"status", "--db", store.path, "--bench", "bench-b"}).out,
             Catch::StartsWith(none + "run 2 on bench 'bench-b': failed, 0 frames\n") &&
                 Catch::Contains("TB-X: it broke") &&
                 Catch::EndsWith("\nnext: tactbench resume 2 --db " + store.path + "\n"));
  CHECK_THAT(store.say({"status", "1", "--db", store.path}).out,
             Catch::StartsWith(none + "run 1 on bench 'bench-a' (simulated): completed, 3 frames\n") &&
                 Catch::EndsWith("\nnext: tactbench fit 1 --db " + store.path + "\n"));
  CHECK(store.say({"status", "--db", store.path, "--bench", "bench-c"}).out ==
        "no run is live\nno run in " + store.path + "\n");
  CHECK_THAT(store.say({"status", "9", "--db", store.path}).err, Catch::Contains("[TB-STORE-NOT-FOUND]"));
  CHECK_THAT(store.say({"status", "--db", store.folder.path("none.db")}).err, Catch::Contains("[TB-STORE-OPEN]"));
  const auto told = nlohmann::json::parse(store.say({"status", "--db", store.path, "--json"}).out);
  CHECK(told.at("live") == false);
  CHECK(told.at("runs").empty());
  CHECK(told.at("silent").empty());
  CHECK(told.at("last_run").at("run") == 3);
  CHECK(told.at("last_run").at("lives") == false);
  CHECK(nlohmann::json::parse(store.say({"status", "--db", store.path, "--bench", "bench-c", "--json"}).out)
            .at("last_run")
            .is_null());
}

TEST_CASE("watch: of a named run that has ended it says how, with that run's exit code") {
  const StoreOfStatus store;
  const Finished completed = store.say({"watch", "1", "--db", store.path});
  CHECK(completed.code == 0);
  CHECK_THAT(completed.out, Catch::StartsWith("run 1 on bench 'bench-a' (simulated): completed, 3 frames\n") &&
                                Catch::EndsWith("\nnext: tactbench fit 1 --db " + store.path + "\n"));
  const Finished failed = store.say({"watch", "2", "--db", store.path});
  CHECK(failed.code == 3);
  CHECK_THAT(failed.out, Catch::StartsWith("run 2 on bench 'bench-b': failed, 0 frames\n"));
  const Finished unnamed = store.say({"watch", "--bench", "no-such-bench", "--db", store.path});
  CHECK(unnamed.code == 2);
  CHECK_THAT(unnamed.err, Catch::StartsWith("error: no live run answers [TB-RUN-NOT-LIVE]\n"));
}

TEST_CASE("run: what is refused before a device is opened, with what would help") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  const auto run = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {
        "run", "equilibration", "--bench", "simulated.toml", "--sensor", "S-9", "--operator", "me", "-q", "--db", path};
    words.insert(words.end(), more.begin(), more.end());
    return verb_here(bench::add_run, words);
  };
  const auto said = [&](const std::vector<std::string>& more, const std::string& error) {
    const Finished refused = run(more);
    CHECK(refused.code == 2);
    CHECK(refused.err == "error: " + error + "\n");
    CHECK(refused.out.empty());
  };
  const std::string unknown =
      "sensor 'S-9' is not registered in '" + path + "' [TB-SENSOR-UNKNOWN]\n  at: --sensor S-9\n";
  said({}, unknown + "  try: tactbench sensors add S-9 --type sensor.toml --db " + path);
  {
    db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
    for (const char* serial : {"S-1", "S-2"}) store.add_sensor({serial, "array", "", "", "", "", kUtc});
  }
  said({}, unknown + "  try: registered: S-1, S-2; or tactbench sensors add");
  CHECK(run({"--meta", "film"}).code == 2);
  CHECK(run({"--set", "x"}).code == 2);
  CHECK_THAT(run({"--rate", "0.05"}).err, Catch::StartsWith("parse: "));
}

TEST_CASE("sensors and remarks: what is said of each, in words and as JSON") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  const Finished added =
      verb_here(bench::add_sensors, {"sensors", "add", "S-7", "--type", "sensor.toml", "--db", path, "--note", "new"});
  CHECK(added.code == 0);
  CHECK_THAT(added.out, Catch::StartsWith("sensor S-7 (") && Catch::EndsWith(") registered in " + path + "\n"));
  const auto told = nlohmann::json::parse(
      verb_here(bench::add_sensors, {"sensors", "add", "S-8", "--type", "sensor.toml", "--db", path, "--json"}).out);
  CHECK(told.at("serial") == "S-8");
  CHECK(verb_here(bench::add_sensors, {"sensors", "show", "S-9", "--db", path}).err ==
        "error: sensor 'S-9' is not registered [TB-SENSOR-UNKNOWN]\n  at: " + path +
            "\n  try: tactbench sensors list shows the registered ones\n");
  {
    db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
    (void)store_example(store);
  }
  const auto remark = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "runs");
    words.insert(words.end(), {"--db", path});
    return verb_here(bench::add_runs, words);
  };
  CHECK(remark({"tag", "1", "b", "a"}).out == "run 1: tags a b\n");
  CHECK(remark({"tag", "1", "b", "--remove"}).out == "run 1: tags a\n");
  CHECK(remark({"tag", "1", "a", "--remove"}).out == "run 1: no tags\n");
  CHECK(remark({"note", "1", "the door was open"}).out == "run 1: noted\n");
  CHECK(nlohmann::json::parse(remark({"tag", "1", "c", "--json"}).out).at("tags") == nlohmann::json({"c"}));
  CHECK_THAT(remark({"note", "1", " "}).err, Catch::Contains("[TB-STORE-BLANK]"));
  CHECK(remark({"void", "1", "--reason", "door", "--by", "K. Lee"}).out ==
        "run 1: void, by K. Lee: door; it is kept\n");
  CHECK_THAT(remark({"note", "9", "x"}).err, Catch::Contains("[TB-STORE-NOT-FOUND]"));
}

TEST_CASE("db: the copy and the schema of a store, and an empty file, which is none") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db"), copy = folder.path("copy.db");
  db::RunStore::open(path, db::Durability::kNormal);
  const Finished taken = verb_here(bench::add_db, {"db", "snapshot", copy, "--db", path});
  CHECK(taken.out ==
        copy + ": snapshot of " + path + ", " + std::to_string(std::filesystem::file_size(copy)) + " bytes\n");
  const auto told =
      nlohmann::json::parse(verb_here(bench::add_db, {"db", "snapshot", copy + "2", "--db", path, "--json"}).out);
  CHECK(told.at("bytes") == std::filesystem::file_size(copy + "2"));
  const std::string now = std::to_string(db::kSchemaVersion);
  CHECK(verb_here(bench::add_db, {"db", "migrate", "--db", path}).out ==
        path + " already has this program's schema " + now + ": nothing was done\n");
  CHECK(nlohmann::json::parse(verb_here(bench::add_db, {"db", "migrate", "--db", path, "--json"}).out).at("backup") ==
        "");
  write_file(folder.path("empty.db"), "");
  CHECK_THAT(verb_here(bench::add_db, {"db", "migrate", "--db", folder.path("empty.db")}).err,
             Catch::Contains("the file is empty [TB-STORE-OPEN]"));
  const Finished sound = verb_here(bench::add_db, {"db", "check", copy});
  CHECK(sound.code == 0);
  CHECK(sound.out == copy + ": structure sound; 0 runs as they were stored, 0 not, 0 not ended (no hash yet)\n");
}

TEST_CASE("model list: nothing yet, and fits of both kinds of summary") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
  (void)store_example(store);
  const auto list = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"model", "list"});
    words.insert(words.end(), {"--db", path});
    return verb_here(bench::add_model, words);
  };
  const std::string head = "model     kind          sensor           taxels  origin     created (UTC)\n";
  CHECK(list({}).out == head + "no models are stored: tactbench fit RUN makes some\n");
  CHECK(list({"1"}).out == head + "run 1 has no models: tactbench fit 1 makes some\n");
  CHECK_THAT(list({"2"}).err, Catch::Contains("[TB-STORE-NOT-FOUND]"));
  for (const int fitted : {5, 6, 0, 0}) (void)store.add_fit({0, 1, "elam", true, fitted, "{}", "", "0.1.0", kUtc});
  const std::string rest = "  simulated  2026-01-01T00:00:00Z\n";
  CHECK(list({}).out == head + "1:1       elam          S-1                   5" + rest +
                            "1:2       elam          S-1                   6" + rest +
                            "1:3       elam          S-1                   0" + rest +
                            "1:4       elam          S-1                   0" + rest);
  const auto told = nlohmann::json::parse(list({"1", "--json"}).out).at("models");
  REQUIRE(told.size() == 4);
  CHECK(told.at(1).at("model") == "1:2");
  CHECK(told.at(1).at("fitted_taxels") == 6);
  CHECK(told.at(1).at("created") == kUtc);
}
