// Factors of a small dense matrix whose rows and columns have different units.
#pragma once

#include <Eigen/LU>
#include <cmath>

namespace kedge
{
/// S A S, where the diagonal matrix S removes the units of rows and columns, and its factors with full pivoting.
struct ScaledFactors
{
  Eigen::VectorXd scaling;
  Eigen::MatrixXd matrix;
  Eigen::FullPivLU<Eigen::MatrixXd> factors;

  /// Pivots below this share of the largest one count as zero. A joint of 1e10 N/m and a body of 10 N have pivots as
  /// small as 1e-9.
  static constexpr double singular_pivot = 1e-13;

  explicit ScaledFactors(const Eigen::MatrixXd& unscaled) : scaling(unscaled.cwiseAbs().rowwise().maxCoeff())
  {
    for (double& entry : scaling)
      entry = entry > 0. ? 1. / std::sqrt(entry) : 1.;
    matrix = scaling.asDiagonal() * unscaled * scaling.asDiagonal();
    factors.setThreshold(singular_pivot);
    factors.compute(matrix);
  }

  bool is_regular() const { return factors.isInvertible(); }

  /// A^-1 b of a regular A.
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const
  {
    return scaling.cwiseProduct(factors.solve(scaling.cwiseProduct(b)));
  }
};
} // namespace kedge
