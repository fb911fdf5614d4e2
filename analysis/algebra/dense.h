// Products and decompositions of matrices whose size is found at run time. Eigen's templates for them are large, so
// they are compiled here once instead of with each caller.
#pragma once

#include <Eigen/Core>

namespace tactbench::analysis {

// a' a, (columns, columns).
Eigen::MatrixXd gram_of(const Eigen::MatrixXd& a);

// Solution x of a x = b for a square matrix (LU, partial pivoting). If a is singular, x is meaningless and may not be
// finite.
Eigen::VectorXd solve(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

// The x of least norm among those with the least |a x - b| (complete orthogonal decomposition); a may be
// rank-deficient.
Eigen::VectorXd least_norm_solution(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

// Of a symmetric matrix (only the lower half is read): eigenvalues in ascending order, and one unit eigenvector per
// column.
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
SymmetricEigen eigen_of(const Eigen::MatrixXd& symmetric);

}  // namespace tactbench::analysis
