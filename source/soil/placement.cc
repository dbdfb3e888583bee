#include <cmath>
#include <kedge/base/communication.h>
#include <kedge/soil/placement.h>
#include <limits>

namespace kedge
{
template <int dim> void place_on_soil(RigidSystems& bodies, const Soil<dim>& soil)
{
  const ParticleSet<dim>& particles = soil.particles();
  const auto box = world_bounds(bodies);
  double height = -std::numeric_limits<double>::infinity();
  for (std::size_t p = 0; p < particles.positions().size(); ++p)
  {
    const auto &x = particles.positions()[p], &half = particles.half_widths()[p];
    bool below = true;
    for (unsigned int d = 0; d + 1 < dim; ++d)
      below = below && x[d] + half[d] > box[0][d] && x[d] - half[d] < box[1][d];
    if (below)
      height = std::max(height, x[dim - 1] + half[dim - 1]);
  }
  height = max_over_ranks(height, soil.communicator());
  if (std::isfinite(height))
    place_on_surface(bodies, 2, height);
}

template void place_on_soil<2>(RigidSystems&, const Soil<2>&);
template void place_on_soil<3>(RigidSystems&, const Soil<3>&);
} // namespace kedge
