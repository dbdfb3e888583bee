#include <kedge/simulation/burial.h>

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

template long long remove_buried_particles<2>(ParticleSet<2>&, const RigidSystems&);
template long long remove_buried_particles<3>(ParticleSet<3>&, const RigidSystems&);
} // namespace kedge
