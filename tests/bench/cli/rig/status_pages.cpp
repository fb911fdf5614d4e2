// status and watch where no run is live.
#include <catch2/catch.hpp>
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
  Finished say(const std::vector<std::string>& words) const { return verb_here(bench::add_status, words); }
  TemporaryFolder folder;
  std::string path = folder.path("runs.db");
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
};

}  // namespace

TEST_CASE("status: the last run of the store, of a bench, or the one that is named") {
  const StoreOfStatus store;
  CHECK(store.say({"status", "--db", store.path}).code == 0);
  CHECK_THAT(store.say({"status", "9", "--db", store.path}).err, Catch::Contains("[TB-STORE-NOT-FOUND]"));
  CHECK_THAT(store.say({"status", "--db", store.folder.path("none.db")}).err, Catch::Contains("[TB-STORE-OPEN]"));
  const auto told = nlohmann::json::parse(store.say({"status", "--db", store.path, "--json"}).out);
  CHECK(told.at("live") == false);
  CHECK(told.at("runs").empty());
  CHECK(told.at("silent").empty());
  CHECK(told.at("last_run").at("run") == 3);
  CHECK(told.at("last_run").at("lives") == false);
  const auto last_run = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"status", "--db", store.path, "--json"};
    words.insert(words.end(), more.begin(), more.end());
    return nlohmann::json::parse(store.say(words).out).at("last_run").at("run");
  };
  CHECK(last_run({"--bench", "bench-b"}) == 2);
  CHECK(last_run({"1"}) == 1);
  CHECK(nlohmann::json::parse(store.say({"status", "--db", store.path, "--bench", "bench-c", "--json"}).out)
            .at("last_run")
            .is_null());
}

TEST_CASE("watch: of a named run that has ended it says how, with that run's exit code") {
  const StoreOfStatus store;
  CHECK(store.say({"watch", "1", "--db", store.path}).code == 0);
  CHECK(store.say({"watch", "2", "--db", store.path}).code == 3);
  check_refusal(store.say({"watch", "--bench", "no-such-bench", "--db", store.path}), 2, "TB-RUN-NOT-LIVE");
}
