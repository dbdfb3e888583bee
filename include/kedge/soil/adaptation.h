// The cells follow the bodies: one pass of refinement or coarsening after the other.
#pragma once

#include <kedge/bodies/rigid_systems.h>
#include <kedge/particles/particle_set.h>

namespace kedge
{
/// Whether a surface crosses a cell, given by its lower corner and edge (m), or lies in one of its faces.
template <int dim>
bool surface_touches_cell(const RigidSystems& bodies, const std::array<double, dim>& corner, double size);

/// The largest edge (m) that the stage allows a cell with this lower corner and edge (m).
template <int dim>
double wanted_size(const RigidSystems& bodies, const Adaptivity& adaptivity, double base_size,
                   const std::array<double, dim>& corner, double size);

/// Changes the mesh until its cells have the sizes that the stage asks for at the bodies' surfaces and in the region
/// around them: first level by level finer, then coarser. Cells without active soil are refined only where 2:1 asks for
/// it; no cell coarsens while a particle in it needs it or while the surfaces ask its parent to be finer.
template <int dim> class CellAdaptation
{
public:
  enum class Pass
  {
    none,     ///< the mesh is as it should be
    cells,    ///< cells changed: particles may be too wide for theirs
    partition ///< families of cells came together on one rank
  };

  /// `points_per_axis` of a base cell: a particle needs cells no larger than this many times its width.
  CellAdaptation(BackgroundMesh<dim>& mesh, ParticleSet<dim>& particles, const RigidSystems& bodies,
                 const Adaptivity& adaptivity, unsigned int points_per_axis);

  /// Does one pass, if one is needed. Between two passes particles may be split or sent to other ranks. Collective.
  Pass next();

  /// The leaves before the last pass that changed cells.
  const LeafTable<dim>& former() const { return before; }

private:
  std::vector<unsigned char> find_soil(const std::vector<unsigned char>& asked) const;
  std::vector<double> find_largest_sizes() const;
  bool change_cells();

  BackgroundMesh<dim>& mesh;
  ParticleSet<dim>& particles;
  const RigidSystems& bodies;
  const Adaptivity& adaptivity;
  unsigned int points_per_axis;
  LeafTable<dim> before;
  double finest;         ///< smallest size that is wanted anywhere, m
  bool refines;          ///< still
  bool gathered = false; ///< no cell changed since the last repartition
};
} // namespace kedge
