// How the particles' boxes divide between the leaves.
#pragma once

#include <kedge/mesh/leaf_table.h>
#include <vector>

namespace kedge
{
/// The parts of boxes that lie in leaves. Box p has the parts begin[p] .. begin[p + 1]; they fill what of it lies in
/// known leaves, and their fractions of that sum to 1.
template <int dim> struct BoxParts
{
  std::vector<std::size_t> begin{0};
  std::vector<unsigned int> leaf; ///< in the order of the tree within a box
  std::vector<double> fraction;
  std::vector<std::array<double, dim>> middle; ///< of the part, m
};

/// Divides boxes, given by centre and half-widths (m). A box that reaches across the end of the window shrinks on both
/// sides to what fits there. Parts below 1e-11 of a box are left out. A box whose centre is beside the window has none.
/// Consecutive boxes of the same `leaf`, which is that of their centre, are searched for together; without leaves each
/// is for itself.
template <int dim>
BoxParts<dim> find_box_parts(const LeafTable<dim>& table, const std::vector<std::array<double, dim>>& centre,
                             const std::vector<std::array<double, dim>>& half_width,
                             const std::vector<unsigned int>& leaf = {});

/// Half-widths of boxes that stand for their centres: averages need a volume, also in the standard MPM.
template <int dim>
std::vector<std::array<double, dim>> point_boxes(const std::vector<std::array<double, dim>>& half_width);

/// Throws SolverError if a box has no parts.
template <int dim>
void refuse_boxes_outside(const BoxParts<dim>& parts, const std::vector<std::array<double, dim>>& centre);
} // namespace kedge
