// Quadrature of full cells, made exact for constants and linear functions.
#pragma once

#include <kedge/basis/leaf_contents.h>

namespace kedge
{
/// What a leaf does to the parts of particles' boxes in it, so that their sum integrates over the leaf. In soil that
/// has flown the boxes overlap here and leave gaps there, so uniform stress pushes the nodes about (Baumgarten & Kamrin
/// 2023 on where the error comes from).
/// In full leaves
/// - volumes are scaled so that they fill the leaf, and
/// - gradients are taken at places shifted so that the soil's centroid is the leaf's centre (3-D: less the mean of the
///   bilinear part).
/// The sum of gradients over a full leaf is then that of the finite element with the same nodes, wherever the particles
/// are, and uniform stress is in balance. Linear fields have the same gradient at every place, so they are reproduced.
/// Leaves that are partly full (LeafContent::full) get that share of the shift, and their volumes stay.
template <int dim> struct CellCorrection
{
  double scale = 1.;               ///< of volumes
  std::array<double, dim> shift{}; ///< of the places where gradients are taken, m
  std::array<double, dim> twist{}; ///< added to gradients with the sign of the vertex's natural coordinates, 1/m

  std::array<double, dim> corrected(std::array<double, dim> x) const
  {
    for (unsigned int d = 0; d < dim; ++d)
      x[d] += shift[d];
    return x;
  }
};

/// That of a leaf; none where there are no corrections.
template <int dim>
CellCorrection<dim> correction_of(const std::vector<CellCorrection<dim>>& corrections, const unsigned int leaf)
{
  return corrections.empty() ? CellCorrection<dim>() : corrections[leaf];
}

/// The corrections of all leaves; none for those that are not full at all.
template <int dim>
std::vector<CellCorrection<dim>> find_cell_corrections(const LeafTable<dim>& table,
                                                       const std::vector<LeafContent>& contents);
} // namespace kedge
