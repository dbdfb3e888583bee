// How much soil the cells hold, and where in them.
#pragma once

#include <array>
#include <kedge/basis/box_parts.h>
#include <mpi.h>
#include <vector>

namespace kedge
{
/// The data of this rank's particles that fill the leaves.
template <int dim> struct SoilBoxes
{
  const BoxParts<dim>& parts;
  const std::vector<std::array<double, dim>>& half_width;  ///< of the boxes, m
  const std::vector<double>&young, &mass, &initial_volume; ///< Pa, kg (2-D: kg/m), m3 (m2)
};

/// Soil in a leaf, over all ranks. Each leaf gets the share of a particle that it has of the particle's box.
struct LeafContent
{
  double volume = 0.;                   ///< of the particles' boxes in it, m3 (2-D: m2)
  double initial_volume = 0.;           ///< m3 (2-D: m2)
  double stiffness = 0.;                ///< volume times Young's modulus
  double mass = 0.;                     ///< kg (2-D: kg/m)
  double boundary = 0.;                 ///< 1: a face neighbour is unpopulated, or the filling is below the poor factor
  double full = 0.;                     ///< 1: soil takes all of it, however unevenly spread; less at the soil's ends
  std::array<double, 3> moment{};       ///< volume times place, from the leaf's centre in sizes of the leaf
  std::array<double, 3> mixed_moment{}; ///< volume times y z, z x, x y of that place

  /// Adds what another rank's particles bring. Marks stay as they are.
  void add(const LeafContent& other);
};

/// Contents of all leaves of the table (owned and ghost). Cells beyond the ends of the window do not count as
/// neighbours. Collective.
template <int dim>
std::vector<LeafContent> find_leaf_contents(const LeafTable<dim>& table, const SoilBoxes<dim>& soil, double poor_factor,
                                            MPI_Comm communicator);

/// Leaves across a face (axis, upper or lower side): one, or 2^(dim-1) finer ones; none outside the window.
template <int dim>
std::vector<unsigned int> find_neighbours(const LeafTable<dim>& table, unsigned int leaf, unsigned int axis,
                                          bool upper);

/// Whether the basis sees the leaf. find_box_parts() has dropped slivers already; a further threshold here would leave
/// nodes of small cuts without stabilisation.
inline bool is_populated(const LeafContent& content) { return content.volume > 0.; }
} // namespace kedge
