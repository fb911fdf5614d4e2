// runs export --format hdf5 of a run whose frames are not all of one shape, which one array cannot hold.
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "db/run_store.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

struct Shape {
  int scans, rows, columns;
};

void store_frames(db::RunStore& store, const std::vector<Shape>& shapes) {
  db::RunRecord run;
  run.uuid = db::new_uuid();
  run.origin = "simulated";
  run.state = "prepared";
  run.bench_toml = "bench";
  run.sequences = {{0, "up", "recipe", "", static_cast<int>(shapes.size()), 1}};
  const std::int64_t number = store.begin_run(run);
  db::FrameRecord frame;
  frame.branch = store.begin_branch(number, {});
  for (const Shape& shape : shapes) {
    frame.scans = shape.scans;
    frame.rows = shape.rows;
    frame.columns = shape.columns;
    frame.counts.assign(static_cast<std::size_t>(shape.scans * shape.rows * shape.columns), 7);
    store.append_frame(number, frame);
    ++frame.ordinal;
  }
  store.end_run(number, db::Outcome::kCompleted, "", db::SafeState::kVerified, "");
}

}  // namespace

TEST_CASE("a run whose frames are not of one shape is not exported as HDF5, and JSON holds it") {
  const TemporaryFolder folder;
  {
    db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
    store_frames(store, {{2, 1, 2}, {2, 1, 2}, {2, 1, 2}});
    store_frames(store, {{2, 1, 2}, {1, 2, 2}});  // as many counts, other rows
    store_frames(store, {{2, 2, 2}, {4, 2, 1}});  // as many counts, other columns
    store_frames(store, {{2, 1, 2}, {2, 1, 2}, {3, 1, 2}});
  }
  const Finished alike = call(folder, {"runs", "export", "1", "--format", "hdf5", "-o", "run.h5"});
  if (alike.code != 0) {
    CHECK_THAT(alike.err, Catch::Contains("built without"));
    WARN("skipped: no libhdf5 in this build");
    return;
  }
  for (const char* run : {"2", "3", "4"}) {
    CAPTURE(run);
    const Finished refused = call(folder, {"runs", "export", run, "--format", "hdf5", "-o", "other.h5"});
    CHECK(refused.code == 2);
    CHECK_THAT(refused.err, Catch::Contains("[TB-EXPORT-HDF5]") &&
                                Catch::Contains("the run's frames are not all of one shape") &&
                                Catch::Contains("--format json"));
    CHECK_FALSE(std::filesystem::exists(folder.path("other.h5")));
    CHECK(call(folder, {"runs", "export", run, "--format", "json", "-o", "run.json"}).code == 0);
  }
}
