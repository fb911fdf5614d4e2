// The z axis monitored by the force sensor: each move toward the specimen is watched, and any fault during a move halts
// the stage before it is thrown. A layer below approach.h, force_servo.h and press.h; stores nothing.
#pragma once

#include <array>
#include <functional>
#include <string>

#include "devices/clock.h"
#include "devices/force/force_sensor.h"
#include "devices/stage/stage.h"

namespace tactbench::bench {

// z increases toward the specimen. Values that a bench file cannot set are not verified on hardware.
struct PressOptions {
  double clear_z_mm = 0.0;  // no contact up to here; x and y move only here
  double clear_mm = 5.0;    // and at least this distance from a known contact
  double max_z_mm = 50.0;
  double max_press_mm = 5.0;     // beyond the contact
  double pressing_sign = -1.0;   // sign of Fz when the specimen is pressed
  double force_limit_n = 33.0;   // a greater |Fz| halts the stage
  double safe_force_n = 0.5;     // below it there is no contact
  double contact_n = 0.2;        // |Fz| that counts as contact
  double travel_mm_per_s = 4.0;  // z, off contact
  double travel_xy_mm_per_s = 4.0;
  double approach_mm_per_s = 0.5;
  double servo_mm_per_s = 0.05;
  double poll_interval_s = 0.04;  // between two readings of the force while searching
  double settle_s = 0.05;         // from the end of a move to the reading: end ramp and the sensor's filter
  double force_latency_s = 0.02;  // from load to reading
  double stop_time_s = 0.02;      // from stop command to standstill
  double backoff_mm = 0.1;        // after the first touch; more than the play
  double fine_step_mm = 0.01;
  double tolerance_n = 0.05, tolerance_share = 0.01;         // of a level: the larger applies
  double softest_n_per_mm = 0.5, stiffest_n_per_mm = 100.0;  // range of the stiffness of specimen and support together
  double play_mm = 0.02;  // largest backlash of the axis: after a reversal the force may not change for this distance
  double turn_drop_share = 0.1;  // share of the force that friction in cloth may release at a reversal without travel
  double answer_n = 0.02;        // a smaller change of force gives no stiffness
  double resolution_mm = 4.7625e-5;  // one microstep of the T-NA08A50: no smaller move exists
  double hold_interval_s = 1.0;      // between two readings of the force while dwelling
  double level_timeout_s = 120.0;
  int max_moves = 60;  // per level
  int poll_records = 10, level_records = 50;

  [[nodiscard]] double tolerance(double force_n) const;
  // Speed limit of z without contact: even the stiffest object in the path is detected, and z stopped, within the force
  // limit.
  [[nodiscard]] double travel_limit_mm_per_s() const;
};

struct ForceSample {
  devices::Nanoseconds time{0};
  double z_mm = 0.0;  // last position of z
  bool moving = false;
  devices::Wrench wrench;
  double force_n = 0.0;         // Fz, positive when it presses
  std::array<double, 6> raw{};  // ForceReading::raw
  double spread_n = 0.0;        // ForceReading::spread_n
};

struct PressHooks {
  std::function<void(devices::Nanoseconds)>
      wait;  // waits until that process time and feeds watchdogs; may throw to stop
  std::function<void(const std::string& id, const std::string& text)> event;  // may be empty
  std::function<void(const ForceSample&)> sample;                             // every reading; may be empty
};

class PressAxis {
 public:
  PressAxis(devices::Stage& stage, devices::ForceSensor& force, devices::Clock& clock, const PressOptions& options,
            const PressHooks& hooks)
      : stage_(stage), force_(force), clock_(clock), options_(options), hooks_(hooks) {}

  // Reads the position of z from the stage. Throws TB-PRESS-NOT-HOMED and the stage's faults.
  double find();
  [[nodiscard]] double z_mm() const { return z_mm_; }
  // Blocks until z has arrived and the reading has settled; returns the reading. Toward the specimen the force is read
  // often enough that even at the greatest stiffness it cannot pass the limit between two readings. Throws
  // TB-PRESS-FORCE-LIMIT, and the faults of stage and sensor, after halting the stage.
  ForceSample move_to(double z_mm, double speed_mm_per_s);
  // Moves down, at most to `z_mm`, until two successive readings show contact; true: contact, and z is at rest.
  bool descend(double z_mm, double speed_mm_per_s);
  ForceSample sample(int records);
  void event(const std::string& id, const std::string& text) const;
  [[nodiscard]] devices::Clock& clock() { return clock_; }
  [[nodiscard]] const PressOptions& options() const { return options_; }

 private:
  template <class Act>
  auto guarded(Act act);
  ForceSample read(int records, bool moving);
  bool felt();
  std::string stopped();  // stops z and returns a text with its position
  devices::Stage& stage_;
  devices::ForceSensor& force_;
  devices::Clock& clock_;
  const PressOptions& options_;
  const PressHooks& hooks_;
  double z_mm_ = 0.0;
  double last_n_ = 0.0;
};

}  // namespace tactbench::bench
