// Decides which of many figures, judged together, are reported as changed.
#pragma once

#include <span>
#include <vector>

namespace tactbench::analysis {

inline constexpr double kFalseDiscoveryRate = 0.05;

// Step-up procedure of Benjamini and Hochberg 1995 (J. R. Stat. Soc. B 57, 289): with the m probabilities sorted, those
// up to the largest k with p_(k) <= rate k / m are reported. The expected share of false ones among those reported is
// at most `rate`, for figures that are independent or positively dependent (Benjamini and Yekutieli 2001). One place a
// probability.
std::vector<bool> discoveries(std::span<const double> probabilities, double rate = kFalseDiscoveryRate);

}  // namespace tactbench::analysis
