// Scatter of a mean from few repetitions, pooled over what the mean is taken of (JCGM 100, H.3.6, 4.2.4 note; G.4.1).
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace tactbench::analysis {

// Repetitions x parts: each row holds the same parts (taxels, levels) of one repetition; the figure is their mean.
struct PooledScatter {
  // Root of the mean over the parts of their variances from row to row, in the unit of the parts. The variance of the
  // figure is at most this, whatever the correlation of the parts (Cauchy-Schwarz), and equal when they move as one.
  double s = 0.0;
  // Of s, by Welch-Satterthwaite from its two components (two-way analysis of variance, H.5): what the parts have in
  // common, n - 1, and their own, (n - 1)(parts - 1). Between n - 1 and (n - 1) x parts.
  double dof = 0.0;
  std::size_t rows = 0, parts = 0;
  [[nodiscard]] bool known() const { return rows >= 2 && parts >= 1; }
};

// Parts that are not finite in any row are left out. Not known with fewer than two rows or without parts.
PooledScatter pooled_scatter(std::span<const std::vector<double>> rows);

}  // namespace tactbench::analysis
