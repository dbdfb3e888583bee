#include <kedge/bodies/world_axes.h>
#include <kedge/simulation/moving_window.h>

namespace kedge
{
template <int dim> Extent<dim> extent_of(const RigidSystems& bodies)
{
  const auto box = world_bounds(bodies);
  Extent<dim> extent;
  for (unsigned int d = 0; d < dim; ++d)
  {
    const unsigned int axis = world_axis(dim, d);
    extent.lower[d] = box[0][axis];
    extent.upper[d] = box[1][axis];
  }
  return extent;
}

template <int dim>
long long move_window(BackgroundMesh<dim>& mesh, ParticleSet<dim>& particles, const Window<dim>& window,
                      const BoundaryTrack& track)
{
  mesh.set_window(window);
  const long long deleted = particles.remove_if(
      [&](const auto& particle)
      {
        // by its cell, as activity is
        const dealii::Point<dim> centre = particle.get_surrounding_cell()->center();
        std::array<double, dim> x;
        for (unsigned int d = 0; d < dim; ++d)
          x[d] = centre[d];
        return is_left_behind<dim>(x, window, track, mesh.layout());
      });
  particles.load();
  return deleted;
}

template Extent<2> extent_of<2>(const RigidSystems&);
template Extent<3> extent_of<3>(const RigidSystems&);
template long long move_window<2>(BackgroundMesh<2>&, ParticleSet<2>&, const Window<2>&, const BoundaryTrack&);
template long long move_window<3>(BackgroundMesh<3>&, ParticleSet<3>&, const Window<3>&, const BoundaryTrack&);
} // namespace kedge
