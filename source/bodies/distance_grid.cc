#include <kedge/bodies/distance_grid.h>

#include <algorithm>
#include <cmath>

namespace kedge
{
DistanceGrid::DistanceGrid(const Eigen::Vector3d& lower_, const Eigen::Vector3d& upper, const std::size_t n_cells,
                           const std::function<double(const Eigen::Vector3d&)>& signed_distance)
    : lower(lower_), size(std::cbrt((upper - lower).prod() / n_cells))
{
  for (int d = 0; d < 3; ++d)
    n[d] = std::max(1, static_cast<int>(std::ceil((upper[d] - lower[d]) / size)));
  constexpr double rounding = 1e-6; // of single precision, and more
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i)
        distance.push_back((1. - rounding) *
                           std::max(0., signed_distance(lower + size * Eigen::Vector3d(i + 0.5, j + 0.5, k + 0.5))));
}

DistanceCells DistanceGrid::cells() const { return {lower, size, {n[0], n[1], n[2]}, distance.data()}; }
} // namespace kedge
