// Soil for the tests of all rooms: a block on a grid, and ways to refine, move and read it.
#pragma once

#include "mesh/refined_mesh.h"
#include <kedge/soil/soil.h>

namespace kedge::test
{
/// A layer of elastic soil.
inline Layer elastic_layer(const double thickness, const double density = 2000., const double young = 1e7,
                           const double poisson = 0.25)
{
  Layer layer;
  layer.thickness = thickness;
  layer.material.density = density;
  layer.material.young = young;
  layer.material.poisson = poisson;
  return layer;
}

/// Layers from the surface down with 2 particles per axis of a cell.
inline MaterialPointParameters layers_of(const std::vector<Layer>& layers, const std::optional<double> K0 = {})
{
  MaterialPointParameters parameters;
  parameters.layers = layers;
  parameters.K0 = K0;
  return parameters;
}

/// What a step would do to particles that move by displacement(number, axis) (m); dF is diagonal, `stretch` along x.
template <int dim, typename Displacement>
ParticleIncrements increments_of(const ParticleSet<dim>& particles, const Displacement& displacement,
                                 const double stretch = 1.)
{
  const std::vector<long long>& ids = particles.ids();
  ParticleIncrements result;
  result.displacement = kedge::View<double* [3]>("displacement", ids.size());
  result.deformation_gradient = kedge::View<double* [9]>("dF", ids.size());
  const auto u = copy_to_host(result.displacement);
  const auto f = copy_to_host(result.deformation_gradient);
  for (std::size_t p = 0; p < ids.size(); ++p)
    for (unsigned int d = 0; d < 3; ++d)
    {
      u(p, d) = d < dim ? displacement(ids[p], d) : 0.;
      f(p, 4 * d) = d == 0 ? stretch : 1.;
    }
  Kokkos::deep_copy(result.displacement, u);
  Kokkos::deep_copy(result.deformation_gradient, f);
  return result;
}

/// A soil with its parts at hand.
template <int dim> struct SoilFixture
{
  SoilFixture(const GridLayout<dim>& layout, const MaterialPointParameters& parameters, const double gravity = 10.,
              const ContactParameters& contact_parameters = {}, const MPI_Comm communicator = MPI_COMM_WORLD)
      : soil(layout, parameters, contact_parameters, communicator),
        mesh(soil.parts().mesh),
        particles(soil.parts().particles),
        contact(soil.parts().contact)
  {
    soil.generate(gravity);
  }

  /// Refines some of the cells, or all of them, with the particles as they are.
  void refine(const bool all = false, const std::uint64_t salt = 0)
  {
    particles.carry_through(
        [&]
        {
          if (all)
            mesh.triangulation().refine_global(1);
          else
            refine_some_cells(mesh, salt);
        });
    particles.balance_load(particle_cost);
  }

  /// Moves the particles by displacement(number, axis) (m).
  template <typename Displacement> void move(const Displacement& displacement)
  {
    particles.commit(increments_of(particles, displacement), DomainUpdate::none);
  }

  Soil<dim> soil;
  BackgroundMesh<dim>& mesh;
  ParticleSet<dim>& particles;
  Contact<dim>& contact;
};
} // namespace kedge::test
