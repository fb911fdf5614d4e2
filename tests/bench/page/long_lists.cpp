// The page's list of more runs than it shows: the newest five hundred, and how many are left out.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/page/lists.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;

TEST_CASE("page lists: five hundred runs at most, the newest, and the number of those left out") {
  const tests::TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  store.add_sensor(tests::example_sensor());
  db::RunRecord run = tests::example_run();
  const auto add_runs = [&](int count) {
    for (int i = 0; i < count; ++i) {
      run.uuid = db::new_uuid();
      (void)store.begin_run(run);
    }
  };
  add_runs(500);
  const nlohmann::ordered_json all = bench::runs_list(store);
  CHECK(all["runs"].size() == 500);
  CHECK(all["left_out"] == 0);
  add_runs(2);
  const nlohmann::ordered_json some = bench::runs_list(store);
  REQUIRE(some["runs"].size() == 500);
  CHECK(some["left_out"] == 2);
  CHECK(some["runs"][0]["run"] == 502);
  CHECK(some["runs"][499]["run"] == 3);
}
