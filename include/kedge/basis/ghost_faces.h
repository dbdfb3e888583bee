// The faces that need ghost stabilisation, and their matrices.
#pragma once

#include <kedge/base/kokkos.h>
#include <kedge/mesh/leaf_table.h>
#include <mpi.h>
#include <vector>

namespace kedge
{
/// Stabilised faces of a rank; nodes are local numbers of the leaf table. Face f has the nodes
/// nodes[node_begin[f] .. node_begin[f + 1]) and the symmetric matrix J (m3; 2-D: m2) at value[value_begin[f]].
/// stiffness[f] J acts on increments (N/m), mass[f] J on accelerations (kg).
struct HostGhostFaces
{
  std::vector<unsigned int> node_begin{0}, nodes;
  std::vector<std::size_t> value_begin{0};
  std::vector<double> value;
  std::vector<double> stiffness; ///< factor times Young's modulus, N/m4
  std::vector<double> mass;      ///< factor times density, kg/m3
};

/// The same on the device; nodes are numbers of active nodes.
struct GhostFaces
{
  View<unsigned int*> node_begin, nodes;
  View<std::size_t*> value_begin;
  View<double*> value, stiffness, mass;

  std::size_t n_faces() const { return stiffness.extent(0); }
};

/// How strong the stabilisation is.
struct GhostFactors
{
  double stiffness = 0.; ///< 1/m2, as in the published inputs; the strength is this times h^2
  double mass = 0.;      ///< no unit
};

/// The data of this rank's particles that fill the leaves.
template <int dim> struct SoilBoxes
{
  const std::vector<std::array<double, dim>>&centre, &half_width; ///< m
  const std::vector<double>&young, &mass, &initial_volume;        ///< Pa, kg (2-D: kg/m), m3 (m2)
};

/// Soil in a leaf, over all ranks. Each leaf gets the share of a particle that it has of the particle's box.
struct LeafContent
{
  double volume = 0.;         ///< of the particles' boxes in it, m3 (2-D: m2)
  double initial_volume = 0.; ///< m3 (2-D: m2)
  double stiffness = 0.;      ///< volume times Young's modulus
  double mass = 0.;           ///< kg (2-D: kg/m)
  double boundary = 0.;       ///< 1: a face neighbour is unpopulated, or the filling is below the poor factor
};

/// Contents of all leaves of the table (owned and ghost). Cells beyond the ends of the window do not count as
/// neighbours. Collective.
template <int dim>
std::vector<LeafContent> find_leaf_contents(const LeafTable<dim>& table, const SoilBoxes<dim>& soil, double poor_factor,
                                            MPI_Comm communicator);

/// Whether the basis sees the leaf. BoxAverage has dropped slivers already; a further threshold here would leave nodes
/// of small cuts without stabilisation.
inline bool is_populated(const LeafContent& content) { return content.volume > 0.; }

/// Faces between a boundary leaf and a populated leaf, each on one rank (Coombs 2023, doi 10.1002/nme.7332). J is h^3 /
/// 3 times the integral over the face of the product of the jumps of the normal derivative. h and the face belong to
/// the smaller leaf; E and the density are means of both leaves.
template <int dim>
HostGhostFaces find_ghost_faces(const LeafTable<dim>& table, const std::vector<LeafContent>& contents,
                                const GhostFactors& factors);

/// Renames the nodes by `number` (leaf-table node -> active node) and copies to the device.
GhostFaces upload_ghost_faces(HostGhostFaces&& host, const std::vector<unsigned int>& number);
} // namespace kedge
