// Every figure of an array under an object against answers worked out on paper. Taxel areas are such that 1 psi on a
// taxel is 1 N; the taxels of straight_array.h stand at -2, 0 and 2 mm, the last one dead. Raw figures read both live
// ones by the mean taxel's line, 15 psi a volt here.

#include <catch2/catch.hpp>

#include <cmath>
#include <stdexcept>

#include "analysis/error.h"
#include "analysis/statistics/numbers/moments.h"
#include "analysis/statistics/studies/contact.h"
#include "analysis/statistics/studies/studies.h"
#include "tests/analysis/support/alike.h"
#include "tests/analysis/support/straight_array.h"

using namespace straight_array;

namespace {

const ArrayGeometry kOneNewtonAPsi{2.0, 1.0 / kNewtonPerPsiMm2};

SensorModel press_fit() {
  SensorModel fit = straight_fit();
  by_hand::finish(fit, straight_taxel(15.0));
  return fit;
}

struct Press {
  int position;
  bool rising;
  double target_n, force_n, first_v, second_v, place_x_mm, torque_x_nmm, torque_y_nmm;
};

// volts -> raw psi, compensated psi, and where their centres lie (x in mm):
//   (0.5, 1.5)   -> ( 7.5, 22.5) at -0.5, (10, 15) at -0.8
//   (1, 1)       -> (15, 15)     at -1,   (20, 10) at -4/3
//   (1, 3)       -> (15, 45)     at -0.5, (20, 30) at -0.8
//   (1.5, 0.5)   -> (22.5, 7.5)  at -1.5, (30, 5)  at -12/7
//   (3, 1)       -> (45, 15)     at -1.5, (60, 10) at -12/7; 60 psi is the end of the first taxel's model
//   (0.75, 0.25) -> (11.25, 3.75) at -1.5, (15, 2.5) at -12/7
PressRun press_run() {
  PressRun run;
  run.run = 9;
  run.sequence = "ring";
  run.object = "ring";
  run.origin = "simulated";
  run.sensor_serial = "S";
  run.rows = 1;
  run.columns = 3;
  for (const Press& press : {Press{0, true, 10, 28, 0.5, 1.5, 2, 3, 4}, Press{0, true, 30, 31, 1, 1, 2, 0, 0},
                             Press{0, false, 10, 52, 1, 3, 2, 0, 0}, Press{1, true, 10, 31, 1.5, 0.5, 3, 6, 8},
                             Press{1, true, 30, 66, 3, 1, 3, 0, 0}, Press{1, false, 10, 16, 0.75, 0.25, 3, 0, 0}}) {
    PressFrame frame;
    frame.position = press.position;
    frame.rising = press.rising;
    frame.target_n = press.target_n;
    frame.force_n = press.force_n;
    frame.wrench[3] = press.torque_x_nmm;
    frame.wrench[4] = press.torque_y_nmm;
    frame.place_mm = {press.place_x_mm, 0.0, 0.0};
    frame.volts = {press.first_v, press.second_v, 9.0};
    run.frames.push_back(frame);
  }
  return run;
}

}  // namespace

TEST_CASE("contact: forces, their errors per level and run, and clamped taxels match hand-computed values") {
  const ContactResult result = contact_result(press_run(), press_fit(), kOneNewtonAPsi);
  CHECK(result.positions == 2);
  CHECK(result.repeats == 1);
  CHECK(result.geometry.taxel_area_mm2 == kOneNewtonAPsi.taxel_area_mm2);
  REQUIRE(result.levels.size() == 3);
  const ContactLevel &ten = result.levels[0], &thirty = result.levels[1], &falling = result.levels[2];
  CHECK((ten.rising && thirty.rising && !falling.rising));
  // 10 N: sums of 30 and 30 N raw, 25 and 35 N compensated, against 28 and 31 N.
  CHECK(ten.frames == 2);
  CHECK(ten.force_n == Approx(29.5));
  CHECK(ten.raw.force_n == Approx(30.0));
  CHECK(ten.compensated.force_n == Approx(30.0));
  CHECK(ten.raw_force_error_n == Approx((2.0 + 1.0) / 2));
  CHECK(ten.compensated_force_error_n == Approx((3.0 + 4.0) / 2));
  CHECK(ten.torque_nmm == Approx((5.0 + 10.0) / 2));
  CHECK(ten.clamped_taxels == 0.0);
  // 30 N: 30 and 60, 30 and 70 N against 31 and 66 N.
  CHECK(thirty.raw_force_error_n == Approx((1.0 + 6.0) / 2));
  CHECK(thirty.compensated_force_error_n == Approx((1.0 + 4.0) / 2));
  CHECK(thirty.clamped_taxels == Approx(0.5));  // one taxel of one of the two frames
  // 10 N falling: 60 and 15, 50 and 17.5 N against 52 and 16 N.
  CHECK(falling.raw_force_error_n == Approx((8.0 + 1.0) / 2));
  CHECK(falling.compensated_force_error_n == Approx((2.0 + 1.5) / 2));
  // Six frames off by 2 1 8 1 6 1 N raw, 3 1 2 4 4 1.5 N compensated.
  CHECK(result.raw_mean_error_n == Approx(19.0 / 6));
  CHECK(result.raw_max_error_n == Approx(8.0));
  CHECK(result.compensated_mean_error_n == Approx(15.5 / 6));
  CHECK(result.compensated_max_error_n == Approx(4.0));
  PressRun other = press_run();
  other.sensor_serial = "another";
  CHECK_THROWS_AS(contact_result(other, press_fit(), kOneNewtonAPsi), AnalysisError);
}

