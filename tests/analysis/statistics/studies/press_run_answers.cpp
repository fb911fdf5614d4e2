// Presses as they are read from a run's record, frame by frame, and where an array lies under the stage.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/error.h"
#include "analysis/statistics/studies/press_run.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

db::BranchRecord branch_of_force(std::int64_t number, int sequence, int repeat, int ordinal, double from_n,
                                 double to_n) {
  db::BranchRecord branch;
  branch.branch = number;
  branch.sequence = sequence;
  branch.repeat = repeat;
  branch.ordinal = ordinal;
  branch.from_n = from_n;
  branch.to_n = to_n;
  return branch;
}

// One row of two taxels, two scans: 100 and 200, then 300 and 500 counts.
db::FrameRecord pressed_frame(std::int64_t branch, double target_n, double fz_n) {
  db::FrameRecord frame;
  frame.branch = branch;
  frame.time_ns = 2'500'000'000;
  frame.rows = 1;
  frame.columns = 2;
  frame.scans = 2;
  frame.counts = {100, 200, 300, 500};
  db::WrenchRecord wrench;
  wrench.target_n = target_n;
  wrench.force_start_n = target_n;
  wrench.wrench = {1, 2, fz_n, 4, 5, 6};
  wrench.place_mm = {7, 8, 9};
  frame.wrench = wrench;
  return frame;
}

StoredRun stored_presses() {
  StoredRun run;
  run.record.run = 4;
  run.record.origin = "simulated";
  run.record.sensor_serial = "S";
  run.record.scanner_serial = "C";
  run.record.sequences = {{0, "production", "", "", 1, 1}, {1, "ring", "", "", 1, 1}, {2, "point", "", "", 1, 1}};
  run.record.devices = {{"tactile scanner", "T", "3", "", "simulated", R"({"volts_per_count":0.001})"}};
  run.branches = {branch_of_force(21, 1, 0, 0, 0, 20), branch_of_force(22, 1, 0, 1, 20, 0),
                  branch_of_force(23, 1, 1, 5, 20, 0), branch_of_force(24, 2, 0, 6, 10, 10)};
  run.frames = {pressed_frame(21, 10, -9.5), pressed_frame(22, 5, 4.5), pressed_frame(23, 5, -4.75),
                pressed_frame(24, 10, 10.5)};
  return run;
}

}  // namespace

TEST_CASE("presses by hand: by sequence, with repeat, place, direction, force and the mean of the scans in volts") {
  const std::vector<PressRun> presses = load_press_runs(stored_presses());
  REQUIRE(presses.size() == 2);
  const PressRun& ring = presses[0];
  CHECK(ring.run == 4);
  CHECK(ring.sequence == "ring");
  CHECK(ring.object.empty());
  CHECK((ring.origin == "simulated" && ring.sensor_serial == "S" && ring.scanner_serial == "C"));
  CHECK((ring.rows == 1 && ring.columns == 2));
  CHECK(ring.mount.empty());
  REQUIRE(ring.frames.size() == 3);
  const PressFrame& first = ring.frames[0];
  CHECK(first.time_s == Approx(2.5));
  CHECK(first.target_n == 10.0);
  CHECK(first.wrench == std::array<double, 6>{1, 2, -9.5, 4, 5, 6});
  CHECK(first.place_mm == std::array<double, 3>{7, 8, 9});
  REQUIRE(first.volts.size() == 2);
  CHECK(first.volts[0] == Approx(0.2));   // (100 + 300) / 2 counts of 1 mV
  CHECK(first.volts[1] == Approx(0.35));  // (200 + 500) / 2
  // A rising and a falling branch a place: 0 and 1 are the first, 5 the third, 6 the fourth one.
  CHECK((first.repeat == 0 && first.position == 0 && first.rising));
  CHECK((ring.frames[1].repeat == 0 && ring.frames[1].position == 0 && !ring.frames[1].rising));
  CHECK((ring.frames[2].repeat == 1 && ring.frames[2].position == 2 && !ring.frames[2].rising));
  CHECK(presses[1].sequence == "point");
  CHECK((presses[1].frames[0].position == 3 && presses[1].frames[0].rising));  // 10 N all the way: not a fall
  // Pressing is positive whichever sign the force sensor has.
  CHECK(first.force_n == 9.5);
  CHECK(ring.frames[1].force_n == 4.5);
  CHECK(ring.frames[2].force_n == 4.75);
  const std::vector<PointFrame> points = point_frames(ring);
  REQUIRE(points.size() == 3);
  CHECK((points[2].position == 2 && !points[2].rising && points[2].force_n == 4.75));
  CHECK(points[0].volts == first.volts);
}

