// Forces at points of the soil, spread to nodes: what contact hands to assembly.
#pragma once

#include <vector>

namespace kedge
{
/// Force i acts at a point whose displacement is sum over its nodes of weight * nodal displacement. Nodes are local
/// active numbers: nodes[begin[i] .. begin[i + 1]). `force` (N) acts on the soil; `tangent` = d force / d point
/// displacement (N/m, row by row), both with 3 and 9 entries per point also in 2-D, of which the first dim count.
struct PointForces
{
  std::vector<unsigned int> begin{0}, nodes;
  std::vector<double> weights, force, tangent;

  std::size_t n_points() const { return begin.size() - 1; }
};
} // namespace kedge
