// The bench's actuators and witnesses behind the guard: every command is checked before it reaches the driver, every
// reading is passed to the guard.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "bench/guard/guard.h"

namespace tactbench::bench {

class GuardedSource final : public devices::PressureSource {
 public:
  // `before_arming` may throw: a bench that tripped earlier, a dead-man that does not start.
  GuardedSource(std::unique_ptr<devices::PressureSource> source, Guard& guard, std::function<void()> before_arming)
      : source_(std::move(source)), guard_(guard), before_arming_(std::move(before_arming)) {}
  void arm() override;
  void disarm() noexcept override { source_->disarm(); }
  [[nodiscard]] bool armed() const override { return source_->armed(); }
  // Throws the faults of the driver and of Guard::check_pressure().
  std::uint16_t command(devices::Psi pressure) override;
  void keep_alive() override;
  [[nodiscard]] devices::PressureReading feedback() override;
  [[nodiscard]] devices::Nanoseconds last_fed() const override { return source_->last_fed(); }
  [[nodiscard]] bool vent() noexcept override;
  [[nodiscard]] devices::Identity identity() const override { return source_->identity(); }
  [[nodiscard]] std::uint64_t exchanges() const override { return source_->exchanges(); }
  [[nodiscard]] devices::PressureSource& inner() { return *source_; }

 private:
  std::unique_ptr<devices::PressureSource> source_;
  Guard& guard_;
  std::function<void()> before_arming_;
};

class GuardedReference final : public devices::PressureReference {
 public:
  GuardedReference(std::unique_ptr<devices::PressureReference> reference, Guard& guard)
      : reference_(std::move(reference)), guard_(guard) {}
  [[nodiscard]] devices::PressureReading read() override;
  [[nodiscard]] devices::Identity identity() const override { return reference_->identity(); }

 private:
  std::unique_ptr<devices::PressureReference> reference_;
  Guard& guard_;
};

class GuardedStage final : public devices::Stage {
 public:
  GuardedStage(devices::Stage& stage, Guard& guard, std::function<void()> before_arming)
      : stage_(stage), guard_(guard), before_arming_(std::move(before_arming)) {}
  void arm() override;
  void disarm() noexcept override { stage_.disarm(); }
  [[nodiscard]] bool armed() const override { return stage_.armed(); }
  // z must be homed before x and y. Throws the faults of the driver and of Guard::check_move(). A move of x or y costs
  // one query of z, start_move_by() one of the axis.
  void home(devices::Axis axis) override;
  void start_move_to(devices::Axis axis, devices::Millimetres position,
                     std::optional<devices::MillimetresPerSecond> speed) override;
  void start_move_by(devices::Axis axis, devices::Millimetres distance,
                     std::optional<devices::MillimetresPerSecond> speed) override;
  void start_speed(devices::Axis axis, devices::MillimetresPerSecond speed) override;
  devices::Millimetres wait(devices::Axis axis) override;
  devices::Millimetres stop(devices::Axis axis) override;
  [[nodiscard]] devices::AxisState state(devices::Axis axis) override { return stage_.state(axis); }
  // Waits, at most 15 s real time, until a dead-man that uses the line has ended: its retraction must not be stopped.
  [[nodiscard]] bool halt() noexcept override;
  bool send_home(devices::Axis axis) noexcept override { return guard_.may_use_stage_line() && stage_.send_home(axis); }
  [[nodiscard]] std::vector<devices::AxisIdentity> identify() override { return stage_.identify(); }
  [[nodiscard]] std::vector<devices::Identity> identities() const override { return stage_.identities(); }
  [[nodiscard]] std::uint64_t exchanges() const override { return stage_.exchanges(); }

 private:
  void check(devices::Axis axis, double target_mm, std::optional<devices::MillimetresPerSecond> speed);
  devices::Stage& stage_;
  Guard& guard_;
  std::function<void()> before_arming_;
};

class GuardedForce final : public devices::ForceSensor {
 public:
  GuardedForce(std::unique_ptr<devices::ForceSensor> sensor, Guard& guard)
      : sensor_(std::move(sensor)), guard_(guard) {}
  // Readings are passed to the guard from the first bias() on: before it, the offset may be a large part of the range.
  // An overload or a saturated converter trips the guard with TB-FORCE-TRIP; the sensor's own fault is thrown.
  [[nodiscard]] devices::ForceReading read(int records) override;
  devices::ForceReading bias(int records) override;
  [[nodiscard]] std::array<double, 6> range() const override { return sensor_->range(); }
  [[nodiscard]] std::string calibration_serial() const override { return sensor_->calibration_serial(); }
  [[nodiscard]] std::uint64_t exchanges() const override { return sensor_->exchanges(); }
  [[nodiscard]] devices::Identity identity() const override { return sensor_->identity(); }

 private:
  std::unique_ptr<devices::ForceSensor> sensor_;
  Guard& guard_;
  bool tared_ = false;
};

// The rig's clock as drivers and sequencer see it: waits are cut into slices, each of which feeds the dead-man.
class FeedingClock final : public devices::Clock {
 public:
  FeedingClock(devices::Clock& clock, devices::Nanoseconds slice, std::function<void()> feed)
      : clock_(clock), slice_(slice), feed_(std::move(feed)) {}
  [[nodiscard]] devices::Nanoseconds now() const override { return clock_.now(); }
  void wait_until(devices::Nanoseconds time) override;
  void reply_lost(devices::Nanoseconds nominal) override { clock_.reply_lost(nominal); }

 private:
  devices::Clock& clock_;
  devices::Nanoseconds slice_;
  std::function<void()> feed_;
};

}  // namespace tactbench::bench
