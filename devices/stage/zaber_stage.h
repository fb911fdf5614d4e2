// Driver of three Zaber T-Series actuators on one daisy chain (firmware 5, binary protocol, message ids on). Not
// verified on hardware; in particular a real unit's reply to a stop while homing is not known.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "devices/clock.h"
#include "devices/stage/options.h"
#include "devices/stage/stage.h"
#include "devices/stage/zaber_line.h"

namespace tactbench::devices {

class ZaberStage final : public Stage {
 public:
  using Factory = std::function<std::unique_ptr<ByteStream>()>;
  // The factory reopens the line at each arm(). Call all functions except halt(), armed() and exchanges() only from
  // the sequencer's thread.
  ZaberStage(Factory open, ZaberStageOptions options, Clock& clock);
  // Identifies the devices, sets the mode (writes only what differs), reads home status, positions and settings. Moves
  // nothing. Faults: TB-SERIAL-*, TB-STAGE-TIMEOUT, TB-STAGE-WRONG-DEVICE, TB-STAGE-REFUSED.
  void arm() override;
  void disarm() noexcept override;
  [[nodiscard]] bool armed() const override { return armed_; }
  void home(Axis axis) override;
  void start_move_to(Axis axis, Millimetres position, std::optional<MillimetresPerSecond> speed) override;
  // Refused while the axis moves (TB-STAGE-MOVING), because the starting position is not known.
  void start_move_by(Axis axis, Millimetres distance, std::optional<MillimetresPerSecond> speed) override;
  // Ends at the axis' limit, even if the device's own limit is further out.
  void start_speed(Axis axis, MillimetresPerSecond speed) override;
  // Faults besides those of the wire: TB-STAGE-OVERDUE (a stop was sent), TB-STAGE-ASTRAY if it stops elsewhere.
  Millimetres wait(Axis axis) override;
  Millimetres stop(Axis axis) override;
  [[nodiscard]] AxisState state(Axis axis) override;
  // Also disarms: commands are refused (TB-STAGE-HALTED) until arm(). Opens the line if none is open. Longest duration:
  // the exchange in progress, then twice: opening the line, the halt timeout and two reply timeouts per axis. Under a
  // manual clock only the thread that armed can see axes come to rest; in another one the answer is false while they
  // slow down.
  [[nodiscard]] bool halt() noexcept override;
  bool send_home(Axis axis) noexcept override;
  [[nodiscard]] std::vector<Identity> identities() const override;
  [[nodiscard]] std::uint64_t exchanges() const override { return exchanges_; }
  [[nodiscard]] std::vector<AxisIdentity> identify() override;

 private:
  struct Motion {
    ZaberCommand command = ZaberCommand::kStop;
    std::uint8_t id = 0;
    Nanoseconds expected{0};
    Nanoseconds deadline{0};
    std::optional<std::int32_t> target;  // microsteps
    std::optional<ZaberFrame> reply;
  };
  struct Record {
    std::int32_t device_id = 0;
    std::int32_t firmware = 0;
    ZaberUnits units;
    std::int32_t maximum_position = 0;
    std::int32_t acceleration = 0;
    std::int32_t target_speed = 0;
    std::int32_t microsteps = 0;
    bool homed = false;
    std::optional<std::int32_t> complaint;  // an error that the device sent unsolicited
    std::optional<Motion> motion;
  };

  template <class Action>
  auto exclusively(Action action);
  [[nodiscard]] const ZaberAxisOptions& option(Axis axis) const { return options_.axes.at(index(axis)); }
  [[nodiscard]] Record& record(Axis axis) { return records_.at(index(axis)); }
  static std::size_t index(Axis axis) { return static_cast<std::size_t>(axis); }
  [[nodiscard]] std::string title(Axis axis) const;
  [[noreturn]] void refuse(Axis axis, ZaberCommand command, std::int32_t error) const;
  [[noreturn]] void refuse_target(Axis axis, const std::string& asked) const;
  void check_halt() const;
  void check_armed() const;

  void open();
  void drop() noexcept;
  void listen(const ZaberFrame& frame);
  std::int32_t ask(Axis axis, ZaberCommand command, std::int32_t data = 0);
  std::int32_t ask_without_id(Axis axis, ZaberCommand command, std::int32_t data = 0);
  std::int32_t asked(Axis axis, ZaberCommand command, std::int32_t data, bool plainly);
  std::int32_t setting(Axis axis, ZaberCommand command);
  void renumber();
  void arm(Axis axis);
  AxisIdentity identify(Axis axis);

  [[nodiscard]] std::int32_t target(Axis axis, Millimetres position);
  [[nodiscard]] std::int32_t speed_data(Axis axis, MillimetresPerSecond speed);
  void check_homed(Axis axis, bool ask_device);
  void start(Axis axis, ZaberCommand command, std::int32_t data, std::int32_t speed, std::int32_t target);
  void begin(Axis axis, ZaberCommand command, std::int32_t data, Nanoseconds expected, Nanoseconds longest);
  void end_motion(Axis axis);
  bool follow(Axis axis);
  bool stop_all();
  void pause(Nanoseconds span);

  Factory open_;
  ZaberStageOptions options_;
  Clock& clock_;
  std::array<Record, kAxes> records_;
  std::unique_ptr<ZaberLine> line_;
  std::mutex mutex_;  // the line and the records; held for one or a few exchanges, never for a move
  std::atomic<bool> armed_{false};
  std::atomic<bool> halted_{false};
  std::atomic<int> halting_{0};
  std::atomic<std::uint64_t> exchanges_{0};
  std::thread::id clock_thread_;  // the thread that armed; it may advance the clock
};

}  // namespace tactbench::devices
