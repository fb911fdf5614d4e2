// runs list and show, where the store examples have nothing: removed frames, checks, events, the simulated specimen.
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

}  // namespace

TEST_CASE("runs list: frames that were removed are counted") {
  StoreOfDetails store;
  (void)store_example(store.store);
  store.store.set_tags(1, {"nightly"}, {});
  (void)store.store.prune_frames(1, "old nights", kUtc);
  CHECK(Told::parse(store.runs({"list", "--json"}).out).at("runs").at(0).at("frames_pruned") == 3);
}

TEST_CASE("runs show: checks with their details") {
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
  const Told told = Told::parse(store.runs({"show", "1", "--json"}).out).at("checks");
  REQUIRE(told.size() == 3);
  CHECK(told.at(0) == Told::parse(R"({"time_s": 1.25, "kind": "tare", "verdict": "pass",
      "detail": {"findings": [{"text": "first"}, {"text": "second"}], "n": 1}})"));
}

TEST_CASE("runs show: events by their time") {
  StoreOfDetails store;
  store.add([](db::RunRecord& run) { run.purpose = "p"; },
            [&](std::int64_t run) {
              store.store.append_event(run, {1'250'000'000, "fault", "TB-X", "one"});
              store.store.append_event(run, {2'500'000'000, "command", "", "two"});
              store.store.append_event(run, {3'000'000'000, "time", "", "three"});
            });
  CHECK(Told::parse(store.runs({"show", "1", "--json"}).out).at("events") ==
        Told::parse(R"([{"time_s": 1.25, "kind": "fault", "id": "TB-X", "detail": "one"},
                        {"time_s": 2.5, "kind": "command", "id": "", "detail": "two"},
                        {"time_s": 3.0, "kind": "time", "id": "", "detail": "three"}])"));
}

TEST_CASE("runs show: the specimen of a simulated run") {
  StoreOfDetails store;
  const auto fill = [](db::RunRecord& run) {
    run.bench_toml = bench_text("simulated") + "[simulation]\nspecimen = \"harsh\"\n";
    run.overrides_json = "[]";
    run.sequences = {{0, "a", "", "123456789012345", 1, 1}, {1, "b", "", "", 1, 2}};
    run.devices = {{"reference gauge", "G-1", "", "", "simulated", R"({"certificate":"C-1","due":"2024-01-31"})"}};
  };
  store.add(fill);
  store.store.set_tags(1, {"lot=A7", "night"}, {});
  CHECK(store.runs({"show", "1"}).code == 0);
  CHECK(Told::parse(store.runs({"show", "1", "--json"}).out).at("specimen") == "harsh");
  store.add([&](db::RunRecord& run) {
    fill(run);
    run.origin = "hardware";
  });
  CHECK_FALSE(Told::parse(store.runs({"show", "2", "--json"}).out).contains("specimen"));
  store.add([&](db::RunRecord& run) {
    fill(run);
    run.bench_toml = bench_text("hardware");
  });
  CHECK_FALSE(Told::parse(store.runs({"show", "3", "--json"}).out).contains("specimen"));
}

TEST_CASE("runs: a verb and its number are needed") {
  const StoreOfDetails store;
  CHECK(store.runs({}).code == 2);
}
