// The newest frame and events of a run, as a second process sees them.
#include "db/run_look.h"

#include <catch2/catch.hpp>

#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;

TEST_CASE("newest: the last frame of a run with its position, while the run is written") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const Begun begun = begin_example(store);
  const RunStore reader = RunStore::open_read_only(folder.path("runs.db"));
  CHECK_FALSE(db::RunLook(reader, begun.run).newest());
  CHECK_FALSE(db::RunLook(reader, 99).newest());
  store.append_frame(begun.run, example_frame(begun.branch, 0));
  db::FrameRecord last = example_frame(begun.branch, 1);
  store.append_frame(begun.run, last);
  const Begun other = begin_example(store);
  store.append_frame(other.run, example_frame(other.branch, 5));
  const auto frame = db::RunLook(reader, begun.run).newest();
  REQUIRE(frame);
  CHECK(frame->position == 2);
  CHECK(frame->setpoint_psi == last.setpoint_psi);
  CHECK(frame->reference_psi == last.reference_psi);
  CHECK((frame->rows == 3 && frame->columns == 2 && frame->scans == 2));
  CHECK(frame->counts == last.counts);
  REQUIRE(frame->wrench);
  CHECK(frame->wrench->wrench[2] == -6.2);
  last.wrench.reset();
  store.append_frame(begun.run, last);
  CHECK(db::RunLook(reader, begun.run).newest()->position == 3);
  CHECK_FALSE(db::RunLook(reader, begun.run).newest()->wrench);
}

TEST_CASE("newest: events of one run, newest first, no more than are wanted") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
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
