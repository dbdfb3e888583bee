// Small pieces that several kernels use.
#pragma once

#include <Eigen/Core>
#include <kedge/assembly/lanes.h>
#include <kedge/assembly/node_graph.h>
#include <kedge/base/kokkos.h>
#include <kedge/basis/stencil.h>
#include <kedge/materials/material.h>
#include <kedge/particles/arrays.h>

namespace kedge
{
/// add_to() for n numbers that are neighbours in memory, of which the first `used` count.
template <int n, int used = n> KEDGE_FUNCTION void add_to(double* target, const Eigen::Matrix<double, n, 1>& values)
{
  if constexpr (one_thread)
  {
    Eigen::Map<Eigen::Matrix<double, n, 1>> sum(target);
    sum += values;
  }
  else
    for (int i = 0; i < used; ++i)
      Kokkos::atomic_add(target + i, values[i]);
}

/// The nodes that particle p sees and their S_v(p).
struct ParticleNodes
{
  unsigned int n;
  const unsigned int* node;
  const double* value;
};

KEDGE_FUNCTION ParticleNodes nodes_of(const StencilSet& stencils, const unsigned int p)
{
  const unsigned int pattern = stencils.pattern_of_particle(p);
  const unsigned int first = stencils.pattern_node_begin(pattern);
  return {stencils.pattern_node_begin(pattern + 1) - first, &stencils.pattern_nodes(first),
          &stencils.value(stencils.value_begin(p))};
}

/// Entry of column `node` in a row. The row must hold this column.
KEDGE_FUNCTION std::size_t find_entry(const View<std::size_t*>& row_begin, const View<unsigned int*>& column,
                                      const unsigned int row, const unsigned int node)
{
  std::size_t low = row_begin(row), high = row_begin(row + 1);
  while (high - low > 1)
  {
    const std::size_t middle = (low + high) / 2;
    (column(middle) <= node ? low : high) = middle;
  }
  return low;
}

/// The same, or the entry of the diagonal where the row does not hold the column: sparser matrices keep row sums.
KEDGE_FUNCTION std::size_t find_entry_or_diagonal(const View<std::size_t*>& row_begin,
                                                  const View<unsigned int*>& column, const unsigned int row,
                                                  const unsigned int node)
{
  const std::size_t entry = find_entry(row_begin, column, row, node);
  return column(entry) == node ? entry : find_entry(row_begin, column, row, row);
}

/// H[k][n] = sum over nodes of d_vk grad_n S_v of particle p, in lanes over n.
template <int dim>
KEDGE_FUNCTION void displacement_gradient(const StencilSet& stencils, const View<double*>& nodal, const unsigned int p,
                                          typename Lanes<dim>::Type (&H)[dim])
{
  const ParticleNodes at = nodes_of(stencils, p);
  const double* gradient = &stencils.gradient(dim * stencils.value_begin(p));
  for (int k = 0; k < dim; ++k)
    H[k].setZero();
  for (unsigned int v = 0; v < at.n; ++v)
  {
    const double* d = &nodal(std::size_t(dim) * at.node[v]);
    const typename Lanes<dim>::Type g = Lanes<dim>::read(gradient + dim * v);
    for (int k = 0; k < dim; ++k)
      H[k] += d[k] * g;
  }
}

/// dF = 1 + sum over nodes of d_v (x) grad S_v of particle p.
template <int dim>
KEDGE_FUNCTION Eigen::Matrix3d deformation_increment(const StencilSet& stencils, const View<double*>& increment,
                                                     const unsigned int p)
{
  typename Lanes<dim>::Type H[dim];
  displacement_gradient<dim>(stencils, increment, p, H);
  Eigen::Matrix3d result = Eigen::Matrix3d::Identity();
  for (int i = 0; i < dim; ++i)
    for (int j = 0; j < dim; ++j)
      result(i, j) += H[i][j];
  return result;
}

/// dF with the volume change of F-bar: the dim x dim part of dF times the factor of the particle. Without factors, dF
/// does not change.
template <int dim>
KEDGE_FUNCTION Eigen::Matrix3d stretch(Eigen::Matrix3d f, const View<double*>& factor, const unsigned int p)
{
  if (factor.extent(0) > 0)
    for (int i = 0; i < dim; ++i)
      for (int j = 0; j < dim; ++j)
        f(i, j) *= factor(p);
  return f;
}

/// Reads row p of a view of symmetric tensors; set_row() writes it.
KEDGE_FUNCTION SymmetricTensor row_of(const View<double* [6]>& view, const unsigned int p)
{
  SymmetricTensor s;
  for (int i = 0; i < 6; ++i)
    s[i] = view(p, i);
  return s;
}

KEDGE_FUNCTION void set_row(const View<double* [6]>& view, const unsigned int p, const SymmetricTensor& s)
{
  for (int i = 0; i < 6; ++i)
    view(p, i) = s[i];
}

/// The same for full 3 x 3 tensors, column by column.
KEDGE_FUNCTION Eigen::Matrix3d matrix_of(const View<double* [9]>& view, const unsigned int p)
{
  Eigen::Matrix3d m;
  for (int i = 0; i < 9; ++i)
    m(i % 3, i / 3) = view(p, i);
  return m;
}

KEDGE_FUNCTION void set_matrix(const View<double* [9]>& view, const unsigned int p, const Eigen::Matrix3d& m)
{
  for (int i = 0; i < 9; ++i)
    view(p, i) = m(i % 3, i / 3);
}

/// Volume over which the stress of particle p is integrated, at the scale of V0, m3 (2-D: m2).
KEDGE_FUNCTION double integration_volume(const ParticleArrays& particles, const StencilSet& stencils,
                                         const unsigned int p)
{
  return particles.initial_volume(p) * stencils.volume_factor(p);
}

/// Adds V tau grad_x S of particle p, V its integration volume, for its Kirchhoff stress (Pa): tau grad_x S = (tau
/// dF^-T) grad S. `to_start` is dF^-1.
template <int dim>
KEDGE_FUNCTION void add_internal_force(const ParticleArrays& particles, const StencilSet& stencils,
                                       const unsigned int p, const SymmetricTensor& stress,
                                       const Eigen::Matrix3d& to_start, const View<double*>& force)
{
  const Eigen::Matrix3d flux = integration_volume(particles, stencils, p) * full_matrix(stress) * to_start.transpose();
  const ParticleNodes at = nodes_of(stencils, p);
  const double* gradient = &stencils.gradient(dim * stencils.value_begin(p));
  for (unsigned int v = 0; v < at.n; ++v)
    for (int c = 0; c < dim; ++c)
    {
      double f = 0.;
      for (int j = 0; j < dim; ++j)
        f += flux(c, j) * gradient[dim * v + j];
      add_to(force(static_cast<std::size_t>(dim) * at.node[v] + c), f);
    }
}

/// Adds m S_v q of particle p to the nodes that it sees; q has dim components.
KEDGE_FUNCTION void add_weighted_by_mass(const ParticleArrays& particles, const StencilSet& stencils,
                                         const unsigned int dim, const unsigned int p, const double* q,
                                         const View<double*>& nodal)
{
  const ParticleNodes at = nodes_of(stencils, p);
  for (unsigned int v = 0; v < at.n; ++v)
    for (unsigned int c = 0; c < dim; ++c)
      add_to(nodal(static_cast<std::size_t>(dim) * at.node[v] + c), particles.mass(p) * at.value[v] * q[c]);
}
} // namespace kedge
