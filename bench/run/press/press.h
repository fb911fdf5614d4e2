// The steps of a run that presses, one method per step: tare, home, move to x, y, approach, press to a level, retract.
// Called by the sequencer; keeps only what the next step needs. Results are structs that the recorder stores.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/run/press/approach.h"
#include "bench/run/press/force_servo.h"
#include "bench/run/press/press_axis.h"
#include "bench/safety/retract.h"

namespace tactbench::bench {

struct BenchConfig;

// Limits and speeds from the bench's [stage]; all others have their defaults. Throws std::logic_error without a
// [stage].
[[nodiscard]] PressOptions press_options(const BenchConfig& config);

struct TareReading {
  devices::ForceReading removed;         // the sensor's offset without contact
  std::optional<devices::Wrench> drift;  // change of the offset since the previous tare
};

struct PressLevel {
  double force_n = 0.0;
  Branch branch = Branch::kLoading;
  double dwell_s = 0.0;
  bool hold_force =
      false;  // keeps correcting the force during the dwell, only in the branch's direction; else z does not move
};

struct PressReading {
  devices::Nanoseconds commanded_at{0}, in_band_since{0};
  ForceSample start;          // when the level was reached
  ForceSample before, after;  // right before and right after the frame
  devices::Wrench wrench;     // their mean
  double force_n = 0.0;       // pressing force of the frame: mean of before and after
  double z_mm = 0.0;          // at frame time
  double spread_n = 0.0;      // largest spread of the samples before and after, and of the tare
  double relaxation_n = 0.0;  // force at the start minus force at the end of the dwell, z at rest
  double stiffness_n_per_mm = 0.0;
  int moves = 0;
  std::optional<BranchBroken> broken;  // then there is no frame, and the members after `start` are empty
};

class Press {
 public:
  // `hooks.wait` is required and serves all waits except the few milliseconds in which a move comes to rest, homing,
  // and moves of x and y. All arguments must outlive this.
  Press(devices::Stage& stage, devices::ForceSensor& force, devices::Clock& clock, PressOptions options,
        PressHooks hooks);
  Press(const Press&) = delete;
  Press& operator=(const Press&) = delete;

  // To be called without contact. Throws TB-PRESS-NOT-HOMED, TB-PRESS-NOT-CLEAR if z is beyond the clear position.
  TareReading tare();
  void home();  // z first, which leaves the specimen; blocks as Stage::home does
  // Throws TB-PRESS-NOT-CLEAR if z is beyond the clear position or a force is measured, and the stage's faults.
  void move_xy(double x_mm, double y_mm);
  ContactPoint approach();
  // Throws TB-PRESS-NO-APPROACH before an approach at this place. `frame` reads the array; null: no frame is read.
  PressReading press(const PressLevel& level, const std::function<void()>& frame);
  [[nodiscard]] RetractProof retract() noexcept;

  [[nodiscard]] const std::optional<ContactPoint>& contact() const { return contact_; }  // none: not in contact
  [[nodiscard]] double clear_z_mm() const { return clear_z_mm_; }
  [[nodiscard]] const PressOptions& options() const { return options_; }

 private:
  void check_clear();
  bool dwell(const PressLevel& level, PressReading& reading);
  bool correct(const PressLevel& level, ForceSample& last, PressReading& reading);
  devices::Stage& stage_;
  devices::ForceSensor& force_;
  devices::Clock& clock_;
  PressOptions options_;
  PressHooks hooks_;
  PressAxis axis_;
  ForceServo servo_;
  double clear_z_mm_;
  std::optional<ContactPoint> contact_;
  std::optional<devices::ForceReading> removed_;
};

// Checks before any motion whether a press plan fits force sensor, bench and axes, including the overshoot.
// Rise of the force from passing a threshold until the stage has stopped: speed x (force latency + stop time) x
// stiffness.
[[nodiscard]] double overshoot_n(double speed_mm_per_s, double force_latency_s, double stop_time_s,
                                 double stiffness_n_per_mm);

struct PressPlanned {
  std::vector<std::pair<double, double>> positions_mm;  // x, y
  std::vector<double> forces_n;
};

struct PressEnvelope {
  std::array<double, 6> force_range{};                 // ForceSensor::range()
  double overload_share = 1.0;                         // share of the range at which the sensor's driver throws a fault
  std::array<std::pair<double, double>, 3> axes_mm{};  // low and high of x, y, z, inclusive
};

// Checks `planned` with `options`: one sentence per problem, empty if there is none. NaN is a problem.
[[nodiscard]] std::vector<std::string> press_complaints(const PressPlanned& planned, const PressOptions& options,
                                                        const PressEnvelope& envelope);

}  // namespace tactbench::bench
