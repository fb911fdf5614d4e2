// status and watch where no run is live.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/cli/store_here.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// Runs of bench-a, bench-b, and one of bench-a that has not ended.
struct StoreOfStatus : OpenStoreHere {
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
  Finished status(const std::vector<std::string>& words) const { return say(bench::add_status, words); }
};

}  // namespace

TEST_CASE("status: shows the last run of the store, of a bench, or the run that is named") {
  const StoreOfStatus store;
  CHECK(store.status({"status"}).code == 0);
  check_refusal(store.status({"status", "9"}), 2, "TB-STORE-NOT-FOUND");
  const auto printed = [&](std::vector<std::string> more) {
    more.insert(more.begin(), "status");
    return store.printed<nlohmann::json>(bench::add_status, more);
  };
  const nlohmann::json last = printed({});
  CHECK((last.at("live") == false && last.at("runs").empty() && last.at("silent").empty()));
  CHECK((last.at("last_run").at("run") == 3 && last.at("last_run").at("lives") == false));
  CHECK(printed({"--bench", "bench-b"}).at("last_run").at("run") == 2);
  CHECK(printed({"1"}).at("last_run").at("run") == 1);
  CHECK(printed({"--bench", "bench-c"}).at("last_run").is_null());
}

TEST_CASE("watch: for an ended run it ends with the exit code of that run") {
  const StoreOfStatus store;
  CHECK(store.status({"status", "--watch", "1"}).code == 0);
  CHECK(store.status({"status", "--watch", "2"}).code == 3);
  check_refusal(store.status({"status", "--watch", "--bench", "no-such-bench"}), 2, "TB-RUN-NOT-LIVE");
}
