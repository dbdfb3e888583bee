#include <cmath>
#include <kedge/base/communication.h>
#include <kedge/simulation/placement.h>
#include <limits>

namespace kedge
{
template <int dim> long long remove_buried_particles(ParticleSet<dim>& particles, const RigidSystems& bodies)
{
  const long long removed = particles.remove_if(
      [&](const auto& particle)
      {
        const dealii::Point<dim> x = particle.get_location();
        return is_inside(bodies, dim == 3 ? Eigen::Vector3d(x[0], x[1], x[dim - 1]) : Eigen::Vector3d(x[0], 0., x[1]));
      });
  particles.load();
  return removed;
}

template <int dim>
void place_on_soil(RigidSystems& bodies, const ParticleSet<dim>& particles, const MPI_Comm communicator)
{
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
  height = max_over_ranks(height, communicator);
  if (std::isfinite(height))
    place_on_surface(bodies, 2, height);
}

template void place_on_soil<2>(RigidSystems&, const ParticleSet<2>&, MPI_Comm);
template void place_on_soil<3>(RigidSystems&, const ParticleSet<3>&, MPI_Comm);
template long long remove_buried_particles<2>(ParticleSet<2>&, const RigidSystems&);
template long long remove_buried_particles<3>(ParticleSet<3>&, const RigidSystems&);
} // namespace kedge
