// HDF5 of runs that lack something, of frames of several shapes, and the file that appears whole or not at all.
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/cli/export/run_export.h"
#include "bench/common/error.h"
#include "tests/bench/cli/export/told_file.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

struct StoreForHdf5 {
  // What a file is told of a run with these frames.
  std::string told(const db::RunRecord& run, const std::vector<db::FrameRecord>& frames) {
    const Begun begun = begin_example(store, run);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      db::FrameRecord frame = frames[i];
      frame.branch = begun.branch;
      frame.ordinal = static_cast<int>(i);
      store.append_frame(begun.run, frame);
    }
    store.end_run(begun.run, db::Outcome::kCompleted, "", db::SafeState::kVerified, kUtc);
    ToldFile file;
    bench::put_run(file, store, store.run(begun.run));
    return file.text();
  }
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path("out")))
      names.push_back(entry.path().filename().string());
    return names;
  }
  TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
};

db::FrameRecord shaped_frame(int scans, int rows, int columns) {
  db::FrameRecord frame;
  frame.scans = scans;
  frame.rows = rows;
  frame.columns = columns;
  frame.counts.assign(static_cast<std::size_t>(scans * rows * columns), 7);
  return frame;
}

std::string refused_shape(StoreForHdf5& store, const std::vector<db::FrameRecord>& frames) {
  try {
    (void)store.told(example_run(), frames);
  } catch (const bench::Error& error) {
    return error.id() + ": " + error.what() + ", " + error.where() + ", " + error.remedy();
  }
  return "taken";
}

}  // namespace

TEST_CASE("HDF5: a run without frames, forces, devices and rest, and volts of a count that are not stated") {
  StoreForHdf5 store;
  db::RunRecord run = example_run();
  run.devices.clear();
  run.git_dirty = false;
  const std::string none = store.told(run, {});
  CHECK_THAT(none, Catch::Contains("\n/@rest_s nan real\n") && Catch::Contains("\n/@git_dirty 0\n") &&
                       Catch::Contains("\naxis /frames/frame 0..0\n") &&
                       Catch::Contains("\naxis /frames/scan 0..0\naxis /frames/row 0..0\naxis /frames/column "
                                       "0..0\ncounts /frames/counts [count] (0x0x0x0) \n") &&
                       Catch::Contains("\n/frames/counts@volts_per_count nan real\ngroup /trace\n"));
  const auto scale_of = [&](const std::vector<std::string>& calibrations) {
    run.devices.clear();
    for (const std::string& json : calibrations) run.devices.push_back({"x", "M", "1", "", "simulated", json});
    const std::string text = store.told(run, {shaped_frame(1, 1, 1)});
    const std::string head = "/frames/counts@volts_per_count ";
    const std::size_t at = text.find(head) + head.size();
    return text.substr(at, text.find(' ', at) - at);
  };
  CHECK(scale_of({R"([1])", R"("volts_per_count")", "", "{"}) == "nan");
  CHECK(scale_of({R"({"volts_per_count": "0.5"})"}) == "nan");
  CHECK(scale_of({R"({"span": 1})", R"({"volts_per_count": 0.25})", R"({"volts_per_count": 0.75})"}) == "0.25");
}

TEST_CASE("HDF5: frames of other rows, other columns or other scans are refused, and alike ones are not") {
  StoreForHdf5 store;
  const std::string refused =
      "TB-EXPORT-HDF5: the run's frames are not all of one shape, run N, take --format json, which holds frames of any "
      "shape";
  CHECK(refused_shape(store, {shaped_frame(2, 1, 2), shaped_frame(2, 1, 2)}) == "taken");
  CHECK(refused_shape(store, {shaped_frame(2, 1, 2), shaped_frame(1, 2, 2)}).starts_with("TB-EXPORT-HDF5: the run's"));
  CHECK(refused_shape(store, {shaped_frame(2, 2, 2), shaped_frame(4, 2, 1)}).starts_with("TB-EXPORT-HDF5: the run's"));
  std::string last = refused_shape(store, {shaped_frame(2, 1, 2), shaped_frame(2, 1, 2), shaped_frame(3, 1, 2)});
  CHECK(last.find(", run ") != std::string::npos);
  last.replace(last.find(", run ") + 6, last.find(", take") - last.find(", run ") - 6, "N");
  CHECK(last == refused);
}

TEST_CASE("HDF5: the file takes the place of an older one when it is whole, and is not there after an error") {
  StoreForHdf5 store;
  std::filesystem::create_directory(store.folder.path("out"));
  const db::RunRecord run = store.store.run(store_known_run(store.store));
  const std::string path = store.folder.path("out/run.h5");
  write_file(path, "older");
  try {
    const std::size_t bytes = bench::write_run_hdf5(store.store, run, path);
    CHECK(bytes == std::filesystem::file_size(path));
  } catch (const bench::Error& error) {
    CHECK_THAT(error.what(), Catch::Contains("built without libhdf5"));
    WARN("skipped: no libhdf5 in this build");
    return;
  }
  CHECK(read_file(path).starts_with("\x89HDF\r\n\x1a\n"));
  CHECK(store.files() == std::vector<std::string>{"run.h5"});
  std::filesystem::remove(path);
  (void)refused_shape(store, {shaped_frame(2, 1, 2), shaped_frame(1, 1, 2)});
  CHECK_THROWS_AS(bench::write_run_hdf5(store.store, store.store.run(2), path), bench::Error);
  CHECK(store.files().empty());
}
