// runs show and runs diff of runs that are known row by row: verdicts by models and limits, remarks, settings,
// metadata.
#include <catch2/catch.hpp>
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "bench/run/control/locks.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/db/store_example.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

struct StoreOfPages {
  Finished runs(std::vector<std::string> words) const {
    words.insert(words.begin(), "runs");
    words.insert(words.end(), {"--db", path});
    return verb_here(bench::add_runs, words);
  }
  std::int64_t add(const std::function<void(db::RunRecord&)>& change = [](db::RunRecord&) {}) {
    db::RunRecord run = example_run();
    change(run);
    return store_example(store, run);
  }
  TemporaryFolder folder;
  std::string path = folder.path("runs.db");
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
};

// What a diff names, as "what: first | second".
std::vector<std::string> named_differences(const Finished& diff) {
  std::vector<std::string> found;
  std::istringstream lines(diff.out);
  for (std::string line; std::getline(lines, line) && !line.starts_with("frames: ");) {
    const std::size_t end = line.find("  "), from = line.find_first_not_of(' ', end);
    found.push_back(line.substr(0, end) + ": " + line.substr(from));
  }
  return found;
}

}  // namespace

TEST_CASE("runs show: a table of verdicts for each pair of models and limits, and the word of all") {
  StoreOfPages store;
  store.add();
  store.add();
  db::FitRecord fit;
  fit.run = 1;
  fit.model = "elam";
  const std::int64_t own = store.store.add_fit(fit);
  const auto row = [](const char* verdict, const std::string& limits) {
    return db::VerdictRecord{0, 0, "unfit_taxels", "array", 1.0, 1.5, "taxels", "simple", verdict, "limits", limits};
  };
  const std::string first(64, '1'), second(64, '2');
  store.store.replace_verdicts(2, own, {row("pass", first)});
  store.store.replace_verdicts(2, 0, {row("fail", second)});
  const std::string shown = store.runs({"show", "2"}).out;
  const std::string table =
      "  run  requirement                scope                  value  tolerance limit  verdict\n";
  CHECK_THAT(shown, Catch::Contains("\nverdict: simulated fail\n") &&
                        Catch::Contains("\nmodels of run 1, limits sha256 111111111111\n" + table) &&
                        Catch::Contains("\nmodels of no stored run, limits sha256 222222222222\n" + table));
  CHECK_THAT(shown, Catch::Contains("  purpose       test \"of\" the store\\x0a\n") ||
                        Catch::Contains("  purpose       test \"of\" the store"));
  CHECK_THAT(shown, Catch::Contains("  seating pass: rows 3\n") || Catch::Contains("seating pass: rows 3\n"));
  const auto told = nlohmann::json::parse(store.runs({"show", "2", "--json"}).out);
  CHECK(told.at("verdict") == "simulated fail");
  CHECK(told.at("verdicts").size() == 2);
  CHECK(told.at("frames") == 3);
  CHECK_FALSE(told.contains("pruned"));
  CHECK_FALSE(told.contains("specimen"));
}

TEST_CASE("runs show: remarks of people, a run without bench, and where its frames went") {
  StoreOfPages store;
  store.add([](db::RunRecord& run) {
    run.bench_id = "";
    run.operator_name = "";
    run.git_dirty = false;
    run.devices.clear();
  });
  store.store.add_note(1, "the door was open");
  store.store.add_note(1, "and the light on");
  store.store.set_tags(1, {"nightly"}, {});
  CHECK_THAT(store.runs({"show", "1"}).out,
             Catch::Contains("\n  note          the door was open\n  note          and the light on\n") &&
                 Catch::Contains("\n  operator      not stated\n") &&
                 Catch::Contains("\n  bench         not stated\n") &&
                 Catch::Contains("\n  program       0.1.0 (0123abc)\n") && Catch::Contains("\n  frames        3\n") &&
                 !Catch::Contains("VOID"));
  (void)store.store.prune_frames(1, "old nights", kUtc);
  store.store.void_run(1, "gauge closed", "K. Lee", kUtc);
  CHECK_THAT(store.runs({"show", "1"}).out,
             Catch::Contains("\n  VOID          gauge closed (K. Lee, 2026-01-01T00:00:00Z)\n") &&
                 Catch::Contains("\n  frames        none: 3 were removed on 2026-01-01T00:00:00Z, by the rule: old "
                                 "nights\n"));
  const auto told = nlohmann::json::parse(store.runs({"show", "1", "--json"}).out);
  CHECK(told.at("pruned") == nlohmann::json{{"frames", 3}, {"rule", "old nights"}, {"pruned_utc", kUtc}});
}

