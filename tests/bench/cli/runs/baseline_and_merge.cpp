// What trend accept, runs merge and nightly make of stores, and what they refuse where those lack what they need.
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/cli/store_here.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

struct StoreOfFigures : StoreHere {
  // Run after run, with its own content, and this figure of the subject.
  void add(const std::string& subject, std::size_t count) {
    db::RunStore store = open();
    for (std::size_t i = 0; i < count; ++i) {
      db::RunRecord run = example_run();
      run.seed = ++seed_;
      store.replace_figures(store_example(store, run), subject, {{"error_psi", 0.25 * static_cast<double>(seed_)}});
    }
  }
  Finished accept(std::vector<std::string> runs, const std::vector<std::string>& more = {}) const {
    runs.insert(runs.begin(), {"trend", "accept", "--db", path, "--by", "K. Lee", "--reason", "as made"});
    runs.insert(runs.end(), more.begin(), more.end());
    return verb_here(bench::add_trend, runs);
  }

 private:
  std::int64_t seed_ = 0;
};

}  // namespace

TEST_CASE("trend accept: what is no run or range is refused, and so are runs without figures") {
  StoreOfFigures store;
  store.add("rig/a", 1);
  {
    db::RunStore open = store.open();
    store_example(open);  // run 2, without figures
  }
  for (const char* word :
       {"0", "-1", "1-", "1-0", "x", "1x", "1-2x", "1-2-3", "5-4", " 1", "1 ", "99999999999999999999"}) {
    INFO(word);
    check_refusal(store.accept({"--", word}), 2, "TB-USAGE", "RUNS");
  }
  for (const char* runs : {"2", "2-99"}) {
    const Finished refused = store.accept({runs});
    CHECK(refused.code == 2);
    CHECK_THAT(refused.err, Catch::Contains("[TB-BASELINE-NO-FIGURES]"));
    CHECK(refused.out.empty());
  }
  CHECK_THAT(store.accept({"99"}).err, Catch::Contains("[TB-STORE-NOT-FOUND]"));
  CHECK_THAT(store.accept({"1"}).err, Catch::Contains("[TB-BASELINE-SHORT]"));
  store.open().void_run(2, "by hand", "K. Lee", kUtc);
  CHECK_THAT(store.accept({"2"}).err, Catch::Contains("[TB-RUN-VOID]"));
  CHECK(store.accept({"2", "--void-too"}).code == 2);
  CHECK(store.told<nlohmann::json>(bench::add_trend, {"trend", "baselines"}).at("baselines").empty());
}

TEST_CASE("trend accept: each subject has its own runs of a range") {
  StoreOfFigures store;
  store.add("rig/a", 8);          // runs 1 to 8
  store.add("nightly/short", 7);  // 9 to 15
  const Finished refused = store.accept({"1-15"});
  CHECK_THAT(refused.err, Catch::Contains("[TB-BASELINE-SHORT]"));
  const auto alone = nlohmann::json::parse(store.accept({"1-15"}, {"--subject", "rig/", "--json"}).out).at("baselines");
  CHECK((alone.size() == 1 && alone.at(0).at("subject") == "rig/a"));
  store.add("nightly/short", 1);  // 16
  CHECK(store.accept({"1-8", "9-16", "3"}).code == 0);
  store.add("rig/a", 12);  // 17 to 28
  CHECK(store.accept({"1-8", "17-27"}).code == 0);
  const nlohmann::json told = nlohmann::json::parse(store.accept({"1-8", "17-28"}, {"--json"}).out);
  CHECK(told.at("store") == store.path);
  REQUIRE(told.at("baselines").size() == 1);
  const nlohmann::json& one = told.at("baselines").at(0);
  check_members(one, R"({"baseline": 5, "subject": "rig/a", "counted": 20})");
  CHECK(one.at("runs").size() == 20);
  CHECK(one.at("runs").at(8) == 17);
  const auto listed = store.told<nlohmann::json>(bench::add_trend, {"trend", "baselines"});
  CHECK(listed.at("baselines").size() == 5);
  CHECK(listed.at("baselines").at(0).at("accepted_by") == "K. Lee");
  CHECK(listed.at("baselines").at(0).at("reason") == "as made");
}

TEST_CASE("runs merge: stores without a night give no file of one, and what came is told") {
  StoreOfFigures store, other;
  store.add("rig/a", 2);
  other.add("rig/a", 1);
  const std::string all = store.folder.path("all.db");
  const auto merge = [&](const std::vector<std::string>& more) {
    return verb_here(bench::add_runs, joined_words({"runs", "merge", store.path, other.path, "--db", all}, more));
  };
  for (const char* file : {"--html", "--junit", "--metrics"}) {
    const std::string target = store.folder.path("night");
    check_refusal(merge({file, target}), 2, "TB-MERGE-NIGHT");
    CHECK_FALSE(std::filesystem::exists(target));
    std::filesystem::remove(all);
  }
  CHECK(merge({}).code == 0);
  const nlohmann::json told = nlohmann::json::parse(merge({"--json"}).out);
  CHECK(told.at("parts") == nlohmann::json({store.path, other.path}));
  CHECK(told.at("nights").empty());
  CHECK(told.at("there") == 3);
}

TEST_CASE("nightly: one part of a night needs a store of its own, and no page") {
  StoreOfFigures store;
  store.add("rig/a", 1);
  const std::string suite = store.folder.path("suite.toml");
  write_file(suite,
             "schema = 1\nname = \"s\"\n[[scenario]]\nname = \"a\"\nabout = \"b\"\n[[scenario]]\nname = \"c\"\n"
             "about = \"d\"\nseed = 5\n");
  const auto night = [&](const std::vector<std::string>& more) {
    return verb_here(bench::add_nightly, joined_words({"nightly", suite}, more));
  };
  const auto refused = [&](const std::vector<std::string>& more, const std::string& id) {
    const Finished finished = night(more);
    check_refusal(finished, 2, id);
    CHECK(finished.out.empty());
  };
  refused({"--shard", "1/2"}, "TB-USAGE");
  refused({"--shard", "1/2", "--db", store.path, "--html", "x.html"}, "TB-USAGE");
  refused({"--shard", "1/2", "--db", store.path}, "TB-SHARD-STORE");
  CHECK_THAT(night({"--list", "--only", "x"}).err, Catch::Contains("[TB-NIGHTLY-SCENARIO]"));
  const nlohmann::json listed = nlohmann::json::parse(night({"--list", "--json", "--seed", "9", "--seeds", "3"}).out);
  CHECK(listed.at("schema") == "tactbench.nightly.list");
  CHECK(listed.at("suite") == "s");
  REQUIRE(listed.at("scenarios").size() == 2);
  CHECK(listed.at("scenarios").at(0) == nlohmann::json::parse(R"({"name": "a", "about": "b", "seed": 1})"));
  CHECK(listed.at("scenarios").at(1) == nlohmann::json::parse(R"({"name": "c", "about": "d", "seed": 5})"));
}
