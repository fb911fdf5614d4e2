// Stores put together that are written by hand: parts of a night become one, runs are taken once, and what does not
// belong together is refused in words.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/common/error.h"
#include "bench/nightly/night_store.h"
#include "db/sqlite.h"
#include "tests/bench/nightly/part_store.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

class MergedByHand {
 public:
  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path(name + ".db"); }
  PartStore part(const std::string& name) const { return PartStore(path(name)); }
  MergedStores merge(const std::vector<std::string>& names) {
    std::vector<std::string> paths;
    for (const std::string& name : names) paths.push_back(path(name));
    return merge_stores(paths, store);
  }
  // "id what place"; a refusal always says what to do.
  [[nodiscard]] std::string refusal(const std::vector<std::string>& names) {
    try {
      (void)merge(names);
    } catch (const Error& error) {
      CHECK((error.code() == ExitCode::kUsage && !error.remedy().empty()));
      return fmt::format("{} {} {}", error.id(), error.what(), error.where());
    } catch (const db::StoreError& error) {
      CHECK_FALSE(std::string(error.remedy()).empty());
      return fmt::format("{} {}", error.id(), error.what());
    }
    return "merged";
  }
  void check_refused(const std::vector<std::string>& names, const std::string& id,
                     const std::vector<std::string>& parts) {
    const std::string said = refusal(names);
    INFO(said);
    CHECK(said.starts_with(id + " "));
    for (const std::string& part : parts) CHECK(said.find(part) != std::string::npos);
  }
  // runs, those there, fits, baselines, nights
  static std::string counts(const MergedStores& merged) {
    return fmt::format("{} {} {} {} {}", merged.runs, merged.there, merged.fits, merged.baselines,
                       merged.nights.size());
  }

 private:
  TemporaryFolder folder_;

 public:
  db::RunStore store = db::RunStore::open(path("main"), db::Durability::kNormal);
};

// Three scenarios in two parts, "one" and "three" in the first, and one of two runs.
void write_parts(const MergedByHand& made) {
  PartStore second = made.part("b"), first = made.part("a");
  const ScenarioResult two = second.add_result("two", {21}, {{"b_psi", 2.5}});
  second.add_night(2, 2, "2026-01-02T00:30:00Z", "2026-01-02T02:00:00Z", "program b", {{1, two}});
  const ScenarioResult one = first.add_result("one", {11, 12}, {{"a_psi", 1.5}});
  ScenarioResult three = first.add_result("three", {31}, {{"c_psi", 3.5}});
  three.wrong = {"it is red"};
  first.add_night(1, 2, "2026-01-02T01:00:00Z", "2026-01-02T01:30:00Z", "program a", {{0, one}, {2, three}});
}

}  // namespace

TEST_CASE("merge: parts of a night give the whole night in the order of the suite, only once") {
  MergedByHand made;
  write_parts(made);
  const MergedStores merged = made.merge({"b", "a"});
  CHECK(MergedByHand::counts(merged) == "4 0 0 0 1");
  const MergedNight& night = merged.nights[0];
  CHECK_FALSE(night.there);
  CHECK(night.record.shard == 1);
  CHECK(night.record.shards == 1);
  CHECK(night.record.begun_utc == "2026-01-02T00:30:00Z");
  CHECK(night.record.ended_utc == "2026-01-02T02:00:00Z");
  CHECK(night.record.program == "program a; program b");
  CHECK(night.suite.scenarios.size() == 3);
  REQUIRE(night.results.size() == 3);
  std::string results;
  for (const ScenarioResult& result : night.results)
    results += fmt::format("{} {}; ", result.name, result.runs.front().run);
  CHECK(results == "one 1; two 3; three 4; ");
  CHECK(night.results[2].wrong == std::vector<std::string>{"it is red"});
  REQUIRE(night.followed.size() == 3);
  CHECK(night.followed[1].subject == "nightly/two");
  CHECK(night.followed[1].figures[0].values == std::vector<double>{2.5});
  std::vector<std::int64_t> seeds;
  for (const db::RunRecord& run : made.store.runs()) seeds.push_back(run.seed);
  CHECK(seeds == std::vector<std::int64_t>{11, 12, 21, 31});
  CHECK(made.store.figures_of(4, "nightly/three") == std::map<std::string, double>{{"c_psi", 3.5}});
  REQUIRE(made.store.nights().size() == 1);
  CHECK(made.store.nights()[0].results[2].first_run == 4);
  const MergedStores again = made.merge({"a", "b"});
  CHECK(MergedByHand::counts(again) == "0 4 0 0 1");
  CHECK(again.nights[0].there);
  CHECK(made.store.nights().size() == 1);
}