TEST_CASE("runs list: void runs are counted, and the state of one that has not ended is told") {
  StoreOfPages store;
  for (int i = 0; i < 3; ++i) store.add();
  (void)begin_example(store.store);
  store.store.void_run(1, "door", "K. Lee", kUtc);
  CHECK_THAT(store.runs({"list"}).out, Catch::EndsWith("\n1 void run left out (--all)\n"));
  store.store.void_run(2, "door", "K. Lee", kUtc);
  const auto last_line = [&] {
    const std::string list = store.runs({"list", "--all"}).out;
    return list.substr(list.rfind('\n', list.size() - 2) + 1);
  };
  CHECK_THAT(store.runs({"list"}).out, Catch::EndsWith("\n2 void runs left out (--all)\n"));
  CHECK_THAT(last_line(), Catch::EndsWith("the store\\x0a\n"));  // no lock tells whether a process carries it out
  const bench::RunLock lock(store.path);
  CHECK_THAT(last_line(), Catch::EndsWith("\\x0a (no process carries it out)\n"));
  CHECK(nlohmann::json::parse(store.runs({"list", "--json"}).out).at("runs").at(1).at("lives") == false);
  lock.take_again(4);
  CHECK_THAT(last_line(), Catch::EndsWith("\\x0a (under way)\n"));
  const std::string all = store.runs({"list", "--all"}).out;
  CHECK_THAT(all, Catch::Contains(" VOID: door\n") && !Catch::Contains("left out"));
  const auto told = nlohmann::json::parse(store.runs({"list", "--json"}).out);
  CHECK(told.at("void_left_out") == 2);
  REQUIRE(told.at("runs").size() == 2);
  CHECK(told.at("runs").at(0).at("frames") == 3);
  CHECK_FALSE(told.at("runs").at(0).contains("lives"));
  CHECK(told.at("runs").at(1).at("lives") == true);
  CHECK(told.at("runs").at(1).at("frames") == 0);
}

TEST_CASE("runs diff: members by their path, settings by their key, and what is no difference") {
  StoreOfPages store;
  store.add();
  store.add([](db::RunRecord& run) {
    run.overrides_json = R"([{"key":"a","value":"2"},{"key":"b","value":"3"},{"value":"4"},7])";
    run.host = "host-b";
    run.time_zone = "UTC";
    run.started_utc = "2025-01-01T00:00:00Z";
    run.rest_s = 5.0;
    run.devices[1].model = "T-2";
    run.sequences[0].repeats = 3;
  });
  const Finished diff = store.runs({"diff", "1", "2"});
  CHECK(diff.code == 1);
  const std::string hashes =
      "content_sha256: " + store.store.run(1).content_sha256 + " | " + store.store.run(2).content_sha256;
  CHECK(named_differences(diff) == std::vector<std::string>{"overrides.a: 1 | 2", "overrides.b: nothing | 3", hashes,
                                                            "recipes[0].repeats: 2 | 3",
                                                            "devices[1].model: T-1 | T-2"});
  CHECK_THAT(diff.out, Catch::EndsWith("frames: 3 of run 1 and 3 of run 2, 3 equal in place\ncontent: not the same\n"));
  store.add();
  const Finished equal = store.runs({"diff", "1", "3"});
  CHECK(named_differences(equal).empty());
  store.store.set_tags(1, {"lot=A7", "night"}, {});
  store.store.set_tags(3, {"lot=A8", "film=B"}, {});
  const Finished remarks = store.runs({"diff", "1", "3"});
  CHECK(named_differences(remarks) ==
        std::vector<std::string>{"tags: [\"night\"] | []", "metadata.lot: A7 | A8  (a remark: does not count)",
                                 "metadata.film: nothing | B  (a remark: does not count)"});
  const auto told = nlohmann::json::parse(store.runs({"diff", "1", "3", "--json"}).out);
  CHECK(told.at("differences") ==
        nlohmann::json::parse(R"([{"what": "tags", "first": "[\"night\"]", "second": "[]"}])"));
  CHECK(told.at("metadata").size() == 2);
  CHECK(told.at("frames_equal") == 3);
  CHECK(told.at("first_frame") == 0);
}

