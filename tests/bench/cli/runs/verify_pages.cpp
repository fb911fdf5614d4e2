// verify and verify of runs without models: as stored, changed, pruned, not ended.
#include <catch2/catch.hpp>
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
  [[nodiscard]] nlohmann::json told_of_it() const { return told<nlohmann::json>(bench::add_verify, {"verify", "1"}); }
  void change(const char* sql) const { db::sqlite::Connection(path, db::sqlite::Access::kReadWrite).execute(sql); }
  [[nodiscard]] std::string hash() const { return store.run(1).content_sha256; }
};

}  // namespace

TEST_CASE("verify: a stored run holds") {
  const StoreToVerify store;
  CHECK(store.verify().code == 0);
  const nlohmann::json told = store.told_of_it();
  check_members(told, R"({"run": 1, "origin": "simulated", "holds": true})");
  CHECK(told.at("pruned").is_null());
  CHECK(told.at("first_difference") == "");
  CHECK(told.at("content") ==
        nlohmann::json{
            {"holds", true}, {"frames", 3}, {"stored_sha256", store.hash()}, {"computed_sha256", store.hash()}});
  CHECK(told.at("beside").empty());
  CHECK(told.at("analysis").empty());
  CHECK_THAT(verb_here(bench::add_verify, {"verify", "x", "--db", store.path}).err, Catch::Contains("[TB-USAGE]"));
}

TEST_CASE("verify: changed content is 5, and so is a changed approval, with the first difference") {
  StoreToVerify store;
  store.store.add_report({1, "1-a", "h", "K. Lee", kUtc, "", ""});
  store.change("UPDATE reports SET approved_by = 'B'");
  CHECK(store.verify().code == 5);
  CHECK(store.told_of_it().at("beside").size() == 1);
  store.change("UPDATE frames SET status = 9 WHERE frame = (SELECT min(frame) FROM frames)");
  CHECK(store.verify().code == 5);
  const nlohmann::json told = store.told_of_it();
  CHECK(told.at("holds") == false);
  CHECK(told.at("content").at("holds") == false);
  CHECK(told.at("content").at("computed_sha256") != store.hash());
}

TEST_CASE("verify: a run without its frames is 6, one that has not ended is refused") {
  StoreToVerify store;
  store.store.set_tags(1, {"nightly"}, {});
  (void)store.store.prune_frames(1, "old nights", kUtc);
  CHECK(store.verify().code == 6);
  const nlohmann::json told = store.told_of_it();
  CHECK(told.at("pruned") == nlohmann::json{{"frames", 3}, {"rule", "old nights"}, {"pruned_utc", kUtc}});
  store.change("UPDATE runs SET seed = 8");
  CHECK(store.verify().code == 5);
  (void)begin_example(store.store);
  check_refusal(verb_here(bench::add_verify, {"verify", "2", "--db", store.path}), 6, "TB-VERIFY-NOT-ENDED");
}
