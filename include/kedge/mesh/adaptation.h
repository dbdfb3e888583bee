// Chooses the cells for one pass of refinement or coarsening.
#pragma once

#include <functional>
#include <kedge/mesh/background_mesh.h>

namespace kedge
{
/// Largest edge (m) that a cell with this lower corner and edge (m) may have. A box that contains another one must not
/// have a larger limit than the one inside.
template <int dim> using WantedSize = std::function<double(const std::array<double, dim>& lower, double size)>;

/// Tells of all leaves that are asked for (`asked[leaf]`) whether they hold soil; what it tells of others has no
/// meaning. Collective.
using FindSoil = std::function<std::vector<unsigned char>(const std::vector<unsigned char>& asked)>;

/// Flags the owned cells that hold soil and exceed the wanted size by more than 1 percent. `finest`: the smallest size
/// that is wanted anywhere (m). Returns whether any rank flagged one. Collective.
template <int dim>
bool flag_refinement(BackgroundMesh<dim>& mesh, const WantedSize<dim>& wanted, double finest,
                     const FindSoil& find_soil);

/// Appends the leaves in a cell or family with this lower corner and edge (m) and all that touch it, if only at a
/// corner.
template <int dim>
void find_touching(const LeafTable<dim>& table, const std::array<double, dim>& corner, double edge,
                   std::vector<unsigned int>& found);

enum class Coarsening
{
  none,
  flagged,       ///< at least one rank has flagged a family
  split_families ///< only families whose children are on several ranks; repartition() brings them together
};

/// Flags families of cells whose parent would be no larger than the wanted size and than `largest[leaf]`, the edge (m)
/// that the particles in each child allow. No finer cell may touch the family: coarsening then needs no balance 2:1,
/// and the result is the same on any number of ranks. Base cells stay. Collective.
template <int dim>
Coarsening flag_coarsening(BackgroundMesh<dim>& mesh, const WantedSize<dim>& wanted,
                           const std::vector<double>& largest);
} // namespace kedge