TEST_CASE("contact: centre of pressure, moment, wander and distance from the axis match hand-computed values") {
  PressRun run = press_run();
  MountTransform mount;  // stage coordinates are taxel coordinates: the first taxel's centre at (0, 0)
  mount.run = 5;
  run.mount = {mount};
  const ContactResult result = contact_result(run, press_fit(), kOneNewtonAPsi);
  CHECK(result.mount_run == 5);
  const ContactLevel &ten = result.levels[0], &thirty = result.levels[1];
  CHECK(ten.raw.x_mm == Approx((-0.5 - 1.5) / 2));
  CHECK(ten.compensated.x_mm == Approx((-0.8 - 12.0 / 7) / 2));
  CHECK(ten.raw.y_mm == Approx(0.0).margin(1e-12));
  CHECK(ten.raw.moment_y_nmm == Approx(2.0 * (7.5 + 22.5) / 2));  // of the first taxel's force, 2 mm off the centre
  CHECK(ten.raw.area_mm2 == Approx(2.0 * kOneNewtonAPsi.taxel_area_mm2));
  CHECK(ten.raw.threshold_psi == Approx(2.25));
  CHECK(ten.compensated.threshold_psi == Approx((1.5 + 3.0) / 2));
  // At the first position the centre stands at -1/2, -1, -1/2 raw and at -4/5, -4/3, -4/5 compensated, in the mean at
  // -2/3 and -44/45; at the second one it does not move.
  CHECK(ten.raw_wander_mm == Approx((1.0 / 6) / 2));
  CHECK(ten.compensated_wander_mm == Approx((8.0 / 45) / 2));
  CHECK(thirty.raw_wander_mm == Approx((1.0 / 3) / 2));
  CHECK(thirty.compensated_wander_mm == Approx((16.0 / 45) / 2));
  // The object's axis stands at 2 and 3 mm of the stage, 0 and 1 mm from the array's centre.
  CHECK(ten.raw_place_error_mm == Approx((0.5 + 2.5) / 2));
  CHECK(ten.compensated_place_error_mm == Approx((0.8 + 12.0 / 7 + 1.0) / 2));
  const ContactResult unknown = contact_result(press_run(), press_fit(), kOneNewtonAPsi);
  CHECK(unknown.mount_run == 0);
  CHECK(std::isnan(unknown.levels[0].raw_place_error_mm));
}

TEST_CASE("contact: an upright array gives the same places along y, and moments about x") {
  PressRun run = press_run();
  run.rows = 3;
  run.columns = 1;
  for (PressFrame& frame : run.frames) std::swap(frame.place_mm[0], frame.place_mm[1]);
  MountTransform mount;
  run.mount = {mount};
  SensorModel fit = press_fit();
  fit.rows = 3;
  fit.columns = 1;
  const ContactLevel ten = contact_result(run, fit, kOneNewtonAPsi).levels[0];
  CHECK(ten.raw.x_mm == Approx(0.0).margin(1e-12));
  CHECK(ten.raw.y_mm == Approx((-0.5 - 1.5) / 2));
  CHECK(ten.raw.moment_x_nmm == Approx(-2.0 * (7.5 + 22.5) / 2));
  CHECK(ten.raw_wander_mm == Approx((1.0 / 6) / 2));
  CHECK(ten.compensated_wander_mm == Approx((8.0 / 45) / 2));
  CHECK(ten.raw_place_error_mm == Approx((0.5 + 2.5) / 2));
}

