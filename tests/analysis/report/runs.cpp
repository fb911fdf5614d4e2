// Runs: a value read once is kept, and a part of a run that cannot be read does not affect the others.
#include "analysis/report/runs.h"

#include <catch2/catch.hpp>

#include "tests/db/new_store.h"

using namespace tactbench;
using namespace tactbench::analysis;
using namespace tactbench::tests;

namespace {

// One complete repeat of the sequence "down" under an indenter, at 23 °C.
Begun begin_pressed(db::RunStore& store, const db::RunRecord& record = example_run()) {
  const Begun begun = begin_example(store, record);
  for (int i = 0; i < 4; ++i) store.append_frame(begun.run, example_frame(begun.branch, i));
  store.append_event(begun.run, {5, "environment", "temperature_c", "23.0"});
  return begun;
}

template <class Action>
std::string analysis_error(Action action) {
  try {
    action();
  } catch (const AnalysisError& error) {
    return error.id();
  }
  return {};
}

}  // namespace

TEST_CASE("a run is read on first use, and the result does not change") {
  NewStore store;
  const Begun begun = begin_pressed(store);
  analysis::Runs runs(store);
  const db::RunRecord& record = runs.record(begun.run);
  const Dataset& dataset = runs.dataset(begun.run);
  const Dataset loaded = load_dataset(store, begun.run);
  REQUIRE(dataset.sequences.size() == 1);
  CHECK(dataset.sequences[0].repeats.at(0).volts == loaded.sequences.at(0).repeats.at(0).volts);
  CHECK(dataset.noise_v == loaded.noise_v);

  store.void_branch(begun.branch, "the scanner was lost");
  store.append_event(begun.run, {6, "environment", "temperature_c", "28.0"});
  store.add_note(begun.run, "later");
  CHECK(&runs.dataset(begun.run) == &dataset);
  CHECK((&runs.record(begun.run) == &record && record.notes.empty()));
  CHECK((runs.history(begun.run).frames == 4 && runs.history(begun.run).void_frames == 0));
  CHECK(runs.press_runs(begun.run).at(0).frames.size() == 4);
  CHECK(runs.temperatures_c(begun.run) == std::vector{23.0});
  CHECK(&runs.store() == &store);

  analysis::Runs later(store);
  CHECK((later.history(begun.run).frames == 0 && later.history(begun.run).void_frames == 4));
  CHECK(later.press_runs(begun.run).empty());
  CHECK(later.temperatures_c(begun.run) == std::vector{23.0, 28.0});
  CHECK(analysis_error([&] { later.dataset(begun.run); }) == "TB-ANALYSIS-EMPTY");
}

TEST_CASE("a run without a dataset throws the reason each time, and still has its row and history") {
  NewStore store;
  db::RunRecord record = example_run();
  record.devices.pop_back();  // the scanner, whose calibration scales the counts
  const Begun begun = begin_pressed(store, record);
  analysis::Runs runs(store);
  for (int i = 0; i < 2; ++i) {
    CHECK(analysis_error([&] { runs.dataset(begun.run); }) == "TB-ANALYSIS-NO-CALIBRATION");
    CHECK(analysis_error([&] { runs.press_runs(begun.run); }) == "TB-ANALYSIS-NO-CALIBRATION");
  }
  CHECK(runs.record(begun.run).sensor_serial == "S-1");
  CHECK(runs.history(begun.run).frames == 4);
  CHECK(runs.temperatures_c(begun.run).size() == 1);

  for (int i = 0; i < 2; ++i) {
    CHECK(store_error([&] { runs.record(7); }) == "TB-STORE-NOT-FOUND");
    CHECK(store_error([&] { runs.history(7); }) == "TB-STORE-NOT-FOUND");
  }
}
