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
  const std::vector<db::FrameRecord> frames = store.frames(8);  // the eighth is number 7
  REQUIRE(frames.size() == 40);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const db::FrameRecord& frame = frames[i];
    INFO("frame " << i);
    CHECK(frame.ordinal == static_cast<int>(i));
    CHECK((frame.rows == 16 && frame.columns == 16 && frame.scans == 1));
    CHECK((frame.setpoint_psi == 1.5 * static_cast<double>(i) && frame.reference_psi == frame.setpoint_psi));
    CHECK(frame.feedback_psi == frame.setpoint_psi);
    CHECK(frame.time_ns == static_cast<std::int64_t>(i) * 2'000'000'000);
    CHECK(frame.trace.size() == 10);
    REQUIRE(frame.counts.size() == 256);
    CHECK(frame.counts[0] == 7);
    CHECK(frame.counts[1] == 251 * i + 7);
    CHECK(frame.counts[255] == 251 * i + 1785);
  }
  const db::RunRecord bulk = store.run(8);
  CHECK(bulk.outcome == db::Outcome::kCompleted);
  CHECK(bulk.seed == 7);
  CHECK(bulk.tags == std::vector<std::string>{"nightly"});
  CHECK((bulk.bench_toml.size() == 3000 && bulk.sensor_toml.size() == 600));
  REQUIRE(bulk.sequences.size() == 1);
  CHECK(bulk.sequences[0].name == "frames");
  CHECK((bulk.sequences[0].repeats == 1 && bulk.sequences[0].frames_per_repeat == 40));
  CHECK(bulk.sequences[0].recipe_toml.size() == 1500);
  const std::vector<db::FigureRecord> figures = store.figures("bulk/7");
  CHECK(figures.size() == 12);
  for (const db::FigureRecord& figure : figures) {
    if (figure.name == "figure_0_psi") CHECK(figure.value == Approx(0.98935824662338).epsilon(1e-12));      // sin 8
    if (figure.name == "figure_11_psi") CHECK(figure.value == Approx(-0.1760756199485871).epsilon(1e-12));  // sin 85
  }
  CHECK(store.fits(8).size() == 1);
  CHECK(store.verdicts(8).size() == 4);
  for (const db::VerdictRecord& verdict : store.verdicts(8)) CHECK(verdict.verdict == std::string("pass"));
}

TEST_CASE("a large store has as many subjects as a night has scenarios, each with every 58th run") {
  const TemporaryFolder folder;
  {
    db::RunStore real = db::RunStore::open(folder.path("real.db"));
    for (int i = 0; i < 2; ++i) {
      const std::int64_t run = i == 0 ? begin_example(real).run : real.begin_run(example_run());
      real.end_run(run, db::Outcome::kCompleted, "done", db::SafeState::kVerified, kUtc);
    }
  }
  bench::make_large_store(folder.path("large.db"), 61, folder.path("real.db"));
  const db::RunStore store = db::RunStore::open_read_only(folder.path("large.db"));
  CHECK(store.figures("bulk/0").size() == 24);  // of runs 1 and 59
  CHECK(store.figures("bulk/57").size() == 12);
  CHECK(store.figures("bulk/58").empty());
  const std::vector<db::BranchRecord> branches = store.branches(59);
  REQUIRE(branches.size() == 1);
  CHECK((branches[0].from_psi == 0.0 && branches[0].to_psi == 60.0));
  CHECK((branches[0].sequence == 0 && branches[0].repeat == 0));
  const db::RunRecord run = store.run(59);
  CHECK(run.safe_state == db::SafeState::kVerified);
  CHECK(run.origin == "simulated");
  CHECK(run.sequences.front().sequence == 0);
  CHECK(run.uuid != store.run(1).uuid);
}
