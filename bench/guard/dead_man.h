// A dead-man's memory: fed in time it is silent, fed late it has fired, and stays so. The same object runs under
// process time inside a simulated bench and under real time in the dead-man's own process.
#pragma once

#include <optional>
#include <string>

#include "devices/clock.h"

namespace tactbench::bench {

inline constexpr const char* kDeadManFired = "TB-DEADMAN-FIRED";  // fault and trip
// Faults: it watches no more, though it has not fired.
inline constexpr const char* kDeadManSilent = "TB-DEADMAN-SILENT";  // does not answer
inline constexpr const char* kDeadManEnded = "TB-DEADMAN-ENDED";    // its process is gone
inline constexpr const char* kDeadManBlind = "TB-DEADMAN-BLIND";    // does not reach the module

// Why a dead-man cannot be counted on.
struct WatcherLost {
  std::string id, what, remedy;
};

class DeadMan {
 public:
  // Counts from the first feeding.
  explicit DeadMan(devices::Nanoseconds timeout) : timeout_(timeout) {}
  void feed(devices::Nanoseconds now) {
    if (!late(now)) last_ = now;
    started_ = true;
  }
  // True once more than `timeout` lay between two feedings, or lies between the last one and `now`.
  [[nodiscard]] bool late(devices::Nanoseconds now) {
    fired_ = fired_ || (started_ && now - last_ > timeout_);
    return fired_;
  }
  [[nodiscard]] devices::Nanoseconds left(devices::Nanoseconds now) const { return timeout_ - (now - last_); }

 private:
  devices::Nanoseconds timeout_;
  devices::Nanoseconds last_{0};
  bool started_ = false;
  bool fired_ = false;
};

// What the guard asks of whichever dead-man watches its bench.
class Watcher {
 public:
  virtual ~Watcher() = default;
  virtual void feed() = 0;  // the sequencer has made progress
  [[nodiscard]] virtual bool fired() = 0;
  // It watches no more and has not fired, and a run must not go on without it. None: it watches. Stays.
  [[nodiscard]] virtual std::optional<WatcherLost> lost() = 0;
  // The wires are the dead-man's: it makes safe over them. Waits until it has ended, at most `longest`; false: it still
  // works.
  [[nodiscard]] virtual bool wait_ended(devices::Nanoseconds longest) = 0;
};

// Of a bench simulated in its own process, in process time. Whoever finds it fired has to make safe.
class ProcessTimeWatcher final : public Watcher {
 public:
  ProcessTimeWatcher(devices::Nanoseconds timeout, const devices::Clock& clock) : dead_man_(timeout), clock_(clock) {}
  void feed() override { dead_man_.feed(clock_.now()); }
  [[nodiscard]] bool fired() override { return dead_man_.late(clock_.now()); }
  [[nodiscard]] std::optional<WatcherLost> lost() override { return std::nullopt; }  // lives as long as its clock
  [[nodiscard]] bool wait_ended(devices::Nanoseconds) override { return true; }

 private:
  DeadMan dead_man_;
  const devices::Clock& clock_;
};

}  // namespace tactbench::bench
