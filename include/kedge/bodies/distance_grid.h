// Distances from a surface on a grid, which tell at once of most points that they are far from it.
#pragma once

#include <array>
#include <functional>
#include <kedge/bodies/triangle_tree.h>
#include <vector>

namespace kedge
{
/// Sets up and keeps what DistanceCells reads.
class DistanceGrid
{
public:
  /// `signed_distance`: m, negative inside the body; evaluated at about n_cells places.
  DistanceGrid(const Eigen::Vector3d& lower, const Eigen::Vector3d& upper, std::size_t n_cells,
               const std::function<double(const Eigen::Vector3d&)>& signed_distance);

  DistanceCells cells() const;
  const std::vector<float>& values() const { return distance; }

private:
  Eigen::Vector3d lower;
  double size; ///< of a cell, m
  std::array<int, 3> n;
  std::vector<float> distance; ///< rounded down
};
} // namespace kedge
