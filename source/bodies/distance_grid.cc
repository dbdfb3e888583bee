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
    n[d] = std::max<std::ptrdiff_t>(1, std::llround(std::ceil((upper[d] - lower[d]) / size)));
  constexpr double rounding = 1e-6; // of single precision, and more
  for (std::ptrdiff_t k = 0; k < n[2]; ++k)
    for (std::ptrdiff_t j = 0; j < n[1]; ++j)
      for (std::ptrdiff_t i = 0; i < n[0]; ++i)
        distance.push_back((1. - rounding) *
                           std::max(0., signed_distance(lower + size * Eigen::Vector3d(i + 0.5, j + 0.5, k + 0.5))));
}

double DistanceGrid::least_distance(const Eigen::Vector3d& x) const
{
  const Eigen::Vector3d place = (x - lower) / size;
  std::array<std::ptrdiff_t, 3> at;
  for (int d = 0; d < 3; ++d)
  {
    at[d] = static_cast<std::ptrdiff_t>(std::floor(place[d]));
    if (!(place[d] >= 0. && at[d] < n[d]))
      return 0.;
  }
  const Eigen::Vector3d from_centre = place - Eigen::Vector3d(at[0] + 0.5, at[1] + 0.5, at[2] + 0.5);
  return std::max(0., distance[(at[2] * n[1] + at[1]) * n[0] + at[0]] - size * from_centre.norm());
}
} // namespace kedge
