// Environmental conditions under which a run is suspended, with separate trip and resume thresholds (hysteresis).
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bench/rig/rig.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

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

}  // namespace tactbench::bench
