// runs list and show, where the store examples have nothing: columns that are full, tables of many recipes, checks with
// findings or figures, events by their time, instruments with certificates, the simulated specimen.
#include <catch2/catch.hpp>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/bench/cli/verb_here.h"
#include "tests/bench/config/bench_text.h"
#include "tests/db/store_example.h"

using namespace tactbench;
using namespace tactbench::tests;
using Told = nlohmann::ordered_json;

namespace {

struct StoreOfDetails {
  Finished runs(std::vector<std::string> words) const {
    words.insert(words.begin(), "runs");
    words.insert(words.end(), {"--db", path});
    return verb_here(bench::add_runs, words);
  }
  // A run without frames, with what `fill` adds before its end.
  std::int64_t add(
      const std::function<void(db::RunRecord&)>& change,
      const std::function<void(std::int64_t)>& fill = [](std::int64_t) {}) {
    db::RunRecord run = example_run();
    run.purpose = "p";
    change(run);
    const std::int64_t number = begin_example(store, run).run;
    fill(number);
    store.end_run(number, db::Outcome::kCompleted, "done", db::SafeState::kVerified, kUtc);
    return number;
  }
  TemporaryFolder folder;
  std::string path = folder.path("runs.db");
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
};

std::string head_of_list() {
  return "  run  started (UTC)        sensor      outcome       frames  verdict                     origin     "
         "recipe; purpose [tags]\n";
}

}  // namespace

TEST_CASE("runs list: each column, and the first three of many recipes") {
  StoreOfDetails store;
  store.add([](db::RunRecord& run) {
    run.sequences = {{0, "a", "", "", 1, 1}, {1, "b", "", "", 1, 1}, {2, "c", "", "", 1, 1}};
  });
  const std::int64_t many = store.add([](db::RunRecord& run) {
    run.sequences = {{0, "a", "", "", 1, 1},
                     {1, "b", "", "", 1, 1},
                     {2, "c", "", "", 1, 1},
                     {3, "d", "", "", 1, 1},
                     {4, "e", "", "", 1, 1}};
    run.purpose = "";
    run.origin = "hardware";
    run.started_utc = "2024-05-01T09:00:00.123456Z";
  });
  store.store.set_tags(many, {"lot=A7", "night"}, {});
  const std::string found = store.runs({"list"}).out;
  CHECK(found == head_of_list() +
                     "    1  2024-05-01T09:00:00Z S-1         completed          0  -                           "
                     "simulated  a, b, c; p\n"
                     "    2  2024-05-01T09:00:00… S-1         completed          0  -                           "
                     "hardware   a, b, c and 2 more [lot=A7 night]\n");
  CHECK(store.runs({"list", "--sensor", "S-2"}).out == head_of_list() + "no stored run has all that was asked for\n");
  CHECK(store.runs({"list", "--tag", "night"}).out == head_of_list() + found.substr(found.find("    2  ")));
  CHECK(store.runs({"list", "--lot", "A8"}).out == head_of_list() + "no stored run has all that was asked for\n");
  const StoreOfDetails empty;
  CHECK(empty.runs({"list"}).out == head_of_list() + "no runs are stored: tactbench run stores one\n");
}

TEST_CASE("runs list: frames that were removed are counted") {
  StoreOfDetails store;
  (void)store_example(store.store);
  store.store.set_tags(1, {"nightly"}, {});
  (void)store.store.prune_frames(1, "old nights", kUtc);
  CHECK_THAT(store.runs({"list"}).out, Catch::Contains("(3 frames removed)\n"));
  CHECK(Told::parse(store.runs({"list", "--json"}).out).at("runs").at(0).at("frames_pruned") == 3);
}

