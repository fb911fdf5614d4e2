// verify and verify of runs without models: as stored, changed, pruned, not ended.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "db/sqlite.h"
#include "tests/bench/cli/store_here.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

struct StoreToVerify : OpenStoreHere {
  StoreToVerify() { (void)store_example(store); }
  Finished verify() const { return say(bench::add_verify, {"verify", "1"}); }
  [[nodiscard]] nlohmann::json verify_result() const {
    return printed<nlohmann::json>(bench::add_verify, {"verify", "1"});
  }
  void change(const char* sql) const { db::sqlite::Connection(path, db::sqlite::Access::kReadWrite).execute(sql); }
  [[nodiscard]] std::string hash() const { return store.run(1).content_sha256; }
};

}  // namespace

TEST_CASE("verify: an unchanged stored run passes") {
  const StoreToVerify store;
  CHECK(store.verify().code == 0);
  const nlohmann::json printed = store.verify_result();
  check_members(printed, R"({"run": 1, "origin": "simulated", "holds": true})");
  CHECK(printed.at("pruned").is_null());
  CHECK(printed.at("first_difference") == "");
  CHECK(printed.at("content") ==
        nlohmann::json{
            {"holds", true}, {"frames", 3}, {"stored_sha256", store.hash()}, {"computed_sha256", store.hash()}});
  CHECK(printed.at("beside").empty());
  CHECK(printed.at("analysis").empty());
  CHECK_THAT(verb_here(bench::add_verify, {"verify", "x", "--db", store.path}).err, Catch::Contains("[TB-USAGE]"));
}

TEST_CASE("verify: exit code 5 for changed content or a changed approval") {
  StoreToVerify store;
  store.store.add_report({1, "1-a", "h", "K. Lee", kUtc, "", ""});
  store.change("UPDATE reports SET approved_by = 'B'");
  CHECK(store.verify().code == 5);
  CHECK(store.verify_result().at("beside").size() == 1);
  store.change("UPDATE frames SET status = 9 WHERE frame = (SELECT min(frame) FROM frames)");
  CHECK(store.verify().code == 5);
  const nlohmann::json printed = store.verify_result();
  CHECK(printed.at("holds") == false);
  CHECK(printed.at("content").at("holds") == false);
  CHECK(printed.at("content").at("computed_sha256") != store.hash());
}

TEST_CASE("verify: exit code 6 for a run with pruned frames, a run that has not ended is rejected") {
  StoreToVerify store;
  store.store.set_tags(1, {"nightly"}, {});
  (void)store.store.prune_frames(1, "old nights", kUtc);
  CHECK(store.verify().code == 6);
  const nlohmann::json printed = store.verify_result();
  CHECK(printed.at("pruned") == nlohmann::json{{"frames", 3}, {"rule", "old nights"}, {"pruned_utc", kUtc}});
  store.change("UPDATE runs SET seed = 8");
  CHECK(store.verify().code == 5);
  (void)begin_example(store.store);
  check_refusal(verb_here(bench::add_verify, {"verify", "2", "--db", store.path}), 6, "TB-VERIFY-NOT-ENDED");
}

// runs diff: trees compared with words, settings without a key, tags and checks, and the first count that differs.

namespace {

struct PairOfRuns : OpenStoreHere {
  std::int64_t add(const std::function<void(db::RunRecord&)>& change,
                   const std::function<void(db::FrameRecord&)>& change_frame = {}, const char* verdict = "pass") {
    db::RunRecord run = example_run();
    change(run);
    const Begun begun = begin_example(store, run);
    if (change_frame) {
      db::FrameRecord frame = example_frame(begun.branch, 0);
      change_frame(frame);
      store.append_frame(begun.run, frame);
    }
    store.append_check(begun.run, {begun.run, 4, "seating", verdict, "{}", {}});
    store.end_run(begun.run, db::Outcome::kCompleted, "", db::SafeState::kVerified, kUtc);
    return begun.run;
  }
  std::int64_t add_settings(const char* overrides) {
    return add([&](db::RunRecord& run) { run.overrides_json = overrides; });
  }
  std::int64_t add_frame(const std::function<void(db::FrameRecord&)>& change) {
    return add([](db::RunRecord&) {}, change);
  }
  Finished diff(std::int64_t first, std::int64_t second, const std::vector<std::string>& more = {}) const {
    return verb_here(
        bench::add_runs,
        joined_arguments({"runs", "diff", std::to_string(first), std::to_string(second), "--db", path}, more));
  }
  [[nodiscard]] nlohmann::json printed(std::int64_t first, std::int64_t second) const {
    return nlohmann::json::parse(diff(first, second, {"--json"}).out);
  }
  // As "what: first | second", without the hashes.
  [[nodiscard]] std::string differences(std::int64_t first, std::int64_t second) const {
    std::string text;
    const nlohmann::json found = printed(first, second).at("differences");
    for (const nlohmann::json& one : found)
      if (one.at("what") != "content_sha256")
        text += one.at("what").get<std::string>() + ": " + one.at("first").get<std::string>() + " | " +
                one.at("second").get<std::string>() + "\n";
    return text;
  }
};

}  // namespace

