// runs diff: trees beside words, settings without a key, tags and checks, and the first count that differs.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/cli/verb_here.h"
#include "tests/db/store_example.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

struct PairOfRuns {
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
    std::vector<std::string> words = {"runs", "diff", std::to_string(first), std::to_string(second), "--db", path};
    words.insert(words.end(), more.begin(), more.end());
    return verb_here(bench::add_runs, words);
  }
  // Without the line of hashes, and without the two lines of frames and content.
  std::string differences(std::int64_t first, std::int64_t second) const {
    std::string text = diff(first, second).out;
    text.erase(text.find("frames: "));
    if (const std::size_t hashes = text.find("content_sha256"); hashes != std::string::npos)
      text.erase(hashes, text.find('\n', hashes) + 1 - hashes);
    return text;
  }
  std::string first_frame(std::int64_t first, std::int64_t second) const {
    const std::string text = diff(first, second).out;
    const std::size_t at = text.find("first frame that differs: ");
    return at == std::string::npos ? "none" : text.substr(at + 26, text.find('\n', at) - at - 26);
  }
  TemporaryFolder folder;
  std::string path = folder.path("runs.db");
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
};

}  // namespace

TEST_CASE("runs diff: a tree of one member beside nothing, beside a word, and lists beside words") {
  PairOfRuns runs;
  const std::int64_t none = runs.add_settings("[]");
  const std::int64_t tree = runs.add_settings(R"([{"key":"a","value":{"x":1}}])");
  const std::int64_t word = runs.add_settings(R"([{"key":"a","value":"s"}])");
  const std::int64_t list = runs.add_settings(R"([{"key":"a","value":[1]}])");
  const std::int64_t other = runs.add_settings(R"([{"key":5,"value":"s"},{"key":"b"}])");
  CHECK(runs.differences(none, tree) == "overrides.a.x" + std::string(27, ' ') + " nothing | 1\n");
  CHECK(runs.differences(tree, none) == "overrides.a.x" + std::string(27, ' ') + " 1 | nothing\n");
  CHECK(runs.differences(tree, word) == "overrides.a" + std::string(29, ' ') + " {\"x\":1} | s\n");
  CHECK(runs.differences(word, tree) == "overrides.a" + std::string(29, ' ') + " s | {\"x\":1}\n");
  CHECK(runs.differences(list, word) == "overrides.a" + std::string(29, ' ') + " [1] | s\n");
  CHECK(runs.differences(word, list) == "overrides.a" + std::string(29, ' ') + " s | [1]\n");
  CHECK(runs.differences(none, other) == "");
}

TEST_CASE("runs diff: a tag or a check alone is a difference of the same content or frames") {
  PairOfRuns runs;
  const auto same = [](db::RunRecord&) {};
  const std::int64_t first = runs.add(same), second = runs.add(same), third = runs.add(same, {}, "warning");
  const Finished equal = runs.diff(first, second);
  CHECK(equal.code == 0);
  CHECK(equal.out == "frames: 0 of run 1 and 0 of run 2, 0 equal in place\ncontent: the same, by its hash\n");
  runs.store.set_tags(second, {"night"}, {});
  const Finished tagged = runs.diff(first, second);
  CHECK(tagged.code == 1);
  CHECK_THAT(tagged.out, Catch::StartsWith("tags" + std::string(36, ' ') + " [] | [\"night\"]\n") &&
                             Catch::EndsWith("content: the same, by its hash\n"));
  CHECK(runs.differences(first, third) == "checks[0]" + std::string(31, ' ') + " seating pass | seating warning\n");
  const std::int64_t open = begin_example(runs.store).run, more = begin_example(runs.store).run;
  const Finished unended = runs.diff(open, more);  // without a hash
  CHECK(unended.code == 1);
  CHECK(unended.out == "frames: 0 of run 4 and 0 of run 5, 0 equal in place\ncontent: not the same\n");
}

TEST_CASE("runs diff: what the first frame that differs differs in, each value in its turn") {
  PairOfRuns runs;
  const std::int64_t first = runs.add_frame([](db::FrameRecord&) {});
  const auto against = [&](const std::function<void(db::FrameRecord&)>& change) {
    return runs.first_frame(first, runs.add_frame(change));
  };
  CHECK(against([](db::FrameRecord&) {}) == "none");
  CHECK(against([](db::FrameRecord& f) { f.ordinal = 2; }) == "1: step 0 and 2");
  CHECK(against([](db::FrameRecord& f) { f.setpoint_psi = 1.5; }) == "1: setpoint_psi 0 and 1.5");
  CHECK(against([](db::FrameRecord& f) { f.reference_psi = 0.25; }) == "1: reference_psi 0.3333333333333333 and 0.25");
  CHECK(against([](db::FrameRecord& f) { f.feedback_psi = 1.5; }) == "1: feedback_psi 0.1 and 1.5");
  CHECK(against([](db::FrameRecord& f) { f.feedback_psi = NAN; }) == "1: feedback_psi 0.1 and nan");
  CHECK(against([](db::FrameRecord& f) { f.time_ns = 5; }) == "1: time_ns 2000000000000 and 5");
  CHECK(against([](db::FrameRecord& f) { f.flags = "x"; }) == "1: flags 'dwell' and 'x'");
  CHECK(against([](db::FrameRecord& f) {
          f.scans = 1;
          f.counts.resize(6);
        }) == "1: 12 and 6 counts");
  // Six taxels a scan: the eighth count is of the second scan's second taxel, 65535 - 257 * 7.
  CHECK(against([](db::FrameRecord& f) { f.counts[7] = 3; }) == "1: scan 1, taxel 1: 63736 and 3 counts");
  CHECK(against([](db::FrameRecord& f) { f.counts[5] = 3; }) == "1: scan 0, taxel 5: 64250 and 3 counts");
  const std::int64_t gap = runs.add_frame([](db::FrameRecord& f) { f.feedback_psi = NAN; });
  const std::int64_t gap_too = runs.add_frame([](db::FrameRecord& f) { f.feedback_psi = NAN; });
  CHECK(runs.first_frame(gap, gap_too) == "none");
  CHECK(runs.diff(gap, gap_too).code == 0);
}
