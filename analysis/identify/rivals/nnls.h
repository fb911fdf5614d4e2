// Non-negative least squares on the normal equations.
#pragma once

#include <Eigen/Core>

namespace tactbench::analysis {

// Minimises x' gram x - 2 x' along over x >= 0 (Lawson and Hanson, Solving Least Squares Problems, 1974, chapter 23).
// Columns that are the same as others to 1e-10 are left at 0. Deterministic; at most 3 n columns enter.
Eigen::VectorXd non_negative_least_squares(const Eigen::MatrixXd& gram, const Eigen::VectorXd& along);

}  // namespace tactbench::analysis
