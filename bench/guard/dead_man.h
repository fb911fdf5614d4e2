// The timer of the dead-man, a watchdog on the sequencer: it fires when it is fed late, and stays fired. It runs on
// process time inside a simulated bench and on real time in the dead-man's own process.
#pragma once

#include <optional>
#include <string>

#include "devices/clock.h"

namespace tactbench::bench {

inline constexpr const char* kDeadManFired = "TB-DEADMAN-FIRED";  // fault and trip
// Faults of a dead-man that has not fired but no longer watches.
inline constexpr const char* kDeadManSilent = "TB-DEADMAN-SILENT";  // does not answer
inline constexpr const char* kDeadManEnded = "TB-DEADMAN-ENDED";    // its process is gone
inline constexpr const char* kDeadManBlind = "TB-DEADMAN-BLIND";    // does not reach the module

// Why a dead-man can no longer be relied on.
struct WatcherLost {
  std::string id, what, remedy;
};

class DeadMan {
 public:
  // Starts with the first feeding.
  explicit DeadMan(devices::Nanoseconds timeout) : timeout_(timeout) {}
  void feed(devices::Nanoseconds now) {
    if (!late(now)) last_ = now;
    started_ = true;
  }
  // True once more than `timeout` passed between two feedings, or has passed since the last one; stays true.
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

// What the guard needs from the dead-man of its bench.
class Watcher {
 public:
  virtual ~Watcher() = default;
  virtual void feed() = 0;  // the sequencer has made progress
  [[nodiscard]] virtual bool fired() = 0;
  // Why the dead-man no longer watches although it has not fired: a run must not continue without it. None: it watches.
  // Once set it stays set.
  [[nodiscard]] virtual std::optional<WatcherLost> lost() = 0;
  // While the dead-man makes the bench safe, the wires belong to it. Waits until it has ended, at most `longest`;
  // false: it still works.
  [[nodiscard]] virtual bool wait_ended(devices::Nanoseconds longest) = 0;
};

// The dead-man of a bench simulated in this process, on process time. The caller that finds it fired must make the
// bench safe.
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