TEST_CASE("contact: frames and non-uniformity are those of the first position, over the fitted taxels") {
  const ContactResult result = contact_result(press_run(), press_fit(), kOneNewtonAPsi);
  const ContactLevel& ten = result.levels[0];
  CHECK(ten.raw_v == std::vector<double>{0.5, 1.5, 9.0});
  CHECK(ten.compensated_psi[0] == Approx(10.0));
  CHECK(ten.compensated_psi[1] == Approx(15.0));
  CHECK(std::isnan(ten.compensated_psi[2]));
  CHECK(ten.raw_std == Approx(1.0 / std::sqrt(2.0) / 4.0));
  CHECK(ten.compensated_std == Approx(5.0 / std::sqrt(2.0) / 60));
  // Up against down at 10 N: 0.5 and 1.5 V, 10 and 15 psi. The peak has no way down.
  REQUIRE(result.raw_distance.size() == 2);
  CHECK(result.raw_distance[0] == Approx(1.0 / 4.0));
  CHECK(result.compensated_distance[0] == Approx(12.5 / 60));
  CHECK(std::isnan(result.raw_distance[1]));
  CHECK(std::isnan(result.compensated_distance[1]));
}

// Presses as they are read from a run's record, frame by frame, and where an array lies under the stage.

using namespace tactbench;

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