TEST_CASE("merge: whole nights of several stores are ordered by start time") {
  MergedByHand made;
  {
    PartStore late = made.part("late"), early = made.part("early");
    late.add_night(1, 1, "2026-01-05T00:00:00Z", "2026-01-05T01:00:00Z", "p",
                   {{0, late.add_result("one", {1}, {{"a_psi", 1.0}})}});
    early.add_night(1, 1, "2026-01-03T00:00:00Z", "2026-01-03T01:00:00Z", "p",
                    {{0, early.add_result("one", {1}, {{"a_psi", 1.0}})}});
    late.add_night(1, 1, "2026-01-04T00:00:00Z", "2026-01-04T01:00:00Z", "p",
                   {{0, late.add_result("one", {1}, {{"a_psi", 1.0}})}});
  }
  const MergedStores merged = made.merge({"late", "early"});
  CHECK(MergedByHand::counts(merged) == "3 0 0 0 3");
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(merged.nights[i].record.begun_utc == fmt::format("2026-01-{:02}T00:00:00Z", 3 + i));
    CHECK(merged.nights[i].results[0].compared.ends_with(i == 0 ? "seed" : fmt::format("run {}", i)));
  }
}

TEST_CASE("merge: a night with missing or duplicate parts is rejected, and nothing is copied") {
  MergedByHand made;
  write_parts(made);
  made.check_refused({"a"}, "TB-MERGE-SHARD", {"parts", ": 2", made.path("a")});
  {
    PartStore copy = made.part("copy");
    copy.add_night(2, 2, "2026-01-02T00:30:00Z", "2026-01-02T02:00:00Z", "p", {});
  }
  made.check_refused({"a", "b", "copy"}, "TB-MERGE-SHARD", {"2 of 2", made.path("b"), made.path("copy")});
  {
    PartStore five = made.part("five");
    five.add_night(3, 5, "2026-01-02T00:30:00Z", "2026-01-02T02:00:00Z", "p", {});
  }
  made.check_refused({"a", "b", "five"}, "TB-MERGE-SHARD", {"1, 2, 4, 5"});
  CHECK(made.store.runs().empty());
  CHECK(made.store.nights().empty());
}

TEST_CASE("merge: a store merged into itself or named twice is rejected, whatever the path") {
  MergedByHand made;
  write_parts(made);
  made.check_refused({"a", "main"}, "TB-USAGE", {made.path("main")});
  made.check_refused({"a", "b", "a"}, "TB-USAGE", {made.path("a")});
  std::filesystem::create_symlink(made.path("b"), made.path("link"));
  made.check_refused({"b", "link"}, "TB-USAGE", {made.path("link")});
  made.check_refused({"none"}, "TB-STORE-OPEN", {});
}

TEST_CASE("merge: altered results are rejected with store and night") {
  MergedByHand made;
  const auto damaged = [&](const std::string& name, const std::string& label, const std::string& stored) {
    PartStore part = made.part(name);
    db::NightRecord night = part_night("2026-01-02T00:00:00Z", "2026-01-02T00:00:00Z");
    night.results.push_back({0, label, stored, 0});
    (void)part.store.add_night(night);
    return made.refusal({name});
  };
  CHECK_THAT(damaged("x", "one", "{}"),
             Catch::StartsWith("TB-STORE-SQL ") && Catch::Contains(made.path("x")) && Catch::Contains("night 1"));
  ScenarioResult other;
  other.name = "four";
  CHECK_THAT(damaged("y", "four", to_json(other)),
             Catch::StartsWith("TB-STORE-SQL ") && Catch::Contains(made.path("y")) && Catch::Contains("four"));
}

