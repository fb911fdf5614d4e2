#include "analysis/statistics/numbers/coverage.h"

#include <cmath>
#include <stdexcept>

#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {

double coverage_factor(double dof, double probability) {
  if (!(dof >= 1.0) || !(probability > 0.0 && probability < 1.0))
    throw std::invalid_argument("a coverage factor needs one degree of freedom or more and a probability within 0..1");
  return student_quantile(0.5 + 0.5 * probability, std::floor(dof + 1e-9));
}

double combined_uncertainty(std::span<const VarianceShare> shares) {
  double sum = 0.0;
  for (const VarianceShare& share : shares) sum += share.u * share.u;
  return std::sqrt(sum);
}

double effective_dof(std::span<const VarianceShare> shares) {
  const double combined = combined_uncertainty(shares);
  double sum = 0.0;
  for (const VarianceShare& share : shares)
    if (std::isfinite(share.dof) && share.u > 0.0 && combined > 0.0) sum += std::pow(share.u / combined, 4) / share.dof;
  return sum > 0.0 ? 1.0 / sum : kInfiniteDof;
}

}  // namespace tactbench::analysis