TEST_CASE("runs diff: verdicts stand beside each other, and a run with fewer frames") {
  StoreOfPages store;
  store.add();
  store.add();
  const auto row = [](double value) {
    return db::VerdictRecord{0, 0, "mismatch", "40 psi up", value, 0.05, "FS", "simple", "pass", "limits", "sha"};
  };
  store.store.replace_verdicts(1, 0, {row(0.03)});
  CHECK(named_differences(store.runs({"diff", "1", "2"})) ==
        std::vector<std::string>{"verdicts.mismatch (40 psi up): pass: 0.03 FS, limit 0.05 | nothing"});
  store.store.replace_verdicts(2, 0, {row(0.04)});
  CHECK_THAT(store.runs({"diff", "1", "2"}).out,
             Catch::Contains("pass: 0.03 FS, limit 0.05 | pass: 0.04 FS, limit 0.05\n"));
  const Begun fewer = begin_example(store.store);
  store.store.append_frame(fewer.run, example_frame(fewer.branch, 0));
  store.store.end_run(fewer.run, db::Outcome::kFailed, "x", db::SafeState::kVerified, kUtc);
  const Finished less = store.runs({"diff", "1", std::to_string(fewer.run)});
  CHECK_THAT(less.out,
             Catch::Contains("\nframes: 3 of run 1 and 1 of run 3, 1 equal in place\ncontent: not the same\n") &&
                 Catch::Contains("outcome") && !Catch::Contains("first frame"));
}

TEST_CASE("runs show: the whole page of a run") {
  StoreOfPages store;
  store.add();
  const db::RunRecord run = store.store.run(1);
  const std::string bench = run.bench_sha256.substr(0, 12);
  CHECK(store.runs({"show", "1"}).out ==
        "run 1 (" + run.uuid +
            ")\n  origin        simulated\n  outcome       completed: all steps done\n  safe state    verified\n"
            "  sensor        S-1, scanner SC-7\n  operator      N. Nobody\n"
            "  purpose       test \"of\" the store\\x0a\n  bench         bench-a (sha256 " +
            bench +
            ")\n  started       2024-05-01T09:00:00Z\n  ended         2024-05-01T10:00:00Z\n"
            "  program       0.1.0 (0123abc, modified)\n  content       " +
            run.content_sha256 +
            "\n  recipe        up: 2 x 3 frames (sha256 ra)\n  recipe        down: 1 x 4 frames (sha256 rb)\n"
            "  device        regulator: R-1, serial 0001, simulated\n"
            "  device        tactile scanner: T-1, serial SC-7, simulated\n  frames        3\n"
            "  check             0.000 s  seating pass: rows 3\n"
            "  event             0.000 s  state  prepared -> running\n"
            "  event             0.000 s  fault TB-SCANNER-SILENT no report\n");
}

TEST_CASE("runs diff: the first count of a frame, and a frame of no shape") {
  StoreOfPages store;
  for (const std::uint16_t first : std::vector<std::uint16_t>{1, 2}) {
    const Begun begun = begin_example(store.store);
    db::FrameRecord frame = example_frame(begun.branch, 0);
    frame.counts[0] = first;
    store.store.append_frame(begun.run, frame);
    store.store.end_run(begun.run, db::Outcome::kCompleted, "", db::SafeState::kVerified, kUtc);
  }
  CHECK_THAT(
      store.runs({"diff", "1", "2"}).out,
      Catch::Contains("\nframes: 1 of run 1 and 1 of run 2, 0 equal in place\nfirst frame that differs: 1: scan 0, "
                      "taxel 0: 1 and 2 counts\n"));
}
