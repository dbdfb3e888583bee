// Distances from a surface on a grid, which tell at once of most points that they are far from it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <vector>

namespace kedge
{
/// The distance at the centres of the cells of a box. It changes by no more than the distance between two points, so
/// each value bounds those around it.
class DistanceGrid
{
public:
  /// `signed_distance`: m, negative inside the body; evaluated at about n_cells places.
  DistanceGrid(const Eigen::Vector3d& lower, const Eigen::Vector3d& upper, std::size_t n_cells,
               const std::function<double(const Eigen::Vector3d&)>& signed_distance);

  /// A distance (m) that the signed one at x is not below; 0 where the grid tells nothing.
  double least_distance(const Eigen::Vector3d& x) const;

private:
  Eigen::Vector3d lower;
  double size; ///< of a cell, m
  std::array<std::ptrdiff_t, 3> n;
  std::vector<float> distance; ///< rounded down
};
} // namespace kedge