TEST_CASE("runs show: checks by their findings, or else by their figures") {
  StoreOfDetails store;
  store.add([](db::RunRecord& run) { run.purpose = "p"; },
            [&](std::int64_t run) {
              const auto check = [&](std::int64_t time, const char* detail) {
                store.store.append_check(run, {run, time, "tare", "pass", detail, {}});
              };
              check(1'250'000'000, R"({"findings":[{"text":"first"},{"text":"second"}],"n":1})");
              check(2'000'000'000, R"({"mean":0.123456,"rows":3,"name":"x","list":[],"tree":{},"some":[1]})");
              check(3'000'000'000, R"({"findings":[]})");
            });
  CHECK_THAT(store.runs({"show", "1"}).out,
             Catch::EndsWith("  check             1.250 s  tare pass: first; second\n"
                             "  check             2.000 s  tare pass: mean 0.1235, rows 3, name \"x\", some [1]\n"
                             "  check             3.000 s  tare pass: \n"));
  const Told told = Told::parse(store.runs({"show", "1", "--json"}).out).at("checks");
  REQUIRE(told.size() == 3);
  CHECK(told.at(0) == Told::parse(R"({"time_s": 1.25, "kind": "tare", "verdict": "pass",
      "detail": {"findings": [{"text": "first"}, {"text": "second"}], "n": 1}})"));
}

TEST_CASE("runs show: events by their time, commands and readings only when they are asked for") {
  StoreOfDetails store;
  store.add([](db::RunRecord& run) { run.purpose = "p"; },
            [&](std::int64_t run) {
              store.store.append_event(run, {1'250'000'000, "fault", "TB-X", "one"});
              store.store.append_event(run, {2'500'000'000, "command", "", "two"});
              store.store.append_event(run, {3'000'000'000, "time", "", "three"});
            });
  const std::string fault = "  event             1.250 s  fault TB-X one\n";
  CHECK_THAT(store.runs({"show", "1"}).out,
             Catch::EndsWith("  frames        0\n" + fault +
                             "  events        2 more, of commands and readings: runs show 1 --events\n"));
  CHECK_THAT(store.runs({"show", "1", "--events"}).out,
             Catch::EndsWith("  frames        0\n" + fault +
                             "  event             2.500 s  command  two\n  event             3.000 s  time  three\n"));
  CHECK(Told::parse(store.runs({"show", "1", "--json"}).out).at("events") ==
        Told::parse(R"([{"time_s": 1.25, "kind": "fault", "id": "TB-X", "detail": "one"},
                        {"time_s": 2.5, "kind": "command", "id": "", "detail": "two"},
                        {"time_s": 3.0, "kind": "time", "id": "", "detail": "three"}])"));
  const std::int64_t one = store.add([](db::RunRecord& run) { run.purpose = "p"; },
                                     [&](std::int64_t run) {
                                       store.store.append_event(run, {0, "command", "", "two"});
                                     });
  CHECK_THAT(store.runs({"show", std::to_string(one)}).out, Catch::Contains("  events        1 more, of "));
}

TEST_CASE("runs show: certificates of instruments, tags, long hashes and the simulated specimen") {
  StoreOfDetails store;
  const auto fill = [](db::RunRecord& run) {
    run.bench_toml = bench_text("simulated") + "[simulation]\nspecimen = \"harsh\"\n";
    run.overrides_json = "[]";
    run.sequences = {{0, "a", "", "123456789012345", 1, 1}, {1, "b", "", "", 1, 2}};
    run.devices = {{"reference gauge", "G-1", "", "", "simulated", R"({"certificate":"C-1","due":"2024-01-31"})"}};
  };
  store.add(fill);
  store.store.set_tags(1, {"lot=A7", "night"}, {});
  const std::string shown = store.runs({"show", "1"}).out;
  CHECK_THAT(
      shown,
      Catch::Contains("\n  sensor        S-1, scanner SC-7\n  specimen      harsh\n  operator ") &&
          Catch::Contains("\n  tags          lot=A7 night\n") &&
          Catch::Contains(
              "\n  recipe        a: 1 x 1 frame (sha256 123456789012)\n  recipe        b: 1 x 2 frames (sha256 )\n") &&
          Catch::Contains("\n  device        reference gauge: G-1, serial not stated, simulated\n"
                          "                certificate C-1, OVERDUE since 2024-01-31\n"));
  CHECK(Told::parse(store.runs({"show", "1", "--json"}).out).at("specimen") == "harsh");
  store.add([&](db::RunRecord& run) {
    fill(run);
    run.origin = "hardware";
  });
  CHECK_THAT(store.runs({"show", "2"}).out, !Catch::Contains("specimen"));
  store.add([&](db::RunRecord& run) {
    fill(run);
    run.bench_toml = bench_text("hardware");
  });
  CHECK_THAT(store.runs({"show", "3"}).out, !Catch::Contains("specimen"));
}

TEST_CASE("runs show: verdicts on models of a run and by several limits, each in its own table") {
  StoreOfDetails store;
  for (int i = 0; i < 2; ++i) (void)store_example(store.store);
  const auto row = [](const char* verdict, const std::string& limits, double value) {
    return db::VerdictRecord{0, 0, "mismatch", "40 psi up", value, 0.05, "FS", "simple", verdict, "limits", limits};
  };
  const std::string first = "1234567890123", second = "2234567890123";
  store.store.replace_verdicts(2, 0, {row("pass", first, 0.01), row("pass", first, 0.02)});
  store.store.replace_verdicts(2, 0, {row("inconclusive", second, 0.05)});
  const std::string page = store.runs({"show", "2"}).out;
  const std::string head =
      "  run  requirement                scope                       value  tolerance limit  verdict\n";
  const auto line = [](const char* value, const char* verdict) {
    return std::string("    2  non-uniformity             40 psi increasing          ") + value +
           " % FS           5 % FS  simulated " + verdict + "\n";
  };
  const std::string rule = "decision rule (ILAC-G8): simple\n";
  CHECK_THAT(page, Catch::EndsWith("\nverdict: simulated inconclusive\n\nmodels of no stored run, limits sha256 "
                                   "123456789012\n" +
                                   head + line("1", "pass") + line("2", "pass") + rule +
                                   "\nmodels of no stored run, limits sha256 223456789012\n" + head +
                                   line("5", "inconclusive") + rule));
}

TEST_CASE("runs: a verb and its number are needed") {
  const StoreOfDetails store;
  CHECK(store.runs({}).code == 2);
  CHECK_THAT(store.runs({"show"}).err, Catch::Contains("run is required"));
  CHECK_THAT(store.runs({"show", "0"}).err, Catch::Contains("has no run 0"));
}
