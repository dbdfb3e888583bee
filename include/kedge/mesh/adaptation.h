// One pass of refinement or of coarsening: which cells.
#pragma once

#include <functional>
#include <kedge/mesh/background_mesh.h>

namespace kedge
{
/// Largest edge (m) that a cell with this lower corner and edge (m) may have. Where a box wants a size, any box that
/// holds it has to want that size or a smaller one.
template <int dim> using WantedSize = std::function<double(const std::array<double, dim>& lower, double size)>;

/// Flags the owned cells that hold soil, `holds_soil[leaf]`, and are larger than wanted, by more than 1 percent.
/// Returns whether any rank flagged one. Collective.
template <int dim>
bool flag_refinement(BackgroundMesh<dim>& mesh, const WantedSize<dim>& wanted,
                     const std::vector<unsigned char>& holds_soil);

enum class Coarsening
{
  none,
  flagged,       ///< on some rank at least
  split_families ///< only of children on several ranks, which a repartition brings together
};

/// Flags families of cells whose parent is not larger than wanted nor than `largest[leaf]`, the edge (m) that the
/// particles in each of them allow, and which no finer cell touches: coarsening then needs no balance 2:1, so that the
/// result is the same on any number of ranks. Base cells stay. Collective.
template <int dim>
Coarsening flag_coarsening(BackgroundMesh<dim>& mesh, const WantedSize<dim>& wanted,
                           const std::vector<double>& largest);
} // namespace kedge
