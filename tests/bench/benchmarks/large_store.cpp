// The store that `tactbench benchmark large-store` takes its figures on.
#include "bench/benchmarks/large_store.h"

#include <catch2/catch.hpp>

#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

TEST_CASE("a large store holds as many runs as asked for, the last two of them real, the others bulk") {
  const TemporaryFolder folder;
  {
    db::RunStore real = db::RunStore::open(folder.path("real.db"));
    for (int i = 0; i < 2; ++i) {
      const std::int64_t run = i == 0 ? begin_example(real).run : real.begin_run(example_run());
      real.end_run(run, db::Outcome::kCompleted, "done", db::SafeState::kVerified, kUtc);
    }
  }
  bench::make_large_store(folder.path("large.db"), 25, folder.path("real.db"));
  const db::RunStore store = db::RunStore::open_read_only(folder.path("large.db"));
  const std::vector<db::RunRecord> runs = store.runs();
  REQUIRE(runs.size() == 25);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    INFO("run " << i + 1);
    const db::RunRecord& run = runs[i];
    CHECK(run.run == static_cast<std::int64_t>(i + 1));
    CHECK(run.sensor_serial == (i < 23 ? "B-1" : "S-1"));
    if (i >= 23) continue;
    CHECK(run.purpose == "bulk " + std::to_string(i));
    // The last day's runs are those that a list of 20 shows: runs 5 to 23, and the two real ones behind them.
    CHECK(run.started_utc.substr(0, 10) == (i < 5 ? "2025-06-01" : "2026-01-31"));
    CHECK(store.frame_count(run.run) == 40);
  }
}
