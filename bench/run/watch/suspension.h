// Conditions of the surroundings under which a run waits: trip and resume thresholds, so that it does not flutter.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bench/rig/rig.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

// Thrown out of a branch when a condition trips; the branch is redone once it holds again.
struct Suspended {
  std::string what;
  double timeout_s = 0.0;
};

class SuspensionWatch {
 public:
  void follow(const std::vector<sequences::Suspension>& rules);
  [[nodiscard]] bool empty() const { return rules_.empty(); }
  // Which rule trips by these readings; the first of them. A quantity without a reading trips nothing.
  [[nodiscard]] std::optional<Suspended> tripped(const std::vector<EnvironmentReading>& readings) const;
  // True when every rule has been inside its resume threshold for its hold time; to be called while suspended.
  [[nodiscard]] bool may_resume(const std::vector<EnvironmentReading>& readings, devices::Nanoseconds now);

 private:
  std::vector<sequences::Suspension> rules_;
  std::optional<devices::Nanoseconds> good_since_;
};

}  // namespace tactbench::bench
