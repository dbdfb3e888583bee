// The mesh follows the bodies.
#pragma once

#include <functional>
#include <kedge/bodies/rigid_systems.h>
#include <kedge/mesh/parameters.h>
#include <kedge/particles/particle_set.h>

namespace kedge
{
/// What the mesh of a stage follows.
struct AdaptationTarget
{
  const RigidSystems& bodies;
  const Adaptivity& adaptivity;
  unsigned int points_per_axis; ///< of a base cell: a particle needs cells no larger than this many times its width
  double particle_cost;         ///< as for ParticleSet::balance_load
};

/// What has to happen along with every change of the mesh.
struct AdaptationHooks
{
  std::function<void()> split_particles;  ///< called while the particles' arrays are out of date
  std::function<void()> follow_particles; ///< called when they are loaded again, perhaps on other ranks
};

/// Spreads cells and particles anew over the ranks if the busiest one has more than 1.1 times the mean work; `cost` as
/// for ParticleSet::balance_load. Returns whether it did; call load() then. Collective.
template <int dim> bool balance_where_it_pays(BackgroundMesh<dim>& mesh, ParticleSet<dim>& particles, double cost);

/// Refines and coarsens the mesh until its cells have the sizes that the stage asks for at the bodies' surfaces and in
/// the region around them. Cells without active soil are refined only where 2:1 asks for it; no cell coarsens while a
/// particle in it needs it or while the surfaces ask its parent to be finer. The load is spread anew where that pays.
/// Particles have to be loaded and are so afterwards. Returns whether anything changed, be it the partition only.
/// Collective.
template <int dim>
bool adapt_mesh(BackgroundMesh<dim>& mesh, ParticleSet<dim>& particles, const AdaptationTarget& target,
                const AdaptationHooks& hooks);
} // namespace kedge
