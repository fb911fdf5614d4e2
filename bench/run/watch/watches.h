// What a run watches while it goes on: monotone branches, the end of conditioning, stuck rows, conditions that suspend
// it, and the time that it loses.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bench/rig/rig.h"
#include "db/run_store.h"
#include "devices/tactile/tactile_array.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

// Thrown from a branch that must be repeated.
struct PathBroken {
  std::string what;
};

class BranchGuard {
 public:
  // The branch rises if `to` > `from`; if they are equal, any change beyond the tolerance breaks it.
  BranchGuard(double from, double to, double tolerance) : from_(from), to_(to), tolerance_(tolerance) {}
  // To be called with each measured value; returns what broke the branch, or nothing.
  [[nodiscard]] std::optional<std::string> see(double value);

 private:
  double from_, to_, tolerance_;
  std::optional<double> highest_, lowest_;
};

// Ends conditioning when a loop no longer differs from the previous one, not after a fixed number of loops.
class ConditioningWatch {
 public:
  explicit ConditioningWatch(const sequences::Conditioning& rule) : rule_(rule) {}
  // True when the next cycle is not needed.
  [[nodiscard]] bool enough(int cycle) const;
  [[nodiscard]] bool wants_output() const { return rule_.change_percent > 0.0; }
  // To be called with the array's counts after a step of a cycle (at its peak, back at 0).
  void see(const sequences::Step& step, const std::vector<std::uint16_t>& counts);
  // Change from loop to loop, % of the response to the peak, from the second cycle on.
  [[nodiscard]] const std::vector<double>& changes() const { return changes_; }
  [[nodiscard]] std::string verdict() const;  // warning: at most `cycles` were not enough
  [[nodiscard]] std::string detail_json() const;

 private:
  sequences::Conditioning rule_;
  std::vector<std::vector<double>> loops_;  // per cycle: mean output at each of its steps, counts
  std::vector<double> changes_;
};

// Detects scans that do not follow the load: a scanner that repeats an old frame, or a row with a stuck multiplexer.
// The counts then stay identical, noise included, while the load changes.
struct StuckRows {
  bool all = false;       // no row has changed
  std::vector<int> rows;  // rows that have not changed; rows at the converter's limit are not judged
};

class StuckRowWatch {
 public:
  // `load`: any quantity that the array should follow, the same at each call; only changes of at least `least` are
  // considered.
  [[nodiscard]] StuckRows see(const devices::ScanSet& scans, double load, double least);

 private:
  devices::ScanSet last_;
  std::vector<double> changed_at_;  // by row: the load at which it last changed
};

// Environmental conditions under which a run is suspended, with separate trip and resume thresholds (hysteresis).
// Thrown from a branch when a condition trips; the branch is repeated once the condition holds again.
struct Suspended {
  std::string what;
  double timeout_s = 0.0;
};

class SuspensionWatch {
 public:
  void follow(const std::vector<sequences::Suspension>& rules);
  [[nodiscard]] bool empty() const { return rules_.empty(); }
  // The first rule that trips at these readings. A quantity without a reading trips no rule.
  [[nodiscard]] std::optional<Suspended> tripped(const std::vector<EnvironmentReading>& readings) const;
  // True when every rule has been inside its resume threshold for its hold time; to be called while suspended.
  [[nodiscard]] bool may_resume(const std::vector<EnvironmentReading>& readings, devices::Nanoseconds now);

 private:
  std::vector<sequences::Suspension> rules_;
  std::optional<devices::Nanoseconds> good_since_;
};

// The part of a stored run's time that its recipe did not need: waits for people and conditions, the rest between an
// end and a resume, and work repeated because of them. Derived from the run's events.
struct LostTime {
  std::int64_t position = 0;  // position of the first frame that it delayed
  std::int64_t ns = 0;
};

// Ordered by position, at most one per frame. `last`: the run's last position. Throws StoreError.
std::vector<LostTime> lost_times(const db::RunReader& store, std::int64_t run, std::int64_t last);

}  // namespace tactbench::bench
