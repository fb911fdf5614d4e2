// What time estimates learn from: sequences of completed runs of a bench, times of frames and of changes of state.
#include <catch2/catch.hpp>

#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;

TEST_CASE("frames have their times by position, and beyond the run's own there are none") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const std::int64_t first = store_example(store), run = store_example(store);
  CHECK(store.last_position(run) == 3);
  CHECK(store.last_position(first) == 3);
  CHECK(store.last_position(99) == 0);
  CHECK(store.last_position(store.begin_run(example_run())) == 0);
  for (int round = 0; round < 2; ++round) {
    for (std::int64_t position = 1; position <= 3; ++position) {
      const auto found = store.frame_time(run, position);
      REQUIRE(found);
      CHECK((found->sequence == 1 && found->repeat == 0 && found->ordinal == (position == 3 ? 1 : 0)));
      CHECK(found->is_void == (position == 1));
      CHECK(found->time_ns == example_frame(1, found->ordinal).time_ns);
    }
    CHECK_FALSE(store.frame_time(run, 0));
    CHECK_FALSE(store.frame_time(run, 4));
  }
}

TEST_CASE("of a run's events those are timed that change its state or begin a way back") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const Begun begun = begin_example(store);
  store.set_state(begun.run, "running", {5, "state", "", "prepared -> running"});
  store.append_event(begun.run, {6, "fault", "TB-SCANNER-SILENT", "no report"});
  store.append_event(begun.run, {7, "way-back", "", "branch 1"});
  const auto found = store.timed_events(begun.run);
  REQUIRE(found.size() == 2);
  CHECK((found[0].time_ns == 5 && found[0].kind == "state" && found[0].detail == "prepared -> running"));
  CHECK((found[1].time_ns == 7 && found[1].kind == "way-back" && found[1].detail == "branch 1"));
}

TEST_CASE("the newest completed runs of a bench are learnt from, newest first, each by its sequences") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  store_example(store);
  const std::int64_t second = store_example(store);
  db::RunRecord elsewhere = example_run();
  elsewhere.bench_id = "bench-b";
  store_example(store, elsewhere);
  const std::int64_t last = store_example(store);
  const std::int64_t stopped = store.begin_run(example_run());
  store.end_run(stopped, db::Outcome::kStopped, "", db::SafeState::kVerified, kUtc);
  const auto found = store.timed_sequences("bench-a", 2);
  REQUIRE(found.size() == 4);
  CHECK((found[0].run == last && found[0].sequence == 0 && found[1].run == last && found[1].sequence == 1));
  CHECK((found[2].run == second && found[3].run == second));
  CHECK((found[1].recipe_sha256 == "rb" && found[1].repeats == 1 && found[1].frames_per_repeat == 4));
  CHECK(found[1].overrides_json == example_run().overrides_json);
  CHECK(store.timed_sequences("bench-b", 9).size() == 2);
  CHECK(store.timed_sequences("bench-c", 9).empty());
}
