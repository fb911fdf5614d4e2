// All histories that a fit sees as one tree of states: play operators forget what a larger swing has wiped out, so that
// samples after the same remembered turns have the same model value whatever the parameters, and are compared once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "analysis/identify/fit_samples.h"

namespace tactbench::analysis {

struct GpiTree {
  // Throws nothing. Knots are the distinct inputs as shares of the range.
  explicit GpiTree(const FitSamples& samples);

  // The state at `knot`, reached without a turn from the state in slot `from` (kVirgin: all operators at 0). A slot is
  // free again after the last state that is reached from it.
  struct Node {
    std::uint32_t from = 0, slot = 0, knot = 0;
    std::size_t first = 0, end = 0;  // its steps
  };
  struct Step {
    std::uint32_t knot = 0;
    double weight = 0.0;  // samples that are compared there
  };
  static constexpr std::uint32_t kVirgin = 0xffffffffU;
  std::vector<double> knots;
  std::vector<Node> nodes;  // parents first
  std::vector<Step> steps;
  std::uint32_t slots = 0;

  // What is compared at each step, and the part of J that no parameter moves.
  struct Target {
    std::vector<double> mean;
    double constant = 0.0;
  };
  [[nodiscard]] Target target(std::span<const double> y) const;  // by sample

 private:
  std::vector<std::size_t> sample_;     // that is compared,
  std::vector<std::uint32_t> step_of_;  // and where
};

}  // namespace tactbench::analysis
