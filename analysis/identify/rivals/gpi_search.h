// The residuals of GPI along all histories with their exact derivatives, and the search from one start.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "analysis/identify/fit_samples.h"
#include "analysis/models/gpi.h"

namespace tactbench::analysis {

// The 8 independent numbers [A16], over inputs and outputs brought to 0..1 and with rho = 1: gamma_l(u) = l0 + dl S(u),
// S(u) = (1 - e^(-a u)) / (1 - e^-a); gamma_r alike; r_i = alpha i; density e^(-s i).
enum GpiUnknown { kLnA, kL0, kLnDl, kLnB, kR0, kLnDr, kLnAlpha, kS, kGpiUnknowns };
using GpiVector = Eigen::Matrix<double, kGpiUnknowns, 1>;

GpiParameters gpi_parameters(const GpiVector& unknowns, double x_span, double y_span);

class GpiSearch {
 public:
  explicit GpiSearch(const FitSamples& samples);

  struct Found {
    GpiVector unknowns;
    double j = 0.0;  // of outputs in 0..1
  };
  // At most `steps` steps of Levenberg-Marquardt from `start`; `y` by sample, brought to 0..1.
  [[nodiscard]] Found search(const GpiVector& start, std::span<const double> y, int steps) const;

 private:
  // A walk over the histories: where to, and what for.
  struct Step {
    std::size_t knot = 0;    // of the distinct inputs
    std::size_t sample = 0;  // whose output is compared
    bool virgin = false, compare = false, move = false;
  };
  struct Normal {
    double j = 0.0;
    Eigen::Matrix<double, kGpiUnknowns, kGpiUnknowns> hessian;
    GpiVector gradient;
  };
  struct Table;
  void evaluate(const GpiVector& unknowns, std::span<const double> y, Table& table, Normal& into) const;
  std::vector<double> knots_;
  std::vector<Step> steps_;
};

}  // namespace tactbench::analysis
