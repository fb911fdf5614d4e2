// A stage of linear axes x, y, z. Positions in mm from the home sensor; z grows toward the specimen.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "devices/clock.h"
#include "devices/device.h"
#include "devices/stage/options.h"
#include "devices/units.h"

namespace tactbench::devices {

enum class Activity { kIdle, kHoming, kMoving, kStopping, kByHand };

struct AxisState {
  Millimetres position;
  std::int32_t microsteps = 0;  // raw, next to the scaled value
  Activity activity = Activity::kIdle;
  bool homed = false;
  Nanoseconds time{0};
};

struct AxisIdentity {  // what an axis answers without being armed
  Axis axis = Axis::kX;
  bool present = false;      // answered
  std::string id, firmware;  // the maker's number of the model, "5082"; "5.23"
  Volts supply;              // scale not verified on hardware
  Activity activity = Activity::kIdle;
  std::int32_t microsteps = 0;
  std::optional<Millimetres> position;  // of a known model, at its default resolution
  std::string complaint, remedy;        // empty: as expected
};

struct StageRetreat {       // what the dead-man did with a stage
  bool stands = false;      // every axis reported that it is at rest
  bool backed_off = false;  // z moved away from the specimen by the commanded distance, or is at its home
  std::string text;         // "stage stands; z from 31.50 to 26.50 mm"
};

class Stage : public Actuator {
 public:
  // Blocks until the axis is at its home sensor, at most for the home timeout.
  virtual void home(Axis axis) = 0;
  // Starts a move and returns; wait() blocks until its end. Refused before anything is sent: a target outside the axis'
  // limits or not-a-number (Fault TB-STAGE-LIMIT), an absolute move of an axis that is not homed (TB-STAGE-NOT-HOMED).
  virtual void start_move_to(Axis axis, Millimetres position, std::optional<MillimetresPerSecond> speed) = 0;
  virtual void start_move_by(Axis axis, Millimetres distance, std::optional<MillimetresPerSecond> speed) = 0;
  // Moves at constant speed until stop() or a limit. Refused on an axis that is not homed.
  virtual void start_speed(Axis axis, MillimetresPerSecond speed) = 0;
  // Blocks until the axis is at rest; returns its position. Bounded by the longest time that the move may take.
  virtual Millimetres wait(Axis axis) = 0;
  virtual Millimetres stop(Axis axis) = 0;  // decelerates, blocks until it is at rest
  [[nodiscard]] virtual AxisState state(Axis axis) = 0;
  // Stops every axis; bounded in time, callable twice and in any state, from any thread, armed or not. True: every axis
  // reported that it is at rest. A thread that waits for a move gets a fault, and so does every command until arm(), so
  // that no command already on its way can start an axis again.
  [[nodiscard]] virtual bool halt() noexcept = 0;
  // Last resort for a stage whose replies are lost: commands the axis home and waits one reply timeout, so that the
  // command arrives. Disarms. True: sent.
  virtual bool send_home(Axis axis) noexcept = 0;
  // Only reads: changes nothing on the devices; works armed or not. From then on identities() has the firmware of each
  // axis that answered. Throws only the wire's faults.
  [[nodiscard]] virtual std::vector<AxisIdentity> identify() = 0;
  [[nodiscard]] virtual std::vector<Identity> identities() const = 0;  // one per axis
  [[nodiscard]] virtual std::uint64_t exchanges() const = 0;
};

struct StageStall {  // of a simulated stage: the last time that axes stuck
  std::optional<Nanoseconds> from, until;
  std::optional<Axis> axis;  // none: all
};

// Interface from the simulated stage to the simulated plant: the true positions of the axes.
class StageView {
 public:
  virtual ~StageView() = default;
  // Distance from the home sensor at clock.now(), whatever the device counts. Callable from any thread.
  [[nodiscard]] virtual Millimetres position(Axis axis) const = 0;
  // The same for x, y, z at `time`, not later than clock.now() and not before the last 256 changes of motion.
  [[nodiscard]] virtual std::array<Millimetres, kAxes> places(Nanoseconds time) const = 0;
  // True only if no axis has moved since `time`.
  [[nodiscard]] virtual bool at_rest_since(Nanoseconds time) const = 0;
};

}  // namespace tactbench::devices
