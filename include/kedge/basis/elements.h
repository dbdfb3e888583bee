// Finite elements that stand for the soil of each leaf: the GIMP basis without its averages over boxes.
#pragma once

#include <kedge/basis/gimp.h>

namespace kedge
{
/// Where the parts of the particles' boxes in one leaf are taken together. Part i of the element's parts,
/// part_begin[e] .. part_begin[e + 1], is `share[i]` of the integration volume of particle[i]. The soil of the element
/// has its mean place and spread along every axis at 2^dim places of equal weight; the gradients (1/m) of node v of the
/// element's n nodes, nodes[node_begin[e] ..], ascending, at place s are
/// gradient[dim * (2^dim node_begin[e] + n s + v) + axis].
struct Elements
{
  unsigned int dim = 3;
  View<unsigned int*> node_begin, nodes;
  View<unsigned int*> part_begin, particle;
  View<double*> share, gradient;
  View<int*> cell; ///< the group of F-bar in the leaf whose particles share their volume change, or -1

  std::size_t n() const { return cell.extent(0); }
};

/// `parts` and `corrections`: those of the stencils. `number`: leaf-table node -> active node. `group_of_leaf`: the
/// group of F-bar of a leaf, or -1.
template <int dim>
Elements make_elements(const LeafTable<dim>& table, const BoxParts<dim>& parts,
                       const std::vector<CellCorrection<dim>>& corrections, const std::vector<double>& volume,
                       const std::vector<unsigned int>& number, const std::vector<int>& group_of_leaf);
} // namespace kedge
