// Which faces need ghost stabilisation, and their matrices.
#pragma once

#include <kedge/mesh/leaf_table.h>
#include <mpi.h>
#include <vector>

namespace kedge
{
/// Stabilised faces of a rank, nodes as local numbers of the leaf table. Face f has the nodes
/// nodes[node_begin[f] .. node_begin[f + 1]) and the symmetric matrix J at value[value_begin[f]].
struct HostGhostFaces
{
  std::vector<unsigned int> node_begin{0}, nodes;
  std::vector<std::size_t> value_begin{0};
  std::vector<double> value;
};

/// How much soil a leaf holds, over all ranks.
struct LeafContent
{
  double volume = 0.;    ///< of the particles' boxes in it, m3 (2-D: m2)
  double stiffness = 0.; ///< volume times Young's modulus
  double boundary = 0.;  ///< 1: has an unpopulated face neighbour or is filled below the poor factor
};

/// Contents of all leaves of the table (owned and ghost). Collective.
template <int dim>
std::vector<LeafContent>
find_leaf_contents(const LeafTable<dim>& table, const std::vector<std::array<double, dim>>& centre,
                   const std::vector<std::array<double, dim>>& half_width, const std::vector<double>& young,
                   double poor_factor, MPI_Comm communicator);

/// Whether the leaf holds more soil than round-off.
template <int dim>
bool is_populated(const LeafTable<dim>& table, const std::vector<LeafContent>& contents, unsigned int leaf);

/// Faces between a boundary leaf and a populated one, each on one rank, with J = factor * E * (h^3 / 3) * integral over
/// the face of the product of the jumps of the normal derivative; h and the face are the smaller leaf's, E is the mean
/// of the two leaves' (Coombs 2023, doi 10.1002/nme.7332). The factor's unit is 1/m2, as in the published inputs.
template <int dim>
HostGhostFaces find_ghost_faces(const LeafTable<dim>& table, const std::vector<LeafContent>& contents, double factor);
} // namespace kedge
