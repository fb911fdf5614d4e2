// Table of the actuators that are tested against the rules of devices/device.h (actuator_contract_wire.cpp). A driver
// is added by an adapter: an ActuatorBed, and one JoinsActuatorLaws at namespace scope of a *_wire.cpp.
// tests/actuator_rules.cmake fails when a driver in devices/ has none.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "devices/clock.h"
#include "devices/device.h"

namespace tactbench::devices {

struct BedOptions {
  Nanoseconds reply_timeout = std::chrono::seconds(20);  // never reached where the other end answers
  Nanoseconds safe_timeout = std::chrono::seconds(2);    // how long making safe may wait for the actuator
};

using Act = std::function<void()>;

// A driver and its simulated end at the two ends of one real wire, under a manual clock.
class ActuatorBed {
 public:
  virtual ~ActuatorBed() = default;
  virtual Actuator& actuator() = 0;
  virtual ManualClock& clock() = 0;
  [[nodiscard]] virtual std::string faults_begin_with() const = 0;  // "TB-CHAMBER"

  virtual void make_ready() = 0;             // arms, and does what else commands need
  virtual std::vector<Act> commands() = 0;   // all commands, within their limits
  virtual std::vector<Act> forbidden() = 0;  // beyond each limit, and not-a-number
  virtual void load() = 0;                   // a command that takes the actuator away from its safe state
  [[nodiscard]] virtual bool make_safe() noexcept = 0;

  // At the simulated end, past the driver. May turn the clock a little.
  virtual bool is_in_safe_state() = 0;
  [[nodiscard]] virtual std::uint64_t received() const = 0;  // bytes or requests so far
  [[nodiscard]] virtual std::uint64_t driven() const = 0;    // of them, orders that drive or move
  virtual void fall_silent() = 0;                            // no request is answered any more
  virtual void break_wire() = 0;
  virtual void mend_wire() = 0;  // the other end keeps its power

  [[nodiscard]] virtual int questions() const = 0;               // lost in a row that make a fault
  [[nodiscard]] virtual int questions_to_make_safe() const = 0;  // at most, on a silent wire
};

struct ActuatorUnderLaw {
  std::string name;
  std::function<std::unique_ptr<ActuatorBed>(const BedOptions&)> make;
};

inline std::vector<ActuatorUnderLaw>& actuators_under_law() {
  static std::vector<ActuatorUnderLaw> table;
  return table;
}

// `Bed` is made of BedOptions and `arguments`.
template <class Driver, class Bed>
struct JoinsActuatorLaws {
  static_assert(std::is_base_of_v<Actuator, Driver> && std::is_base_of_v<ActuatorBed, Bed>);
  static_assert(std::is_same_v<decltype(std::declval<Bed&>().actuator()), Driver&>, "the bed holds another driver");
  template <class... Arguments>
  explicit JoinsActuatorLaws(std::string name, Arguments... arguments) {
    actuators_under_law().push_back({std::move(name), [=](const BedOptions& options) -> std::unique_ptr<ActuatorBed> {
                                       return std::make_unique<Bed>(options, arguments...);
                                     }});
  }
};

}  // namespace tactbench::devices
