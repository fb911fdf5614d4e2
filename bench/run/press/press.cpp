#include "bench/run/press/press.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "bench/common/process_time.h"
#include "bench/config/config.h"
#include "devices/device.h"

namespace tactbench::bench {

using devices::Axis;
using devices::Fault;
using devices::Millimetres;
using devices::MillimetresPerSecond;
using devices::Nanoseconds;
using devices::Wrench;

namespace {

constexpr double kPositionToleranceMm = 0.001;
constexpr double kMarginMm = 0.01;

// a x + b y
Wrench combined(double a, const Wrench& x, double b, const Wrench& y) {
  Wrench sum;
  for (std::size_t i = 0; i < 3; ++i) {
    sum.force_n[i] = a * x.force_n[i] + b * y.force_n[i];
    sum.torque_nmm[i] = a * x.torque_nmm[i] + b * y.torque_nmm[i];
  }
  return sum;
}

}  // namespace

PressOptions press_options(const BenchConfig& config) {
  if (!config.stage) throw std::logic_error("press_options() without [stage]");
  const devices::StageOptions& stage = *config.stage;
  PressOptions options;
  options.clear_z_mm = stage.axis(2).low.value();  // the bench file may set another
  // The device's own limit may lie a microstep short of the nominal travel.
  options.max_z_mm = stage.axis(2).high.value() - kMarginMm;
  options.travel_mm_per_s = stage.axis(2).maximum_speed.value();
  options.travel_xy_mm_per_s = std::min(stage.axis(0).maximum_speed.value(), stage.axis(1).maximum_speed.value());
  return options;
}

Press::Press(devices::Stage& stage, devices::ForceSensor& force, devices::Clock& clock, PressOptions options,
             PressHooks hooks)
    : stage_(stage),
      force_(force),
      clock_(clock),
      options_(options),
      hooks_(std::move(hooks)),
      axis_(stage_, force_, clock_, options_, hooks_),
      servo_(axis_),
      clear_z_mm_(options_.clear_z_mm) {}

void Press::check_clear() {
  const double z_mm = axis_.find();
  if (z_mm <= clear_z_mm_ + kPositionToleranceMm) return;
  throw Fault("TB-PRESS-NOT-CLEAR", "stage z",
              fmt::format("z is at {:.3f} mm, the clear position is {:.3f} mm; nothing was moved", z_mm, clear_z_mm_),
              "Let the recipe retract before it tares or moves in x and y.");
}

TareReading Press::tare() {
  check_clear();
  TareReading tare;
  tare.removed = force_.bias(options_.level_records);
  if (removed_) tare.drift = combined(1.0, tare.removed.wrench, -1.0, removed_->wrench);
  removed_ = tare.removed;
  axis_.event("tare", fmt::format("Fz offset {:.3f} N{}", tare.removed.wrench.force_n[2],
                                  tare.drift ? fmt::format(", drifted {:.3f} N", tare.drift->force_n[2]) : ""));
  return tare;
}

void Press::home() {
  contact_.reset();
  clear_z_mm_ = options_.clear_z_mm;
  for (const Axis axis : {Axis::kZ, Axis::kX, Axis::kY}) stage_.home(axis);
  axis_.event("home", "z, x and y are at their home sensors");
}

void Press::move_xy(double x_mm, double y_mm) {
  check_clear();
  const ForceSample air = axis_.sample(options_.poll_records);
  if (!(std::abs(air.force_n) < options_.safe_force_n)) {
    throw Fault("TB-PRESS-NOT-CLEAR", "force sensor",
                fmt::format("{:.2f} N on the indenter before a move in x and y; nothing was moved", air.force_n),
                "Tare in the air first; check what the indenter touches.");
  }
  const MillimetresPerSecond speed(options_.travel_xy_mm_per_s);
  const double way_mm = std::max(std::abs(stage_.state(Axis::kX).position.value() - x_mm),
                                 std::abs(stage_.state(Axis::kY).position.value() - y_mm));
  try {
    stage_.start_move_to(Axis::kX, Millimetres(x_mm), speed);
    stage_.start_move_to(Axis::kY, Millimetres(y_mm), speed);
    hooks_.wait(clock_.now() + seconds(way_mm / speed.value() + options_.settle_s));
    (void)stage_.wait(Axis::kX);
    (void)stage_.wait(Axis::kY);
  } catch (...) {
    (void)stage_.halt();
    throw;
  }
}

ContactPoint Press::approach() {
  contact_.reset();
  const ContactPoint found = find_contact(axis_, clear_z_mm_);
  contact_ = found;
  clear_z_mm_ = std::max(0.0, std::min(options_.clear_z_mm, found.z_mm - options_.clear_mm));
  servo_.begin(found);
  axis_.event("contact", fmt::format("at z {:.4f} mm +- {:.4f} mm, {:.1f} N/mm; {:.2f} N measured on the way",
                                     found.z_mm, found.uncertainty_mm, found.stiffness_n_per_mm, found.max_force_n));
  return found;
}

// Corrects in the branch's direction when the force has left the inner half of its band; false: broken.
bool Press::correct(const PressLevel& level, ForceSample& last, PressReading& reading) {
  const double half = options_.tolerance(level.force_n) / 2.0;
  const double left = (level.branch == Branch::kLoading ? 1.0 : -1.0) * (level.force_n - last.force_n);
  if (!level.hold_force || left <= half) return true;
  const ServoResult result = servo_.to(level.force_n, level.branch, half);
  last = result.reading;
  reading.moves += result.moves;
  reading.broken = result.broken;
  return !result.broken;
}

bool Press::dwell(const PressLevel& level, PressReading& reading) {
  const Nanoseconds end = reading.in_band_since + seconds(level.dwell_s);
  while (clock_.now() < end) {
    hooks_.wait(std::min(end, clock_.now() + seconds(options_.hold_interval_s)));
    if (clock_.now() >= end) break;
    ForceSample held = axis_.sample(options_.level_records);
    if (!correct(level, held, reading)) return false;
  }
  reading.before = axis_.sample(options_.level_records);
  return correct(level, reading.before, reading);
}

PressReading Press::press(const PressLevel& level, const std::function<void()>& frame) {
  if (!contact_) {
    throw Fault("TB-PRESS-NO-APPROACH", "stage z",
                fmt::format("{:.2f} N was requested before contact was found at this place", level.force_n));
  }
  PressReading reading;
  reading.commanded_at = clock_.now();
  const ServoResult reached = servo_.to(level.force_n, level.branch, options_.tolerance(level.force_n));
  reading.start = reached.reading;
  reading.in_band_since = clock_.now();
  reading.moves = reached.moves;
  reading.broken = reached.broken;
  if (reached.broken || !dwell(level, reading)) {
    axis_.event("branch-broken", fmt::format("{:.2f} N passed by {:.3f} N at z {:.4f} mm", level.force_n,
                                             reading.broken->overshoot_n, axis_.z_mm()));
    return reading;
  }
  if (frame) {
    frame();
    reading.after = axis_.sample(options_.level_records);
  } else {
    reading.after = reading.before;
  }
  reading.wrench = combined(0.5, reading.before.wrench, 0.5, reading.after.wrench);
  reading.spread_n = std::max({reading.before.spread_n, reading.after.spread_n, removed_ ? removed_->spread_n : 0.0});
  reading.force_n = (reading.before.force_n + reading.after.force_n) / 2.0;
  reading.relaxation_n = reading.start.force_n - reading.before.force_n;
  reading.z_mm = axis_.z_mm();
  reading.stiffness_n_per_mm = servo_.stiffness_n_per_mm();
  return reading;
}

RetractProof Press::retract() noexcept {
  contact_.reset();
  const RetractOptions options{clear_z_mm_, options_.travel_mm_per_s, options_.safe_force_n, options_.level_records};
  return bench::retract(stage_, &force_, clock_, options, hooks_.wait);
}

double overshoot_n(double speed_mm_per_s, double force_latency_s, double stop_time_s, double stiffness_n_per_mm) {
  return speed_mm_per_s * (force_latency_s + stop_time_s) * stiffness_n_per_mm;
}

namespace {

bool inside(double value, const std::pair<double, double>& limits) {  // NaN is outside
  return value >= limits.first && value <= limits.second;
}

void check_forces(const PressPlanned& planned, const PressOptions& options, const PressEnvelope& envelope,
                  std::vector<std::string>& complaints) {
  const double over =
      overshoot_n(options.servo_mm_per_s, options.force_latency_s, options.stop_time_s, options.stiffest_n_per_mm);
  const double range_n = envelope.overload_share * envelope.force_range[2];
  for (const double force_n : planned.forces_n) {
    if (!(force_n + options.tolerance(force_n) + over <= range_n)) {
      complaints.push_back(
          fmt::format("{:g} N, with its tolerance and {:.2f} N of overshoot ({:g} mm/s x {:g} s x {:g} N/mm), exceed "
                      "the range of Fz in the loaded calibration, {:g} N",
                      force_n, over, options.servo_mm_per_s, options.force_latency_s + options.stop_time_s,
                      options.stiffest_n_per_mm, range_n));
    }
    if (!(force_n + options.tolerance(force_n) + over <= options.force_limit_n)) {
      complaints.push_back(
          fmt::format("{:g} N, with its tolerance and {:.2f} N of overshoot, are beyond the bench's "
                      "force limit of {:g} N",
                      force_n, over, options.force_limit_n));
    }
    if (!(force_n >= options.contact_n)) {
      complaints.push_back(
          fmt::format("{:g} N are less than the {:g} N that count as contact", force_n, options.contact_n));
    }
  }
  if (!(options.force_limit_n <= range_n)) {
    complaints.push_back(
        fmt::format("the bench's force limit of {:g} N exceeds the {:g} N of the loaded calibration: passing it would "
                    "not be detected",
                    options.force_limit_n, range_n));
  }
  if (planned.forces_n.empty()) return;
  // The approach presses too: between two readings of the force, and then until the stage has stopped.
  const double lowest_n = *std::min_element(planned.forces_n.begin(), planned.forces_n.end());
  const double search_n =
      options.contact_n + overshoot_n(options.approach_mm_per_s, options.poll_interval_s + options.force_latency_s,
                                      options.stop_time_s, options.stiffest_n_per_mm);
  if (!(search_n <= options.force_limit_n)) {
    complaints.push_back(
        fmt::format("the search at {:g} mm/s may press {:.1f} N at {:g} N/mm before it stops, beyond "
                    "the bench's force limit of {:g} N",
                    options.approach_mm_per_s, search_n, options.stiffest_n_per_mm, options.force_limit_n));
  }
  const double step_n = options.resolution_mm * options.stiffest_n_per_mm;
  if (!(step_n <= options.tolerance(lowest_n))) {
    complaints.push_back(
        fmt::format("the smallest move of z changes the force by {:.3f} N at {:g} N/mm, more than the "
                    "tolerance of {:.3f} N at {:g} N",
                    step_n, options.stiffest_n_per_mm, options.tolerance(lowest_n), lowest_n));
  }
}

void check_places(const PressPlanned& planned, const PressOptions& options, const PressEnvelope& envelope,
                  std::vector<std::string>& complaints) {
  const auto check = [&](const std::string& what, double value, std::size_t axis) {
    const auto& limits = envelope.axes_mm.at(axis);
    if (inside(value, limits)) return;
    complaints.push_back(
        fmt::format("{} = {:g} mm is outside the axis' {:g} to {:g} mm", what, value, limits.first, limits.second));
  };
  for (const auto& [x_mm, y_mm] : planned.positions_mm) {
    check("x", x_mm, 0);
    check("y", y_mm, 1);
  }
  for (const auto& [key, speed] :
       {std::pair("approach_mm_per_s", options.approach_mm_per_s), std::pair("servo_mm_per_s", options.servo_mm_per_s)})
    if (!(speed <= options.travel_mm_per_s))
      complaints.push_back(
          fmt::format("{} = {:g} is more than the {:g} mm/s allowed for z", key, speed, options.travel_mm_per_s));
  check("clear z", options.clear_z_mm, 2);
  check("deepest z", options.max_z_mm, 2);
  if (!(options.clear_z_mm < options.max_z_mm)) complaints.emplace_back("clear z is not above the deepest z");
}

}  // namespace

std::vector<std::string> press_complaints(const PressPlanned& planned, const PressOptions& options,
                                          const PressEnvelope& envelope) {
  std::vector<std::string> complaints;
  check_forces(planned, options, envelope, complaints);
  check_places(planned, options, envelope, complaints);
  return complaints;
}

}  // namespace tactbench::bench
