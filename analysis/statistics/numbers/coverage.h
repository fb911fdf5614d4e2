// Student's distribution and effective degrees of freedom: from a combined standard uncertainty to U (JCGM 100, G.3,
// G.4).
#pragma once

#include <limits>
#include <span>

namespace tactbench::analysis {

// JCGM 100, Table G.2 and 6.3.3: k = 2 for infinitely many degrees of freedom.
inline constexpr double kCoverageProbability = 0.954499736103642;
inline constexpr double kInfiniteDof = std::numeric_limits<double>::infinity();

// t_p(dof) with P(|T| <= t) = `probability` (0..1, both excluded). dof is cut to a whole number (G.4.1), infinity gives
// the normal distribution's factor. Throws std::invalid_argument for dof below 1 or another probability.
double coverage_factor(double dof, double probability = kCoverageProbability);

// One share of a combined variance: |c| u(x), and its degrees of freedom.
struct VarianceShare {
  double u = 0.0;
  double dof = kInfiniteDof;
};
// JCGM 100, Eq. (10) without correlations.
double combined_uncertainty(std::span<const VarianceShare> shares);
// Welch-Satterthwaite, JCGM 100 Eq. (G.2b); infinite when no share has a finite number.
double effective_dof(std::span<const VarianceShare> shares);

}  // namespace tactbench::analysis
