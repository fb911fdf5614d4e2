// One simulated T-Series device: its settings, its motion in process time and its replies, without a wire
// (simulated_chain.h adds it). Rules and errors follow the manual of firmware 5; not compared with hardware.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "devices/clock.h"
#include "devices/stage/motion_profile.h"
#include "devices/stage/zaber_binary.h"
#include "devices/units.h"

namespace tactbench::devices {

struct ChainDeviceOptions {
  std::int32_t device_id = 60;
  std::int32_t firmware = 523;
  std::uint8_t number = 1;
  std::int32_t supply_decivolts = 150;
  Millimetres stands_at{5.0};  // position at power-up, from the home sensor
  std::int32_t target_speed = 2922;
  std::int32_t home_speed = 2922;
  std::int32_t acceleration = 111;
  std::int32_t mode = 0;
  bool refuses_stop_while_homing = false;  // a real unit's behaviour is not known
};

class ChainDevice {
 public:
  explicit ChainDevice(const ChainDeviceOptions& options);
  // Whether a frame to `device` addresses this device: its number, its alias, or 0.
  [[nodiscard]] bool hears(std::uint8_t device) const;
  // Executes one instruction at `now`, which never decreases; answers go to `replies`. `place` counts from 1 at the
  // computer's end of the cable.
  void receive(const ZaberFrame& frame, Nanoseconds now, std::uint8_t place, std::vector<ZaberFrame>& replies);
  // Unsolicited replies up to `now`: the end of a move, tracking, a limit.
  void run(Nanoseconds now, std::vector<ZaberFrame>& replies);
  // Simulates a loss of power: the axis stays where it is, and the counter restarts from 0 there.
  void reset(Nanoseconds now);
  // Time at which run() has its next reply to send.
  [[nodiscard]] std::optional<Nanoseconds> due() const;
  // In message-id mode data has 24 bits and replies carry the id.
  [[nodiscard]] bool message_ids() const { return (setting(ZaberCommand::kMode) & kZaberMessageIds) != 0; }
  // Distance from the home sensor, now or at an earlier time, back to the last 256 changes of motion.
  [[nodiscard]] Millimetres position(Nanoseconds time) const;
  [[nodiscard]] bool at_rest_since(Nanoseconds time) const;
  // From `now` on the axis sticks while the device, which has no encoder, counts its motor as turning: moves appear to
  // end normally, homing does not end. free() releases the axis from the position where it stuck.
  void stick(Nanoseconds now);
  void free(Nanoseconds now);
  [[nodiscard]] std::uint8_t number() const { return number_; }

 private:
  struct Motion {
    MotionProfile profile;  // of the motor, microsteps
    Nanoseconds began{0};
    double mm_per_step = 0.0;
    double slipped = 0.0;         // steps that the axis did not follow
    std::optional<double> stuck;  // where it stuck, from the home sensor
    [[nodiscard]] double true_steps(Nanoseconds time) const;
  };
  using Reply = std::optional<std::int32_t>;  // the data of the reply; none: no reply now
  void power_up();
  void remember(Nanoseconds now);  // stores the motion up to now, before it changes
  void go_home(const ZaberFrame& frame, double pace, Nanoseconds now);
  [[nodiscard]] double acceleration() const;
  [[nodiscard]] std::int32_t setting(ZaberCommand command) const { return settings_.at(command); }
  [[nodiscard]] std::int32_t error_of_setting(ZaberCommand command, std::int32_t data, Nanoseconds now) const;
  void change_setting(ZaberCommand command, std::int32_t data, Nanoseconds now);
  [[nodiscard]] std::int32_t error_of_move(const ZaberFrame& frame, Nanoseconds now) const;
  void move(const ZaberFrame& frame, Nanoseconds now);
  void begin(const ZaberFrame& frame, MotionProfile profile, Nanoseconds now);
  [[nodiscard]] std::int32_t memory(std::int32_t data);
  [[nodiscard]] std::int32_t counter(Nanoseconds now) const;  // the position that the device counts
  [[nodiscard]] double believed(Nanoseconds now) const;       // microsteps commanded to the motor
  [[nodiscard]] double velocity(Nanoseconds now) const;
  void say(ZaberCommand command, std::int32_t data, std::uint8_t id, std::vector<ZaberFrame>& replies) const;

  ChainDeviceOptions options_;
  double full_step_mm_;
  std::uint8_t number_;
  std::map<ZaberCommand, std::int32_t> settings_;
  std::array<std::int32_t, 16> stored_{};
  std::array<std::int32_t, 128> memory_{};
  Motion motion_;
  std::deque<std::pair<Nanoseconds, Motion>> past_;  // each motion with the time of its end
  Nanoseconds next_tracking_{0};
  double zero_ = 0.0;                    // counter = believed - zero
  std::optional<ZaberFrame> under_way_;  // the instruction that caused the motion
};

}  // namespace tactbench::devices
