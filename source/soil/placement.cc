#include <cmath>
#include <kedge/base/communication.h>
#include <kedge/soil/placement.h>
#include <limits>

namespace kedge
{
template <int dim> bool place_on_soil(RigidSystems& bodies, const Soil<dim>& soil)
{
  const auto box = world_bounds(bodies);
  double height = -std::numeric_limits<double>::infinity();
  for (const auto& particle : soil.particles().handler()) // also those that wait
  {
    const dealii::Point<dim> x = particle.get_location();
    const double* half = &particle.get_properties()[field::half_width];
    bool below = true;
    for (unsigned int d = 0; d + 1 < dim; ++d)
      below = below && x[d] + half[d] > box[0][d] && x[d] - half[d] < box[1][d];
    if (below)
      height = std::max(height, x[dim - 1] + half[dim - 1]);
  }
  height = max_over_ranks(height, soil.communicator());
  if (std::isfinite(height))
    place_on_surface(bodies, 2, height);
  return std::isfinite(height);
}

template bool place_on_soil<2>(RigidSystems&, const Soil<2>&);
template bool place_on_soil<3>(RigidSystems&, const Soil<3>&);
} // namespace kedge
