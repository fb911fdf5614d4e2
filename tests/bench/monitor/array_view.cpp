// The array's newest picture: of the last frame, of the seating check before it, and which taxels are dead.
#include "bench/monitor/array_view.h"

#include <catch2/catch.hpp>

#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

// An array of 3 x 2, 0.1 V a count: one taxel answers the seating check by 0.04 V.
struct Example {
  Example() : store(db::RunStore::open(folder.path("runs.db"))), begun(begin_example(store)) {}
  void check_seating() {
    store.append_check(begun.run, {begun.run,
                                   1,
                                   "seating",
                                   "pass",
                                   R"({"pressure_psi":8.01,"rows":3,"columns":2,"volts_per_count":0.1})",
                                   {1, 2, 3, 4, 5, 6, 11, 12, 13, 14, 15.6, 6.4}});
  }
  void take_frame(double reference_psi, std::vector<std::uint16_t> counts) {
    db::FrameRecord frame = example_frame(begun.branch, 0);
    frame.wrench.reset();
    frame.reference_psi = reference_psi;
    frame.counts = std::move(counts);
    store.append_frame(begun.run, frame);
  }
  [[nodiscard]] std::optional<ArrayView> view() const { return newest_array(store, store.run(begun.run)); }
  TemporaryFolder folder;
  db::RunStore store;
  Begun begun;
};

}  // namespace

TEST_CASE("array view: none before the first frame, then the seating check, then the last frame") {
  Example example;
  CHECK_FALSE(example.view());
  example.check_seating();
  const auto seating = example.view();
  REQUIRE(seating);
  CHECK(seating->title == "seating check at 8.0 psi");
  CHECK((seating->rows == 3 && seating->columns == 2));
  CHECK(seating->volts.at(4) == Approx(1.56));
  CHECK(seating->full_scale_v == Approx(6553.5));
  CHECK(seating->dead_are_known);
  CHECK(seating->dead == std::vector<int>{5});
  example.take_frame(8.0, {10, 20, 30, 40, 50, 6, 12, 22, 32, 42, 52, 6});
  const auto frame = example.view();
  REQUIRE(frame);
  CHECK(frame->title == "frame 1 at 8.0 psi");
  CHECK(frame->volts.at(0) == Approx(1.1));  // the mean of both scans
  CHECK(frame->dead == std::vector<int>{5});
}

TEST_CASE("array view: at low pressure, without a seating check and under an indenter no taxel is called dead") {
  Example example;
  const std::vector<std::uint16_t> counts = {10, 20, 30, 40, 50, 6, 12, 22, 32, 42, 52, 6};
  example.take_frame(8.0, counts);
  CHECK_FALSE(example.view()->dead_are_known);
  example.check_seating();
  example.take_frame(4.9, counts);
  CHECK_FALSE(example.view()->dead_are_known);
  CHECK(example.view()->dead.empty());
  example.store.append_frame(example.begun.run, example_frame(example.begun.branch, 0));
  CHECK(example.view()->title == "frame 3 at 6.20 N");
  CHECK_FALSE(example.view()->dead_are_known);
}

TEST_CASE("array view: a scanner without a scale gives none") {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"));
  db::RunRecord run = example_run();
  run.devices.pop_back();
  const Begun begun = begin_example(store, run);
  store.append_frame(begun.run, example_frame(begun.branch, 0));
  CHECK_FALSE(newest_array(store, store.run(begun.run)));
}
