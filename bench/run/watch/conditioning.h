// Ends conditioning when a loop no longer differs from the previous one, not after a fixed number of loops.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sequences/recipe.h"

namespace tactbench::bench {

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

}  // namespace tactbench::bench
