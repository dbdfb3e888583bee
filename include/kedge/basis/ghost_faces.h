// The faces that need ghost stabilisation, and their matrices.
#pragma once

#include <kedge/base/kokkos.h>
#include <kedge/basis/leaf_contents.h>
#include <vector>

namespace kedge
{
/// Nodes that a face may have: both leaves' corners, or the masters of those that hang.
constexpr unsigned int max_ghost_face_nodes = 32;

/// Stabilised faces of a rank; nodes are local numbers of the leaf table. Face f has the nodes
/// nodes[node_begin[f] .. node_begin[f + 1]) and the symmetric matrix J (m3; 2-D: m2) at value[value_begin[f]].
/// stiffness[f] J acts on increments (N/m), mass[f] J on accelerations (kg).
struct HostGhostFaces
{
  std::vector<unsigned int> node_begin{0}, nodes;
  std::vector<std::size_t> value_begin{0};
  std::vector<double> value;
  std::vector<double> measure;   ///< h^3 / 3 times the area of the face, m^(dim + 2)
  std::vector<double> stiffness; ///< factor times Young's modulus, N/m4
  std::vector<double> mass;      ///< factor times density, kg/m3
};

/// The same on the device; nodes are numbers of active nodes.
struct GhostFaces
{
  View<unsigned int*> node_begin, nodes;
  View<std::size_t*> value_begin;
  View<double*> value, measure, stiffness, mass;

  std::size_t n_faces() const { return stiffness.extent(0); }
};

/// How strong the stabilisation is.
struct GhostFactors
{
  double stiffness = 0.;          ///< 1/m2, as in the published inputs; the strength is this times h^2
  double mass = 0.;               ///< no unit
  double relative_stiffness = 0.; ///< no unit; adds this over h^2 of the face to the stiffness
};

/// Faces between a boundary leaf and a populated leaf, each on one rank (Coombs 2023, doi 10.1002/nme.7332). J is h^3 /
/// 3 times the integral over the face of the product of the jumps of the normal derivative. h and the face belong to
/// the smaller leaf; E and the density are means of both leaves.
template <int dim>
HostGhostFaces find_ghost_faces(const LeafTable<dim>& table, const std::vector<LeafContent>& contents,
                                const GhostFactors& factors);

/// Renames the nodes by `number` (leaf-table node -> active node) and copies to the device.
GhostFaces upload_ghost_faces(HostGhostFaces&& host, const std::vector<unsigned int>& number);
} // namespace kedge
