// Puts all histories of a fit into one tree. A play operator forgets turning points that a larger swing has passed, so
// samples with the same remembered turning points have the same model value for any parameters: they share a node, and
// the model is evaluated once per node. And GPI's cost J along that tree, for eight candidates of one taxel at a time
// (vector_lanes.h).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "analysis/identify/fit_samples.h"
#include "analysis/models/gpi.h"

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

// The 8 independent numbers [A16], over inputs and outputs brought to 0..1 and with rho = 1: gamma_l(u) = l0 + dl S(u),
// S(u) = (1 - e^(-a u)) / (1 - e^-a); gamma_r alike; r_i = alpha i; density e^(-s i).
enum GpiUnknown { kLnA, kL0, kLnDl, kLnB, kR0, kLnDr, kLnAlpha, kS, kGpiUnknowns };
using GpiPoint = std::array<double, kGpiUnknowns>;
inline constexpr std::size_t kGpiNormals = kGpiUnknowns * (kGpiUnknowns + 1) / 2;

struct GpiFound {
  GpiPoint at{};
  double j = std::numeric_limits<double>::infinity();  // of outputs in 0..1
};

struct GpiLanes {
  static constexpr std::size_t kMost = 8;  // candidates in one call: kLanes
  // `tree` is kept as a pointer.
  explicit GpiLanes(const GpiTree& tree);
  // J of each candidate, and with `gradient` Gauss-Newton's normal equations: the lower triangle row by row, and half
  // of J's gradient.
  void evaluate(const GpiTree::Target& target, bool gradient);

  const GpiTree* tree;
  std::array<GpiPoint, kMost> at{};
  std::array<double, kMost> j{};
  std::array<std::array<double, kMost>, kGpiNormals> normal{};
  std::array<std::array<double, kMost>, kGpiUnknowns> slope{};

  // Of the kernel: the candidates lane by lane, envelopes at each knot with their derivatives, operators in each slot.
  std::array<std::array<double, kMost>, kGpiUnknowns> unknown{};
  std::vector<double> envelopes, slots;
};

}  // namespace tactbench::analysis
