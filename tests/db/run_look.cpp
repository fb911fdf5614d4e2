// Frames of a run as a second process follows them: from a position on, so many at a time, and none of another run.
#include <catch2/catch.hpp>
#include <filesystem>
#include <stdexcept>

#include "db/run_look.h"
#include "db/sqlite.h"
#include "tests/db/new_store.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;
using db::sqlite::Access;
using db::sqlite::Connection;
using Positions = std::vector<std::int64_t>;

namespace {

// Three runs of which the second, of five frames, is looked at.
struct Looked {
  TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  std::int64_t run = 0, branch = 0;
  Looked() {
    store_example(store);
    const Begun begun = begin_example(store);
    run = begun.run;
    branch = begun.branch;
    for (int i = 0; i < 5; ++i) store.append_frame(run, example_frame(branch, i));
    const Begun next = begin_example(store);
    store.append_frame(next.run, example_frame(next.branch, 9));
  }
  [[nodiscard]] db::RunLook look() const { return {RunStore::open_read_only(store.path()), run}; }
};

Positions after(db::RunLook& look, std::int64_t position, int most) {
  Positions seen;
  look.frames_after(position, most, [&](const db::SeenFrame& frame) { seen.push_back(frame.position); });
  return seen;
}

}  // namespace

TEST_CASE("frames after a position come in their order, at most so many, and none of a neighbour") {
  const Looked looked;
  db::RunLook look = looked.look();
  CHECK(after(look, 0, 99) == Positions{1, 2, 3, 4, 5});
  CHECK(after(look, 0, 2) == Positions{1, 2});
  CHECK(after(look, 2, 2) == Positions{3, 4});
  CHECK(after(look, 4, 2) == Positions{5});
  CHECK(after(look, 5, 2).empty());
  CHECK(after(look, 3, 0).empty());
  CHECK(after(look, -1, 1) == Positions{1});
  CHECK(after(look, -2, 99) == Positions{1, 2, 3, 4, 5});  // none of the run before
}

TEST_CASE("the position before the newest frames is counted from the end, and of too few frames it is the start") {
  const Looked looked;
  db::RunLook look = looked.look();
  CHECK(look.before_newest(0) == 5);
  CHECK(look.before_newest(2) == 3);
  CHECK(look.before_newest(4) == 1);
  CHECK(look.before_newest(5) == 0);
  CHECK(look.before_newest(99) == 0);
  const RunStore reader = RunStore::open_read_only(looked.store.path());
  CHECK(db::RunLook(reader, 99).before_newest(0) == 0);
  CHECK_FALSE(db::RunLook(reader, 99).newest());
}

TEST_CASE("a frame that is looked at has all that was measured, and whether it counts") {
  Looked looked;
  db::FrameRecord bare = example_frame(looked.branch, 7);
  bare.wrench.reset();
  bare.flags.clear();
  looked.store.append_frame(looked.run, bare);
  db::RunLook look = looked.look();
  std::vector<db::SeenFrame> seen;
  look.frames_after(4, 9, [&](const db::SeenFrame& frame) { seen.push_back(frame); });
  REQUIRE(seen.size() == 2);
  const db::FrameRecord given = example_frame(looked.branch, 4);
  CHECK((seen[0].position == 5 && seen[0].time_ns == given.time_ns && seen[0].setpoint_psi == given.setpoint_psi));
  CHECK((seen[0].feedback_psi == given.feedback_psi && seen[0].reference_psi == given.reference_psi));
  CHECK((seen[0].rows == 3 && seen[0].columns == 2 && seen[0].scans == 2 && seen[0].counts == given.counts));
  CHECK((seen[0].flags == "dwell" && !seen[0].is_void));
  REQUIRE(seen[0].wrench);
  CHECK((seen[0].wrench->target_n == 6.1 && seen[0].wrench->force_start_n == 6.3));
  CHECK((seen[0].wrench->wrench == given.wrench->wrench && seen[0].wrench->place_mm == given.wrench->place_mm));
  CHECK((seen[1].position == 6 && seen[1].flags.empty() && !seen[1].wrench));
  looked.store.void_branch(looked.branch, "scanner lost");
  REQUIRE(look.newest());
  CHECK(look.newest()->is_void);
  Connection(looked.store.path(), Access::kReadWrite)
      .execute("PRAGMA foreign_keys = OFF; UPDATE frames SET branch = 77 WHERE frame = 2000000006");
  CHECK_FALSE(look.newest()->is_void);  // of no branch
}

