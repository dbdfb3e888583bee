#include <cmath>
#include <kedge/assembly/kernels.h>
#include <kedge/assembly/unseen_velocity.h>

namespace kedge
{
namespace
{
/// Least volume that the places of a particle's nodes span, over that of the nodes themselves, and the largest sum of
/// the sizes of weights: those of S have the sum one.
constexpr double least_span = 0.1, most_weight = 2.;

KEDGE_FUNCTION double invert(const Eigen::Matrix<double, 2, 2>& m, Eigen::Matrix<double, 2, 2>& inverted)
{
  const double det = m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0);
  inverted(0, 0) = m(1, 1) / det;
  inverted(0, 1) = -m(0, 1) / det;
  inverted(1, 0) = -m(1, 0) / det;
  inverted(1, 1) = m(0, 0) / det;
  return det;
}

KEDGE_FUNCTION double invert(const Eigen::Matrix3d& m, Eigen::Matrix3d& inverted)
{
  inverted = inverse(m);
  return determinant(m);
}

/// The weights r_v = S_v + c.grad S_v of a particle, for one component.
template <int dim> struct LinearWeights
{
  ParticleNodes at;
  const double* gradient;
  double c[dim];
  bool exist;

  /// A field a + b.x has the values a + b.x_v at the places x_v, so sum(value grad S) = X^T b, X = sum(x_v (x) grad S).
  KEDGE_FUNCTION LinearWeights(const StencilSet& stencils, const NodalPlaces& places, const unsigned int p, const int d)
      : at(nodes_of(stencils, p)), gradient(&stencils.gradient(dim * stencils.value_begin(p)))
  {
    Eigen::Matrix<double, dim, dim> X = Eigen::Matrix<double, dim, dim>::Zero(), inverse_X;
    double distance[dim], slope_without_mass = 0.;
    for (int i = 0; i < dim; ++i)
      distance[i] = places.particles(p, i);
    for (unsigned int v = 0; v < at.n; ++v)
    {
      const std::size_t first = std::size_t(dim) * at.node[v];
      const NodalVector& place = std::isinf(places.inertia(first + d)) ? places.node : places.centre;
      for (int i = 0; i < dim; ++i)
      {
        distance[i] -= at.value[v] * place(first + i);
        for (int j = 0; j < dim; ++j)
          X(i, j) += place(first + i) * gradient[dim * v + j];
        if (!(places.mass(at.node[v]) > 0.)) // it has no value
          slope_without_mass += std::fabs(gradient[dim * v + i]);
      }
    }
    exist = invert(X, inverse_X) > least_span && slope_without_mass == 0.;
    for (int j = 0; j < dim; ++j)
    {
      c[j] = 0.;
      for (int i = 0; i < dim; ++i)
        c[j] += inverse_X(j, i) * distance[i];
    }
    double sum = 0.;
    for (unsigned int v = 0; v < at.n; ++v)
      sum += std::fabs(of(v));
    exist = exist && sum < most_weight;
  }

  KEDGE_FUNCTION double of(const unsigned int v) const
  {
    double weight = at.value[v];
    for (int j = 0; j < dim; ++j)
      weight += c[j] * gradient[dim * v + j];
    return weight;
  }
};
} // namespace

template <int dim>
void take_seen_part(const StencilSet& stencils, const NodalPlaces& places, const NodalVector& nodal,
                    const View<double* [3]>& quantity)
{
  Kokkos::parallel_for(
      "take seen part", Kokkos::RangePolicy<ExecutionSpace>(0, stencils.n_particles),
      KOKKOS_LAMBDA(const unsigned int p) {
        for (int d = 0; d < dim; ++d)
        {
          const LinearWeights<dim> weights(stencils, places, p, d);
          double unseen = quantity(p, d);
          for (unsigned int v = 0; v < weights.at.n; ++v)
            unseen -= weights.of(v) * nodal(std::size_t(dim) * weights.at.node[v] + d);
          quantity(p, d) = weights.exist ? unseen : 0.;
        }
      });
}

template <int dim>
void add_seen_part(const ParticleArrays& particles, const StencilSet& stencils, const NodalPlaces& places,
                   const View<double* [3]>& quantity, const NodalVector& nodal)
{
  Kokkos::parallel_for(
      "add seen part", Kokkos::RangePolicy<ExecutionSpace>(0, stencils.n_particles),
      KOKKOS_LAMBDA(const unsigned int p) {
        for (int d = 0; d < dim; ++d)
        {
          const LinearWeights<dim> weights(stencils, places, p, d);
          for (unsigned int v = 0; v < weights.at.n && weights.exist; ++v)
            add_to(nodal(std::size_t(dim) * weights.at.node[v] + d),
                   particles.mass(p) * weights.of(v) * quantity(p, d));
        }
      });
}

#define KEDGE_INSTANTIATE(dim)                                                                                         \
  template void take_seen_part<dim>(const StencilSet&, const NodalPlaces&, const NodalVector&,                         \
                                    const View<double* [3]>&);                                                         \
  template void add_seen_part<dim>(const ParticleArrays&, const StencilSet&, const NodalPlaces&,                       \
                                   const View<double* [3]>&, const NodalVector&);
KEDGE_INSTANTIATE(2)
KEDGE_INSTANTIATE(3)
} // namespace kedge
