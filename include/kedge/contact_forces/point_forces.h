// Forces at points of the soil, spread to nodes: what contact hands to assembly.
#pragma once

#include <kedge/base/kokkos.h>

namespace kedge
{
/// Force i acts at a point whose displacement is sum over its nodes of weight * nodal displacement. Nodes are local
/// active numbers: nodes[begin[i] .. begin[i + 1]). `force` (N) acts on the soil; `tangent` = d force / d point
/// displacement (N/m, row by row), both with 3 and 9 entries per point also in 2-D, of which the first dim along each
/// axis count. Most points touch nothing: only those in `acting` may have a force or a tangent that is not zero.
struct PointForces
{
  View<unsigned int*> begin, nodes;
  View<double*> weights, force, tangent;
  View<unsigned int*> acting; ///< the first n_acting entries, in ascending order
  std::size_t n_acting = 0;

  std::size_t n() const { return force.extent(0) / 3; }
};
} // namespace kedge