TEST_CASE("presses: a pull stays negative, and a force that was never taken out keeps its sign") {
  StoredRun run = stored_presses();
  run.frames = {pressed_frame(21, 10, 0.25), pressed_frame(21, 10, -0.5)};
  run.frames[0].wrench->force_start_n = -1.0;  // pulls at the dwell's start, too: the sensor shows presses as negative
  run.frames[1].wrench->force_start_n = 0.0;
  const PressRun ring = load_press_runs(run).front();
  CHECK(ring.frames[0].force_n == -0.25);
  CHECK(ring.frames[1].force_n == -0.5);
}

TEST_CASE("presses: void branches, frames without a force and of unknown branches do not count") {
  StoredRun run = stored_presses();
  run.branches[0].is_void = true;
  run.frames[1].wrench.reset();
  run.frames[2].branch = 99;
  const std::vector<PressRun> presses = load_press_runs(run);
  REQUIRE(presses.size() == 1);
  CHECK(presses[0].sequence == "point");
  run.frames[3].wrench.reset();
  run.record.devices.clear();  // nothing is pressed: nothing asks for the scanner's scale
  CHECK(load_press_runs(run).empty());
}

TEST_CASE("presses: a frame that does not hold its scans is refused") {
  const auto refused = [](int scans, std::size_t counts) {
    StoredRun run = stored_presses();
    run.frames[0].scans = scans;
    run.frames[0].counts.resize(counts);
    try {
      (void)load_press_runs(run);
    } catch (const AnalysisError& error) {
      return error.id();
    }
    return std::string();
  };
  CHECK(refused(2, 4).empty());
  CHECK(refused(1, 2).empty());
  CHECK(refused(2, 3) == "TB-ANALYSIS-FRAME");
  CHECK(refused(0, 0) == "TB-ANALYSIS-FRAME");
  CHECK(refused(-1, 0) == "TB-ANALYSIS-FRAME");
}

TEST_CASE("a registration is the last complete one that was stored, with its defaults") {
  StoredRun run = stored_presses();
  const auto check_of = [](const char* kind, const char* json) {
    db::CheckRecord check;
    check.kind = kind;
    check.detail_json = json;
    return check;
  };
  run.checks = {check_of("seating", R"({"angle_deg":1,"offset_mm":[0,0]})"),
                check_of("mount", R"({"angle_deg":30,"offset_mm":[1,2],"flipped":true,"scale":1.5})")};
  REQUIRE(mount_of(run).size() == 1);
  const MountTransform first = mount_of(run).front();
  CHECK(first.run == 4);
  CHECK((first.angle_deg == 30.0 && first.scale == 1.5 && first.flipped));
  CHECK(first.offset_mm == std::array<double, 2>{1, 2});
  run.checks.push_back(check_of("mount", R"({"angle_deg":-5,"offset_mm":[3,4]})"));
  run.checks.push_back(check_of("mount", R"({"angle_deg":7})"));
  run.checks.push_back(check_of("mount", R"({"offset_mm":[3,4]})"));
  run.checks.push_back(check_of("mount", "[7]"));
  REQUIRE(mount_of(run).size() == 1);
  const MountTransform last = mount_of(run).front();
  CHECK((last.angle_deg == -5.0 && last.scale == 1.0 && !last.flipped));
  CHECK(load_press_runs(run).front().mount.front().angle_deg == -5.0);
  run.checks.erase(run.checks.begin() + 1, run.checks.begin() + 3);
  CHECK(mount_of(run).empty());
}

TEST_CASE("a registration by hand: turned by 30 degrees, twice as large, moved and mirrored") {
  // stage = 2 R(30) taxel + (10, 20). Taxel (2, 1): R gives (sqrt 3 - 1/2, 1 + sqrt 3 / 2).
  MountTransform mount;
  mount.angle_deg = 30.0;
  mount.scale = 2.0;
  mount.offset_mm = {10.0, 20.0};
  const double x = 10.0 + 2.0 * (std::sqrt(3.0) - 0.5), y = 20.0 + 2.0 * (1.0 + std::sqrt(3.0) / 2.0);
  CHECK(mount.taxel_mm(x, y)[0] == Approx(2.0));
  CHECK(mount.taxel_mm(x, y)[1] == Approx(1.0));
  mount.flipped = true;  // the mirror comes first: the same place of the stage is taxel (2, -1)
  CHECK(mount.taxel_mm(x, y)[0] == Approx(2.0));
  CHECK(mount.taxel_mm(x, y)[1] == Approx(-1.0));
  CHECK(mount.taxel_mm(10.0, 20.0)[0] == Approx(0.0).margin(1e-12));
}
