// Every actuator command passes this check: constant limits, rate of rise, recent readings of the witnesses (the
// pressure instruments), limits that apply to several axes together, latched trips, the dead-man. guard_devices.h wraps
// the drivers so that no command bypasses it. One thread, the sequencer's.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>

#include "bench/config/config.h"
#include "bench/guard/dead_man.h"
#include "bench/guard/trip.h"
#include "bench/guard/witness.h"
#include "devices/clock.h"
#include "devices/force/force_sensor.h"
#include "devices/pressure/pressure_source.h"
#include "devices/stage/stage.h"

namespace tactbench::bench {

struct AxisLimits {
  double low_mm = 0.0, high_mm = 0.0, speed_mm_per_s = 0.0;  // inclusive
};

struct GuardLimits {
  SafetyLimits safety;
  std::array<AxisLimits, devices::kAxes> axes;
  bool has_force = false;  // then z presses only under a fresh force reading
  TrueRange feedback, reference;
};

// The limits of a bench file. A simulation at another rate than 1 multiplies stale_s by the rate, because readings age
// faster.
GuardLimits guard_limits(const BenchConfig& config);

// Time, actuator ("pressure", "stage z", "guard"), command, and whether it passed. Called for each refusal and stage
// command; for set-points when they differ by 1 psi from the last one logged, or return to 0.
using CommandLog =
    std::function<void(devices::Nanoseconds, const std::string& actuator, const std::string& text, bool let_through)>;

class Guard {
 public:
  Guard(const GuardLimits& limits, const devices::Clock& clock)
      : limits_(limits), clock_(clock), feedback_(limits.feedback), reference_(limits.reference) {}
  Guard(const Guard&) = delete;
  Guard& operator=(const Guard&) = delete;

  void set_log(CommandLog log) { log_ = std::move(log); }
  void set_run(std::int64_t run) { run_ = run; }  // named in trips
  // Called with each new trip, to store it.
  void set_trip_sink(std::function<void(const Trip&)> sink) { sink_ = std::move(sink); }
  // The drivers that a trip vents and halts. Null: there is none.
  void set_actuators(devices::PressureSource* source, devices::Stage* stage);
  void set_watcher(Watcher* watcher) { watcher_ = watcher; }  // may be null

  // From now on commands pass and readings trip; before, each command throws Fault TB-GUARD-NOT-ARMED.
  void arm() { armed_ = true; }
  [[nodiscard]] bool armed() const { return armed_; }
  void feed();  // progress, for the dead-man; the rig's clock does it in each wait

  // Vents and halts at once, latches and stores. A first trip stays. Never throws.
  void trip(const std::string& id, const std::string& what) noexcept;
  [[nodiscard]] const std::optional<Trip>& tripped() const { return trip_; }
  // After a trip: whether the stage confirmed that it is at rest.
  [[nodiscard]] const char* halt_text() const {
    return halted_ ? "; stage halted" : "; the stage did NOT confirm that it stands";
  }
  // A person has inspected the rig. A dead-man that has fired stays fired.
  void reset(const std::string& who);

  // To be called with each reading. When armed, a reading beyond its limit trips and throws Fault TB-CHAMBER-TRIP or
  // TB-FORCE-TRIP; after a trip readings are only kept.
  void note_feedback(devices::Psi pressure, devices::Nanoseconds time);
  void note_reference(devices::Psi pressure, devices::Nanoseconds time);
  [[nodiscard]] const PressureWitness& feedback() const { return feedback_; }
  [[nodiscard]] const PressureWitness& reference() const { return reference_; }
  // Throws Fault TB-CHAMBER-WITNESS if the readings of an instrument have been impossible for longer than
  // disagreement_s.
  void check_witnesses() const;
  void note_force(const devices::Wrench& wrench, devices::Nanoseconds time);
  // Magnitude of the last force noted; none: no force was noted.
  [[nodiscard]] std::optional<double> last_force_n() const {
    return force_time_.count() < 0 ? std::nullopt : std::optional(force_n_);
  }

  // Checks of commands. Each logs the command, and throws Fault if it is refused. Ids:
  // TB-GUARD-NOT-ARMED, TB-GUARD-TRIPPED, TB-DEADMAN-..., TB-CHAMBER-LIMIT, TB-CHAMBER-RATE, TB-CHAMBER-STALE,
  // TB-CHAMBER-WITNESS, TB-STAGE-LIMIT, TB-STAGE-ENVELOPE, TB-FORCE-STALE.
  void check_pressure(devices::Psi pressure);
  void check_rewriting();  // of the present set-point
  // z toward its home is allowed even after a trip: away from the specimen is the safe direction. x and y move only
  // while z is homed, at rest and not beyond clear_z_mm, and the last force reading showed no contact. `read` is called
  // only when it matters.
  using ReadAxis = std::function<devices::AxisState(devices::Axis)>;
  void check_move(devices::Axis axis, double target_mm, double speed_mm_per_s, const ReadAxis& read);
  void check_home(devices::Axis axis, const ReadAxis& read);

  // Results of commands.
  void set_pressure(devices::Psi pressure);  // the new set-point
  void source_armed();                       // outputs are 0
  void vented(bool read_back);
  void set_moving(devices::Axis axis, bool moving) { moving_[static_cast<std::size_t>(axis)] = moving; }
  [[nodiscard]] const AxisLimits& axis_limits(devices::Axis axis) const {
    return limits_.axes[static_cast<std::size_t>(axis)];
  }
  void stage_armed();
  [[nodiscard]] double setpoint_psi() const { return setpoint_psi_; }
  // For a halt: whether this process may use the stage's line, after waiting for the dead-man to release it.
  [[nodiscard]] bool may_use_stage_line();

 private:
  [[noreturn]] void refuse(const char* id, const char* actuator, const std::string& asked, const std::string& why,
                           const std::string& remedy) const;
  void check_open(const char* actuator, const std::string& asked, bool away);
  void check_watcher();
  void check_fresh(const char* id, const char* actuator, const std::string& asked, const char* name,
                   devices::Nanoseconds taken) const;
  void log(const std::string& actuator, const std::string& text, bool let_through) const;
  void judge_pressure(const char* name, double psi);
  void check_clear(devices::Axis axis, const std::string& asked, const devices::AxisState& z) const;

  GuardLimits limits_;
  const devices::Clock& clock_;
  CommandLog log_;
  std::function<void(const Trip&)> sink_;
  devices::PressureSource* source_ = nullptr;
  devices::Stage* stage_ = nullptr;
  Watcher* watcher_ = nullptr;
  std::int64_t run_ = 0;
  bool armed_ = false;
  bool stage_used_ = false;  // a stage that was never armed is not halted: it may not be connected
  std::optional<Trip> trip_;
  bool vented_ = false, halted_ = false;  // by the trip, as module and stage confirmed
  std::optional<WatcherLost> lost_;       // the cause of trip_, if a lost dead-man caused it
  PressureWitness feedback_, reference_;
  double force_n_ = 0.0;  // magnitude of the last one noted
  devices::Nanoseconds force_time_{-1};
  double setpoint_psi_ = 0.0;
  double logged_psi_ = 0.0;
  double budget_psi_ = 0.0;  // by how much the set-point may rise now
  devices::Nanoseconds budget_time_{0};
  std::array<bool, devices::kAxes> moving_{};
};

}  // namespace tactbench::bench
