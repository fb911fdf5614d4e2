// J of GPI of many candidates of one taxel at a time, in vector lanes. Each dispatch does the same double operations in
// the same order, so that results are bit for bit the same on every one of them, however candidates are grouped.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "analysis/identify/rivals/gpi_tree.h"
#include "analysis/models/gpi.h"

namespace tactbench::analysis {

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
  static constexpr std::size_t kMost = 8;  // candidates in one call
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