TEST_CASE("runs diff: compares settings of different types: object, list, text and none") {
  PairOfRuns runs;
  const std::int64_t none = runs.add_settings("[]");
  const std::int64_t tree = runs.add_settings(R"([{"key":"a","value":{"x":1}}])");
  const std::int64_t word = runs.add_settings(R"([{"key":"a","value":"s"}])");
  const std::int64_t list = runs.add_settings(R"([{"key":"a","value":[1]}])");
  const std::int64_t other = runs.add_settings(R"([{"key":5,"value":"s"},{"key":"b"}])");
  CHECK(runs.differences(none, tree) == "overrides.a.x: nothing | 1\n");
  CHECK(runs.differences(tree, none) == "overrides.a.x: 1 | nothing\n");
  CHECK(runs.differences(tree, word) == "overrides.a: {\"x\":1} | s\n");
  CHECK(runs.differences(word, tree) == "overrides.a: s | {\"x\":1}\n");
  CHECK(runs.differences(list, word) == "overrides.a: [1] | s\n");
  CHECK(runs.differences(word, list) == "overrides.a: s | [1]\n");
  CHECK(runs.differences(none, other).empty());
}

TEST_CASE("runs diff: a tag or a check counts as a difference if content and frames are equal") {
  PairOfRuns runs;
  const auto same = [](db::RunRecord&) {};
  const std::int64_t first = runs.add(same), second = runs.add(same), third = runs.add(same, {}, "warning");
  CHECK(runs.diff(first, second).code == 0);
  runs.store.set_tags(second, {"night"}, {});
  CHECK(runs.diff(first, second).code == 1);
  CHECK(runs.differences(first, second) == "tags: [] | [\"night\"]\n");
  CHECK(runs.differences(first, third) == "checks[0]: seating pass | seating warning\n");
  const std::int64_t open = begin_example(runs.store).run, more = begin_example(runs.store).run;
  CHECK(runs.diff(open, more).code == 1);  // without a hash
}

TEST_CASE("runs diff: compares each value of a frame") {
  PairOfRuns runs;
  const std::int64_t first = runs.add_frame([](db::FrameRecord&) {});
  CHECK(runs.diff(first, runs.add_frame([](db::FrameRecord&) {})).code == 0);
  const std::vector<std::function<void(db::FrameRecord&)>> changes = {
      [](db::FrameRecord& f) { f.ordinal = 2; },
      [](db::FrameRecord& f) { f.setpoint_psi = 1.5; },
      [](db::FrameRecord& f) { f.reference_psi = 0.25; },
      [](db::FrameRecord& f) { f.feedback_psi = 1.5; },
      [](db::FrameRecord& f) { f.feedback_psi = NAN; },
      [](db::FrameRecord& f) { f.time_ns = 5; },
      [](db::FrameRecord& f) { f.flags = "x"; },
      [](db::FrameRecord& f) { f.counts[0] = 3; },
      [](db::FrameRecord& f) { f.counts[7] = 3; },
      [](db::FrameRecord& f) {
        f.scans = 1;
        f.counts.resize(6);
      }};
  for (std::size_t i = 0; i < changes.size(); ++i) {
    INFO(i);
    const nlohmann::json printed = runs.printed(first, runs.add_frame(changes[i]));
    check_members(printed, R"({"same_content": false, "frames_equal": 0, "first_frame": 1})");
  }
  const std::int64_t gap = runs.add_frame([](db::FrameRecord& f) { f.feedback_psi = NAN; });
  const std::int64_t gap_too = runs.add_frame([](db::FrameRecord& f) { f.feedback_psi = NAN; });
  CHECK(runs.diff(gap, gap_too).code == 0);
}