TEST_CASE("a frame that was pressed with no force yet is a pressed one, too") {
  Looked looked;
  db::FrameRecord frame = example_frame(looked.branch, 7);
  frame.wrench->target_n = 0.0;
  frame.wrench->force_start_n = 0.0;
  looked.store.append_frame(looked.run, frame);
  db::RunLook look = looked.look();
  const std::optional<db::SeenFrame> seen = look.newest();
  REQUIRE((seen && seen->wrench));
  CHECK((seen->wrench->target_n == 0.0 && seen->wrench->force_start_n == 0.0));
  CHECK((seen->wrench->wrench == frame.wrench->wrench && seen->wrench->place_mm == frame.wrench->place_mm));
}

TEST_CASE("a frame whose counts do not fit its shape is not shown, and the next question finds the others") {
  const Looked looked;
  Connection(looked.store.path(), Access::kReadWrite)
      .execute("PRAGMA ignore_check_constraints = ON; UPDATE frames SET scans = 3 WHERE frame = 2000000004");
  db::RunLook look = looked.look();
  CHECK(store_error([&] { (void)after(look, 2, 9); }) == "TB-STORE-SQL");
  CHECK(after(look, 4, 9) == Positions{5});
}

TEST_CASE("who looked at some of the frames does not hold the log of who writes") {
  Looked looked;
  db::RunLook look = looked.look();
  CHECK(after(look, 0, 2).size() == 2);
  const auto breaks_off = [](const db::SeenFrame&) { throw std::runtime_error("enough"); };
  CHECK_THROWS_WITH(look.frames_after(0, 9, breaks_off), "enough");
  REQUIRE(look.newest());
  looked.store.append_frame(looked.run, example_frame(looked.branch, 5));
  Connection writer(looked.store.path(), Access::kReadWrite, 0);
  CHECK(writer.integer("PRAGMA wal_checkpoint(TRUNCATE)") == 0);  // 1: somebody still reads it
  CHECK(std::filesystem::file_size(looked.store.path() + "-wal") == 0);
  CHECK(look.newest()->position == 6);
}

TEST_CASE("newest: events of one run, newest first, no more than are wanted") {
  NewStore store;
  const Begun begun = begin_example(store);
  for (int i = 1; i <= 4; ++i) store.append_event(begun.run, {i, "kind", "TB-ID", std::to_string(i)});
  store.append_event(begin_example(store).run, {9, "other", "", ""});
  std::vector<std::string> seen;
  store.newest_events(begun.run, [&](const db::EventRecord& event) {
    CHECK((event.kind == "kind" && event.id == "TB-ID" && std::to_string(event.time_ns) == event.detail));
    seen.push_back(event.detail);
    return seen.size() < 3;
  });
  CHECK(seen == std::vector<std::string>{"4", "3", "2"});
}

TEST_CASE("a seen frame's mean counts are those of its scans, taxel by taxel") {
  db::SeenFrame frame;
  frame.scans = 2;
  frame.rows = 1;
  frame.columns = 3;
  frame.counts = {1, 2, 65535, 4, 2, 65534};
  CHECK(db::mean_counts(frame) == std::vector<double>{2.5, 2.0, 65534.5});
  frame.scans = 1;
  frame.rows = 3;
  frame.columns = 2;
  CHECK(db::mean_counts(frame) == std::vector<double>{1, 2, 65535, 4, 2, 65534});
}