TEST_CASE("press runs: sequence, repeat, position, direction, force and mean volts match hand-computed values") {
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

TEST_CASE("press runs: a pull stays negative, and a force that starts at 0 keeps its sign") {
  StoredRun run = stored_presses();
  run.frames = {pressed_frame(21, 10, 0.25), pressed_frame(21, 10, -0.5)};
  run.frames[0].wrench->force_start_n = -1.0;  // pulls at the dwell's start, too: the sensor shows presses as negative
  run.frames[1].wrench->force_start_n = 0.0;
  const PressRun ring = load_press_runs(run).front();
  CHECK(ring.frames[0].force_n == -0.25);
  CHECK(ring.frames[1].force_n == -0.5);
}

TEST_CASE("press runs: void branches, frames without a force and frames of unknown branches do not count") {
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

TEST_CASE("press runs: a frame with counts that do not match its scans is refused") {
  const auto refused = [](int scans, std::size_t counts) {
    StoredRun run = stored_presses();
    run.frames[0].scans = scans;
    run.frames[0].counts.resize(counts);
    return id_of_refusal([&] { return load_press_runs(run); });
  };
  CHECK(refused(2, 4).empty());
  CHECK(refused(1, 2).empty());
  CHECK(refused(2, 3) == "TB-ANALYSIS-FRAME");
  CHECK(refused(0, 0) == "TB-ANALYSIS-FRAME");
  CHECK(refused(-1, 0) == "TB-ANALYSIS-FRAME");
}

TEST_CASE("registration: the last complete one stored is used, with its defaults") {
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

TEST_CASE("registration: rotation by 30 degrees, scale 2, offset and mirroring match hand-computed values") {
  // stage = 2 R(30) taxel + (10, 20). Taxel (2, 1): R gives (sqrt 3 - 1/2, 1 + sqrt 3 / 2).
  MountTransform mount{.angle_deg = 30.0, .scale = 2.0, .offset_mm = {10.0, 20.0}};
  const double x = 10.0 + 2.0 * (std::sqrt(3.0) - 0.5), y = 20.0 + 2.0 * (1.0 + std::sqrt(3.0) / 2.0);
  CHECK(mount.taxel_mm(x, y)[0] == Approx(2.0));
  CHECK(mount.taxel_mm(x, y)[1] == Approx(1.0));
  mount.flipped = true;  // the mirror comes first: the same place of the stage is taxel (2, -1)
  CHECK(mount.taxel_mm(x, y)[0] == Approx(2.0));
  CHECK(mount.taxel_mm(x, y)[1] == Approx(-1.0));
  CHECK(mount.taxel_mm(10.0, 20.0)[0] == Approx(0.0).margin(1e-12));
}

// Chamber and sensor kept apart, on arrays of two by two whose every figure can be had on paper.

namespace {

using Maps = std::vector<std::vector<double>>;
using Places = std::vector<std::vector<int>>;

const std::vector<int> kAsItLay{0, 1, 2, 3}, kHalfTurned{3, 2, 1, 0};
// The first and the last taxel change places, and the two between. First pair: the sensor's part 2 and 7 (means of its
// own two readings), the cells' 3 and 6, so -1.5 and +1.5 about their mean; what is left is +-0.5 in all four. Second
// pair: 2.5 and 4.5, the cells alike, +-0.5 left again.
const Maps kTwoRuns{{1, 2, 4, 9}, {3, 3, 5, 5}};

void check_map(const std::vector<double>& found, const std::vector<double>& expected) {
  check_alike(found, expected, 1e-12);
}

// Estimates of one sweep: at each level the level itself and `factor` times the run's row.
SweepEstimates turned_estimates(const std::vector<double>& levels, const std::vector<double>& factors,
                                const std::vector<double>& row) {
  SweepEstimates out{.pressure_psi = levels, .sweeps = 1, .taxels = static_cast<int>(row.size()), .psi = {}};
  for (std::size_t level = 0; level < levels.size(); ++level)
    for (const double own : row) out.psi.push_back(levels[level] + factors[level] * own);
  return out;
}

// Half turn of the two runs: as they are at 10 psi times 0.1, at 20 psi times 0.4, and at the models' end.
std::vector<TurnedRun> half_turn(const std::vector<double>& second_levels = {0, 10, 20, 60}) {
  const std::vector<double> factors{0.0, 0.1, 0.4, 0.0};
  return {{11, 0, turned_estimates({0, 10, 20, 60}, factors, kTwoRuns[0])},
          {12, 180, turned_estimates(second_levels, factors, kTwoRuns[1])}};
}

}  // namespace

TEST_CASE("rotated places: each taxel of square and rectangular arrays has the expected place") {
  CHECK(turned_places(2, 2, 0) == kAsItLay);
  CHECK(turned_places(2, 2, 90) == std::vector<int>{2, 0, 3, 1});
  CHECK(turned_places(2, 2, 180) == kHalfTurned);
  CHECK(turned_places(2, 2, 270) == std::vector<int>{1, 3, 0, 2});
  CHECK(turned_places(3, 3, 90) == std::vector<int>{6, 3, 0, 7, 4, 1, 8, 5, 2});
  CHECK(turned_places(3, 3, 270) == std::vector<int>{2, 5, 8, 1, 4, 7, 0, 3, 6});
  CHECK(turned_places(2, 3, 0) == std::vector<int>{0, 1, 2, 3, 4, 5});
  CHECK(turned_places(3, 2, 180) == std::vector<int>{5, 4, 3, 2, 1, 0});
  for (const int angle : {-90, 1, 360}) CHECK_THROWS_AS(turned_places(2, 2, angle), std::invalid_argument);
  CHECK_THROWS_AS(turned_places(3, 2, 270), std::invalid_argument);
}

TEST_CASE(
    "uniformity maps: of two half-turned runs, with residual and degrees of freedom, match hand-computed values") {
  const TurnedMaps maps = separate_maps(kTwoRuns, Places{kAsItLay, kHalfTurned});
  check_map(maps.sensor, {2, 2.5, 4.5, 7});
  check_map(maps.chamber, {-1.5, 0, 0, 1.5});
  CHECK(maps.undetermined == 2);
  CHECK(maps.degrees == 2.0);           // eight equations, four taxels, four cells, two free constants
  CHECK(maps.residual == Approx(1.0));  // eight times 0.25
}

TEST_CASE("uniformity maps: one missing reading makes its set exact, two leave the chamber unknown there") {
  Maps one = kTwoRuns;
  one[1][3] = kNan;  // 1 = s + c, 9 = s' + c', 3 = s + c' with c' = -c: c = -1, s = 2, s' = 8
  const TurnedMaps three = separate_maps(one, Places{kAsItLay, kHalfTurned});
  check_map(three.sensor, {2, 2.5, 4.5, 8});
  check_map(three.chamber, {-1, 0, 0, 1});
  CHECK(three.undetermined == 2);
  CHECK(three.degrees == 1.0);
  CHECK(three.residual == Approx(1.0));  // the second pair's 4 x 0.25
  one[1][0] = kNan;
  const TurnedMaps apart = separate_maps(one, Places{kAsItLay, kHalfTurned});
  check_map(apart.sensor, {1, 2.5, 4.5, 9});
  check_map(apart.chamber, {kNan, 0, 0, kNan});
  CHECK(apart.undetermined == 3);
  CHECK(apart.degrees == 1.0);
  one[0][3] = kNan;
  const TurnedMaps none = separate_maps(one, Places{kAsItLay, kHalfTurned});
  check_map(none.sensor, {1, 2.5, 4.5, kNan});
  check_map(none.chamber, {kNan, 0, 0, kNan});
  CHECK(none.undetermined == 2);
}

TEST_CASE("uniformity maps: runs at the same angle give no chamber map, and a single run no residual") {
  const TurnedMaps alike = separate_maps(Maps{{1, 3}, {2, 5}}, Places{{0, 1}, {0, 1}});
  check_map(alike.sensor, {1.5, 4});
  check_map(alike.chamber, {kNan, kNan});
  CHECK(alike.undetermined == 2);
  CHECK(alike.degrees == 2.0);
  CHECK(alike.residual == Approx(std::sqrt(2.5 / 2.0)));  // 2 x 0.25 and 2 x 1
  const TurnedMaps single = separate_maps(Maps{{1, 3}}, Places{{0, 1}});
  check_map(single.sensor, {1, 3});
  CHECK(single.degrees == 0.0);
  CHECK(std::isnan(single.residual));
  const TurnedMaps empty = separate_maps({}, {});
  CHECK((empty.sensor.empty() && empty.undetermined == 0 && std::isnan(empty.residual)));
}

TEST_CASE("uniformity: spread, residual, slopes and constant parts of the levels match hand-computed values") {
  const Uniformity u = uniformity_of(half_turn(), 2, 2);
  REQUIRE(u.assessed());
  CHECK(u.runs == std::vector<std::int64_t>{11, 12});
  CHECK(u.angles_deg == std::vector<int>{0, 180});
  CHECK(u.pressure_psi == std::vector<double>{10, 20});
  // The chamber's -1.5, 0, 0, 1.5 has a standard deviation of sqrt(4.5 / 3). The rest's sum of squares is 2; of the two
  // degrees of freedom the second run's own constant takes one.
  const double spread = std::sqrt(1.5), rest = std::sqrt(2.0);
  check_map(u.u_psi, {0.1 * spread, 0.4 * spread});
  check_map(u.residual_psi, {0.1 * rest, 0.4 * rest});
  CHECK(u.residual_rms_psi == Approx(std::sqrt((0.02 + 0.32) / 2)));
  CHECK(u.residual_other_sense_psi == Approx(u.residual_rms_psi));  // a half turn has no sense
  // 0.1 at 10 and 0.4 at 20 psi: 0.03 a psi from -0.2 on.
  check_map(u.chamber_share, {-0.045, 0, 0, 0.045});
  check_map(u.chamber_psi, {0.3, 0, 0, -0.3});
  check_map(u.sensor_share, {-0.06, -0.045, 0.015, 0.09});  // less the mean of 4
  CHECK(u.u_share == Approx(0.03 * spread));
  CHECK(u.u_offset_psi == Approx(0.2 * spread));
  CHECK(u.undetermined == 2);
  CHECK(u.degrees == 2.0);
}

TEST_CASE("uniformity: several sweeps count by their mean, and a run's constant offset enters no map") {
  std::vector<TurnedRun> runs = half_turn();
  for (TurnedRun& run : runs) {  // two sweeps, 0.25 psi to either side, the second run 3 psi higher
    const std::vector<double> one = run.estimates.psi;
    run.estimates.sweeps = 2;
    run.estimates.psi.clear();
    for (std::size_t level = 0; level < 4; ++level)
      for (const double side : {-0.25, 0.25})
        for (std::size_t taxel = 0; taxel < 4; ++taxel)
          run.estimates.psi.push_back(one[level * 4 + taxel] + side + (run.run == 12 ? 3.0 : 0.0));
  }
  const Uniformity u = uniformity_of(runs, 2, 2);
  check_map(u.chamber_share, {-0.045, 0, 0, 0.045});
  check_map(u.sensor_share, {-0.06, -0.045, 0.015, 0.09});
  CHECK(u.residual_psi[0] == Approx(0.1 * std::sqrt(2.0)));
}

TEST_CASE("uniformity: the residual for the opposite sense of rotation is that of the negated angles") {
  const auto quarter = [](int angle) {
    return std::vector<TurnedRun>{{1, 0, turned_estimates({10, 20, 60}, {0.1, 0.4, 0}, {1, 2, 4, 9})},
                                  {2, angle, turned_estimates({10, 20, 60}, {0.1, 0.4, 0}, {3, 8, 5, 5})},
                                  {3, 180, turned_estimates({10, 20, 60}, {0.1, 0.4, 0}, {2, 1, 7, 3})}};
  };
  const Uniformity left = uniformity_of(quarter(90), 2, 2), right = uniformity_of(quarter(270), 2, 2);
  REQUIRE((left.assessed() && right.assessed()));
  CHECK(left.residual_rms_psi != Approx(right.residual_rms_psi));
  CHECK(left.residual_other_sense_psi == Approx(right.residual_rms_psi));
  CHECK(right.residual_other_sense_psi == Approx(left.residual_rms_psi));
}

TEST_CASE("uniformity: levels match within 0.05 psi and count above 0.5 psi, and two are needed") {
  CHECK(uniformity_of(half_turn({0, 10.04, 20, 60}), 2, 2).pressure_psi == std::vector<double>{10, 20});
  const Uniformity other = uniformity_of(half_turn({0, 10.06, 20, 60}), 2, 2);
  CHECK_FALSE(other.assessed());
  CHECK(other.pressure_psi == std::vector<double>{20});
  CHECK(other.u_psi.empty());
  const auto lowest = [](double level) {
    return std::vector<TurnedRun>{{1, 0, turned_estimates({level, 10, 20, 60}, {0, 0.1, 0.4, 0}, kTwoRuns[0])},
                                  {2, 180, turned_estimates({level, 10, 20, 60}, {0, 0.1, 0.4, 0}, kTwoRuns[1])}};
  };
  CHECK(uniformity_of(lowest(0.5), 2, 2).pressure_psi.size() == 2);
  CHECK(uniformity_of(lowest(0.51), 2, 2).pressure_psi.size() == 3);
}

TEST_CASE("uniformity: a level is dropped if over 5 % of a run's taxels are within 0.3 psi of the range's end") {
  // Twenty taxels: one of them is 5 %. 20 psi, and 50 psi where some read `psi`, in the second run alone.
  const auto near_the_end = [](int taxels, double psi) {
    std::vector<double> plain(20);
    for (std::size_t i = 0; i < 20; ++i) plain[i] = i % 3 == 0 ? 1.0 : -1.0;
    std::vector<TurnedRun> runs{{1, 0, turned_estimates({10, 20, 50, 60}, {0.1, 0.1, 0.1, 0}, plain)},
                                {2, 180, turned_estimates({10, 20, 50, 60}, {0.1, 0.1, 0.1, 0}, plain)}};
    for (int taxel = 0; taxel < taxels; ++taxel) runs[1].estimates.psi[static_cast<std::size_t>(40 + taxel)] = psi;
    return uniformity_of(runs, 4, 5).pressure_psi.size();
  };
  CHECK(near_the_end(1, 59.9) == 3);
  CHECK(near_the_end(2, 59.9) == 2);
  CHECK(near_the_end(2, 59.71) == 2);
  CHECK(near_the_end(2, 59.69) == 3);
}

TEST_CASE("uniformity: with one reading missing the run's constant is found, with no degree of freedom left") {
  // sensor 1, 2, -2, -1, chamber 0.5, -0.25, 0.25, -0.5, the second run 3 psi higher and without its last taxel.
  std::vector<double> first{1.5, 1.75, -1.75, -1.5}, second{1 - 0.5 + 3, 2 + 0.25 + 3, -2 - 0.25 + 3, kNan};
  const std::vector<TurnedRun> runs{{1, 0, turned_estimates({10, 20, 60}, {1, 1, 1}, first)},
                                    {2, 180, turned_estimates({10, 20, 60}, {1, 1, 1}, second)}};
  const Uniformity u = uniformity_of(runs, 2, 2);
  REQUIRE(u.assessed());
  // Seven equations, eight unknowns of which two are free, and the constant.
  CHECK(std::isnan(u.residual_psi[0]));
  CHECK(u.u_psi[0] == Approx(std::sqrt((2 * 0.25 + 2 * 0.0625) / 3)).epsilon(1e-3));
}
