// Small pieces that several kernels use.
#pragma once

#include <Eigen/Core>
#include <kedge/assembly/node_graph.h>
#include <kedge/base/kokkos.h>
#include <kedge/basis/stencil.h>
#include <kedge/materials/hencky.h>
#include <kedge/particles/arrays.h>
#include <type_traits>

namespace kedge
{
/// Sums that several threads may address; the serial back end needs no atomic.
KEDGE_FUNCTION void add_to(double& target, const double value)
{
#ifdef KOKKOS_ENABLE_SERIAL
  if constexpr (std::is_same<ExecutionSpace, Kokkos::Serial>::value)
  {
    target += value;
    return;
  }
#endif
  Kokkos::atomic_add(&target, value);
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

/// Entry of a column in its row, which holds it.
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

/// dF = 1 + sum over nodes of d_v (x) grad S_v of particle p.
template <int dim>
KEDGE_FUNCTION Eigen::Matrix3d deformation_increment(const StencilSet& stencils, const View<double*>& increment,
                                                     const unsigned int p)
{
  const unsigned int pattern = stencils.pattern_of_particle(p);
  const unsigned int first = stencils.pattern_node_begin(pattern);
  const unsigned int n = stencils.pattern_node_begin(pattern + 1) - first;
  const double* gradient = &stencils.gradient(dim * stencils.value_begin(p));
  double f[dim][dim] = {};
  for (unsigned int v = 0; v < n; ++v)
  {
    const std::size_t dof = static_cast<std::size_t>(dim) * stencils.pattern_nodes(first + v);
    for (int i = 0; i < dim; ++i)
      for (int j = 0; j < dim; ++j)
        f[i][j] += increment(dof + i) * gradient[dim * v + j];
  }
  Eigen::Matrix3d result = Eigen::Matrix3d::Identity();
  for (int i = 0; i < dim; ++i)
    for (int j = 0; j < dim; ++j)
      result(i, j) += f[i][j];
  return result;
}

/// dF with the volume that F-bar gives it: its part in space, or in the plane, times the particle's factor. Without
/// factors dF as it is.
template <int dim>
KEDGE_FUNCTION Eigen::Matrix3d stretch(Eigen::Matrix3d f, const View<double*>& factor, const unsigned int p)
{
  if (factor.extent(0) > 0)
    for (int i = 0; i < dim; ++i)
      for (int j = 0; j < dim; ++j)
        f(i, j) *= factor(p);
  return f;
}

KEDGE_FUNCTION Eigen::Matrix3d inverse(const Eigen::Matrix3d& f)
{
  Eigen::Matrix3d c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
    {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      c(j, i) = f(i1, j1) * f(i2, j2) - f(i1, j2) * f(i2, j1);
    }
  return c * (1. / (f(0, 0) * c(0, 0) + f(0, 1) * c(1, 0) + f(0, 2) * c(2, 0)));
}

/// Row p of a view of symmetric tensors, and its replacement.
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

/// Adds V0 tau grad_x S of particle p for its Kirchhoff stress (Pa), where tau grad_x S = (tau dF^-T) grad S with the
/// inverse of dF, `to_start`.
template <int dim>
KEDGE_FUNCTION void add_internal_force(const ParticleArrays& particles, const StencilSet& stencils,
                                       const unsigned int p, const SymmetricTensor& stress,
                                       const Eigen::Matrix3d& to_start, const View<double*>& force)
{
  const Eigen::Matrix3d flux = particles.initial_volume(p) * full_matrix(stress) * to_start.transpose();
  const unsigned int pattern = stencils.pattern_of_particle(p);
  const unsigned int first = stencils.pattern_node_begin(pattern);
  const unsigned int n = stencils.pattern_node_begin(pattern + 1) - first;
  const double* gradient = &stencils.gradient(dim * stencils.value_begin(p));
  for (unsigned int v = 0; v < n; ++v)
    for (int c = 0; c < dim; ++c)
    {
      double f = 0.;
      for (int j = 0; j < dim; ++j)
        f += flux(c, j) * gradient[dim * v + j];
      add_to(force(static_cast<std::size_t>(dim) * stencils.pattern_nodes(first + v) + c), f);
    }
}
} // namespace kedge
