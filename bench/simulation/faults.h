// Schedule of the faults of the simulated rig: by process time, by pressure, by force, or by a test's call. Plant and
// simulated instruments query it. No wall clock: the same schedule and queries give the same run.
#pragma once

#include <atomic>
#include <limits>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/config/planned_fault.h"
#include "devices/clock.h"
#include "devices/fault_injection.h"

namespace tactbench::bench {

enum class Instrument { kModule, kController, kStage, kForce, kScanner };

// Thread-safe; calls no other code.
class Faults {
 public:
  explicit Faults(const std::vector<PlannedFault>& planned);
  // Starts the fault now, whatever its condition is.
  void inject(const PlannedFault& fault, devices::Nanoseconds now);
  void clear(FaultKind kind, devices::Nanoseconds now);  // ends an active fault; planned later ones stay planned
  // Reports the load at `time`: starts the faults that wait for it. `time` must not decrease.
  void load(double psi, double newtons, devices::Nanoseconds time);
  [[nodiscard]] bool any() const {
    return any_.load(std::memory_order_relaxed);
  }  // false: no fault has been active so far
  // The fault's value while it is active.
  [[nodiscard]] std::optional<double> active(FaultKind kind, devices::Nanoseconds time) const;
  // The same, and counts as one of its `times`.
  std::optional<double> take(FaultKind kind, devices::Nanoseconds time);
  // How the instrument's reply to a request at `time` is corrupted; counts as one of its `times`.
  devices::InjectedFault injected(Instrument instrument, devices::Nanoseconds time);
  struct Window {
    std::optional<devices::Nanoseconds> from, until;
    double value = 0.0;
  };
  [[nodiscard]] Window last(FaultKind kind, devices::Nanoseconds time) const;  // faults that have begun by then

 private:
  struct Entry {
    PlannedFault plan;
    std::optional<devices::Nanoseconds> from;
    std::optional<devices::Nanoseconds> until;
    long taken = 0;
  };
  void add(const PlannedFault& fault, std::optional<devices::Nanoseconds> from);
  [[nodiscard]] const Entry* find(FaultKind kind, devices::Nanoseconds time) const;
  mutable std::mutex mutex_;
  std::vector<Entry> entries_;
  std::atomic<bool> any_{false};
  std::atomic<bool> waits_for_load_{false};
};

}  // namespace tactbench::bench