TEST_CASE("merge: runs outside nights come first, and two contents under one UUID are rejected") {
  MergedByHand made;
  write_parts(made);
  std::string uuid;
  {
    PartStore bench = made.part("bench");
    uuid = bench.store.run(bench.add_run("by hand", 5)).uuid;
    (void)bench.add_run("by hand", 6);
  }
  const MergedStores merged = made.merge({"a", "b", "bench"});
  CHECK(MergedByHand::counts(merged) == "6 0 0 0 1");
  CHECK(made.store.run(1).purpose == "by hand");
  CHECK(made.store.run(3).purpose == "nightly: one");
  {
    PartStore other = made.part("other");
    (void)other.add_run("by hand", 9, 8, uuid);
  }
  made.check_refused({"other"}, "TB-STORE-CONFLICT", {"run 1", made.path("other"), made.path("main"), uuid});
}

TEST_CASE("merge: baselines get the new run numbers, and each acceptance is stored once") {
  MergedByHand made;
  {
    PartStore a = made.part("a"), b = made.part("b");
    for (const std::int64_t seed : {1, 2}) a.store.replace_figures(a.add_run("x", seed), "rig/x", {{"d_psi", 0.5}});
    for (const std::int64_t seed : {3, 4}) b.store.replace_figures(b.add_run("x", seed), "rig/x", {{"d_psi", 0.5}});
    b.store.copy_baseline({0, "rig/x", "as made", "K. Lee", "2026-01-01T00:00:00Z", {1, 2}});
    b.store.copy_baseline({0, "rig/x", "again", "K. Lee", "2026-01-01T00:00:00Z", {2}});
  }
  CHECK(MergedByHand::counts(made.merge({"a", "b"})) == "4 0 0 2 0");
  const std::vector<db::BaselineRecord> baselines = made.store.baselines();
  REQUIRE(baselines.size() == 2);
  CHECK(baselines[0].runs == std::vector<std::int64_t>{3, 4});
  CHECK(baselines[1].runs == std::vector<std::int64_t>{4});
  CHECK(baselines[0].reason == "as made");
  CHECK(MergedByHand::counts(made.merge({"a", "b"})) == "0 4 0 0 0");
  const auto differs = [&](const std::string& name, const db::BaselineRecord& baseline) {
    {
      PartStore c = made.part(name);
      (void)c.store.copy_runs_from(made.store, {3, 4});
      c.store.copy_baseline(baseline);
    }
    return made.merge({name}).baselines;
  };
  CHECK(differs("c0", {0, "rig/x", "as made", "K. Lee", "2026-01-01T00:00:00Z", {1, 2}}) == 0);
  CHECK(differs("c1", {0, "rig/y", "as made", "K. Lee", "2026-01-01T00:00:00Z", {1, 2}}) == 1);
  CHECK(differs("c2", {0, "rig/x", "as made, too", "K. Lee", "2026-01-01T00:00:00Z", {1, 2}}) == 1);
  CHECK(differs("c3", {0, "rig/x", "as made", "B. Lee", "2026-01-01T00:00:00Z", {1, 2}}) == 1);
  CHECK(differs("c4", {0, "rig/x", "as made", "K. Lee", "2026-01-01T00:00:01Z", {1, 2}}) == 1);
  CHECK(differs("c5", {0, "rig/x", "as made", "K. Lee", "2026-01-01T00:00:00Z", {1}}) == 1);
  {
    PartStore turned = made.part("turned");  // its run 1 is run 4 here
    for (const std::int64_t run : {4, 3}) (void)turned.store.copy_runs_from(made.store, {run});
    turned.store.copy_baseline({0, "rig/x", "as made", "K. Lee", "2026-01-01T00:00:00Z", {1, 2}});
  }
  CHECK(made.merge({"turned"}).baselines == 0);
}
