// verify and db check of runs without models, line by line: as stored, changed, pruned, not ended.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "db/sqlite.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/db/store_example.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

struct StoreToVerify {
  StoreToVerify() { (void)store_example(store); }
  Finished verify(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words = {"verify", "1", "--db", path};
    words.insert(words.end(), more.begin(), more.end());
    return verb_here(bench::add_verify, words);
  }
  void change(const char* sql) const { db::sqlite::Connection(path, db::sqlite::Access::kReadWrite).execute(sql); }
  [[nodiscard]] std::string hash() const { return store.run(1).content_sha256; }
  TemporaryFolder folder;
  std::string path = folder.path("runs.db");
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
};

const std::string kHead = "run 1 (simulated), 3 frames\n";

}  // namespace

TEST_CASE("verify: a run as it was stored, in words and as JSON") {
  const StoreToVerify store;
  const Finished well = store.verify();
  CHECK(well.code == 0);
  CHECK(well.out == kHead + "  content       as it was stored, sha256 " + store.hash() +
                        "\n  analysis      no stored fit, no verdict\nverified\n");
  const auto told = nlohmann::json::parse(store.verify({"--json"}).out);
  CHECK(told.at("run") == 1);
  CHECK(told.at("origin") == "simulated");
  CHECK(told.at("holds") == true);
  CHECK(told.at("pruned").is_null());
  CHECK(told.at("first_difference") == "");
  CHECK(told.at("content") ==
        nlohmann::json{
            {"holds", true}, {"frames", 3}, {"stored_sha256", store.hash()}, {"computed_sha256", store.hash()}});
  CHECK(told.at("beside").empty());
  CHECK(told.at("analysis").empty());
  CHECK_THAT(verb_here(bench::add_verify, {"verify", "x", "--db", store.path}).err,
             Catch::StartsWith("error: 'x' is not a run number [TB-USAGE]\n"));
}

TEST_CASE("verify: changed content is 5, and so is a changed approval, with the first difference") {
  StoreToVerify store;
  store.store.add_report({1, "1-a", "h", "K. Lee", kUtc, "", ""});
  store.change("UPDATE reports SET approved_by = 'B'");
  const Finished approval = store.verify();
  CHECK(approval.code == 5);
  CHECK_THAT(approval.out, Catch::StartsWith(kHead + "  content       as it was stored, sha256 " + store.hash() +
                                             "\n  CHANGED       approvals: ") &&
                               Catch::Contains("\nNOT verified; first difference: approvals: "));
  CHECK(nlohmann::json::parse(store.verify({"--json"}).out).at("beside").size() == 1);
  store.change("UPDATE frames SET status = 9 WHERE frame = (SELECT min(frame) FROM frames)");
  const Finished frame = store.verify();
  CHECK(frame.code == 5);
  CHECK_THAT(frame.out, Catch::StartsWith(kHead + "  content       DIFFERS: ") &&
                            Catch::Contains("\n                stored sha256 " + store.hash() + ", recomputed ") &&
                            Catch::Contains("; the analysis was not checked\n  CHANGED       approvals: ") &&
                            !Catch::Contains("no stored fit"));
  const auto told = nlohmann::json::parse(store.verify({"--json"}).out);
  CHECK(told.at("holds") == false);
  CHECK(told.at("content").at("holds") == false);
  CHECK(told.at("content").at("computed_sha256") != store.hash());
}

TEST_CASE("verify: a run without its frames is 6, one that has not ended is refused") {
  StoreToVerify store;
  store.store.set_tags(1, {"nightly"}, {});
  (void)store.store.prune_frames(1, "old nights", kUtc);
  const Finished pruned = store.verify();
  CHECK(pruned.code == 6);
  CHECK(pruned.out ==
        kHead +
            "  frames        removed on 2026-01-01T00:00:00Z, by the rule: old nights. They were not checked, and "
            "nothing "
            "was recomputed from them\n  all else      as it was stored: row, sequences, devices, branches, events, "
            "checks; sha256 " +
            store.hash() +
            "\n  analysis      no stored fit, no verdict\nwhat is left is verified; the frames are not there\n");
  const auto told = nlohmann::json::parse(store.verify({"--json"}).out);
  CHECK(told.at("pruned") == nlohmann::json{{"frames", 3}, {"rule", "old nights"}, {"pruned_utc", kUtc}});
  store.change("UPDATE runs SET seed = 8");
  const Finished changed = store.verify();
  CHECK(changed.code == 5);
  CHECK_THAT(changed.out, Catch::Contains("  content       DIFFERS: ") && !Catch::Contains("all else"));
  (void)begin_example(store.store);
  const Finished open = verb_here(bench::add_verify, {"verify", "2", "--db", store.path});
  CHECK(open.code == 6);
  CHECK(open.err ==
        "error: run 2 has not ended: it has no hash to compare with yet [TB-VERIFY-NOT-ENDED]\n  at: " + store.path +
            "\n  try: wait for its end; a run whose process died is closed at the next start of a run\n");
}

TEST_CASE("db check: each run that is not as it was stored, and what to do then") {
  StoreToVerify store;
  (void)store_example(store.store);
  (void)store_example(store.store);
  (void)begin_example(store.store);
  store.store.add_report({2, "2-a", "h", "K. Lee", kUtc, "", ""});
  store.change(
      "UPDATE reports SET approved_by = 'B'; UPDATE frames SET status = 9 WHERE frame = (SELECT min(frame) FROM "
      "frames)");
  const Finished checked = verb_here(bench::add_db, {"db", "check", store.path});
  CHECK(checked.code == 5);
  CHECK_THAT(
      checked.out,
      Catch::StartsWith("  run 1   ") && Catch::Contains("\n  run 2   approvals: ") &&
          Catch::EndsWith("\n" + store.path +
                          ": structure sound; 1 run as it was stored, 2 not, 1 not ended (no hash yet)\nkeep a copy "
                          "of the file and use the last snapshot; tactbench verify RUN shows more about a run\n"));
  const auto told = nlohmann::json::parse(verb_here(bench::add_db, {"db", "check", store.path, "--json"}).out);
  CHECK(told.at("holds") == false);
  CHECK(told.at("structure").empty());
  REQUIRE(told.at("runs").size() == 4);
  CHECK(told.at("runs").at(0).at("holds") == false);
  CHECK(told.at("runs").at(1).at("beside").size() == 1);
  CHECK(told.at("runs").at(2).at("holds") == true);
  CHECK(told.at("runs").at(3).at("ended") == false);
  CHECK(told.at("runs").at(3).at("frames") == 0);
}
