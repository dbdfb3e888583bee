#include <Eigen/Eigenvalues>
#include <KokkosBlas1_axpby.hpp>
#include <KokkosBlas1_dot.hpp>
#include <KokkosBlas1_mult.hpp>
#include <KokkosBlas1_scal.hpp>
#include <algorithm>
#include <cmath>
#include <kedge/assembly/highest_frequency.h>
#include <kedge/assembly/kernels.h>
#include <kedge/base/communication.h>

namespace kedge
{
namespace
{
using Policy = Kokkos::RangePolicy<ExecutionSpace>;

constexpr int fewest_products = 8, most_products = 24;
/// Residual of the largest Ritz value at which it counts as found, as a share of it, and what is added to both.
constexpr double accuracy = 0.05, margin = 0.05;
/// What is left of a vector that is nothing but round-off, over the largest Ritz value: all frequencies are found.
constexpr double nothing_left = 1e-6;

/// Elastic stiffness of a particle over that of soil without stress. Under uniaxial pressure it is that of M (1 - ln J)
/// instead of the constrained modulus M, since forces act on areas that shrink.
KEDGE_FUNCTION double stiffening(const ParticleArrays& particles, const unsigned int p,
                                 const HenckyElasticity& elasticity)
{
  const SymmetricTensor s = row_of(particles.trial_stress, p);
  const double xy = std::fabs(s[3]), yz = std::fabs(s[4]), xz = std::fabs(s[5]);
  const double pressure =
      std::fmax(std::fmax(xy + xz - s[0], xy + yz - s[1]), xz + yz - s[2]); // a bound of the largest
  return 1. + std::fmax(0., pressure) / (elasticity.lame + 2. * elasticity.shear);
}

/// Adds the internal force of every particle for the elastic stress of nodal displacements.
template <int dim>
void add_elastic_force(const ElasticSoil& soil, const NodalVector& displacement, const NodalVector& force)
{
  const ParticleArrays particles = soil.particles;
  const StencilSet stencils = soil.stencils;
  const Materials materials = soil.materials;
  Kokkos::parallel_for(
      "elastic force", Policy(0, particles.n), KOKKOS_LAMBDA(const unsigned int p) {
        const HenckyElasticity elasticity = materials(particles.layer(p)).elasticity(particles.young(p));
        typename Lanes<dim>::Type H[dim];
        displacement_gradient<dim>(stencils, displacement, p, H);
        SymmetricTensor stress = SymmetricTensor::Zero();
        double dilation = 0.;
        for (int i = 0; i < dim; ++i)
        {
          constexpr int entry[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};
          dilation += H[i][i];
          for (int j = 0; j <= i; ++j)
            stress[entry[i][j]] = elasticity.shear * (H[i][j] + H[j][i]);
        }
        stress.head<3>().array() += elasticity.lame * dilation;
        stress *= stiffening(particles, p, elasticity);
        add_internal_force<dim>(particles, stencils, p, stress, Eigen::Matrix3d::Identity(), force);
      });
}

/// Adds what the springs hold against nodal displacements.
template <int dim> void add_springs(const ElasticSoil& soil, const NodalVector& displacement, const NodalVector& force)
{
  const PointForces points = soil.points;
  const View<double*> stiffness = soil.stiffness;
  Kokkos::parallel_for(
      "springs", Policy(0, points.n()), KOKKOS_LAMBDA(const std::size_t i) {
        for (int d = 0; d < dim; ++d)
        {
          double stretch = 0.;
          for (unsigned int v = points.begin(i); v < points.begin(i + 1); ++v)
            stretch += points.weights(v) * displacement(std::size_t(dim) * points.nodes(v) + d);
          for (unsigned int v = points.begin(i); v < points.begin(i + 1); ++v)
            add_to(force(std::size_t(dim) * points.nodes(v) + d), stiffness(i) * points.weights(v) * stretch);
        }
      });
}

/// 1 / sqrt(inertia)
NodalVector inverse_roots(const NodalVector& inertia)
{
  const NodalVector roots(Kokkos::view_alloc("inverse roots", Kokkos::WithoutInitializing), inertia.extent(0));
  Kokkos::parallel_for(
      "inverse roots", Policy(0, inertia.extent(0)),
      KOKKOS_LAMBDA(const std::size_t i) { roots(i) = 1. / std::sqrt(inertia(i)); });
  return roots;
}

/// Sum over the dofs of all ranks.
double dot(const ElasticSoil& soil, const NodalVector& a, const NodalVector& b)
{
  const auto owned = std::make_pair(std::size_t(0), soil.n_owned);
  return sum_over_ranks(KokkosBlas::dot(Kokkos::subview(a, owned), Kokkos::subview(b, owned)), soil.communicator);
}
} // namespace

double bound_squared_frequency(const ParticleArrays& particles, const StencilSet& stencils, const Materials& materials,
                               const double least_share)
{
  double largest = 0.;
  const unsigned int dim = stencils.dim;
  Kokkos::parallel_reduce(
      "stable step", Policy(0, particles.n),
      KOKKOS_LAMBDA(const unsigned int p, double& most) {
        const HenckyElasticity elasticity = materials(particles.layer(p)).elasticity(particles.young(p));
        const ParticleNodes at = nodes_of(stencils, p);
        const double* gradient = &stencils.gradient(dim * stencils.value_begin(p));
        double G[3][3] = {};
        for (unsigned int v = 0; v < at.n; ++v)
          if (at.value[v] > 0.)
            for (unsigned int i = 0; i < dim; ++i)
              for (unsigned int j = 0; j < dim; ++j)
                G[i][j] += gradient[dim * v + i] * gradient[dim * v + j] / std::fmax(at.value[v], least_share);
        double row_sum = 0.; // bounds the largest eigenvalue from above
        for (unsigned int i = 0; i < dim; ++i)
          row_sum = std::fmax(row_sum, std::fabs(G[i][0]) + std::fabs(G[i][1]) + std::fabs(G[i][2]));
        const double stiffness =
            std::fmax(3. * elasticity.bulk(), 2. * elasticity.shear) * stiffening(particles, p, elasticity);
        const double rate = integration_volume(particles, stencils, p) * stiffness / particles.mass(p) * row_sum;
        most = std::fmax(most, rate);
      },
      Kokkos::Max<double>(largest));
  return largest;
}

template <int dim> double find_squared_frequency(const ElasticSoil& soil, const double bound)
{
  const NodalVector roots = inverse_roots(soil.inertia);
  const NodalVector force = soil.exchange.make_nodal_vector(), moved = soil.exchange.make_nodal_vector();
  NodalVector x = soil.exchange.make_nodal_vector(), before = soil.exchange.make_nodal_vector();
  const auto host = make_mirror(x);
  std::copy(soil.start.begin(), soil.start.end(), host.data());
  Kokkos::deep_copy(moved, host);
  // where a dof is held its root is 0, and so is the vector from here on
  Kokkos::parallel_for(
      "leave out held dofs", Policy(0, x.extent(0)),
      KOKKOS_LAMBDA(const std::size_t i) { x(i) = roots(i) > 0. ? moved(i) : 0.; });

  Eigen::VectorXd diagonal(most_products), beside(most_products);
  double length = std::sqrt(dot(soil, x, x)), found = 0.;
  for (int k = 0; k < most_products && length > 0.; ++k)
  {
    KokkosBlas::scal(x, 1. / length, x);
    KokkosBlas::mult(0., moved, 1., roots, x);
    Kokkos::deep_copy(force, 0.);
    add_elastic_force<dim>(soil, moved, force);
    add_springs<dim>(soil, moved, force);
    soil.exchange.sum_over_ranks(force);
    KokkosBlas::mult(0., force, 1., roots, force);
    diagonal[k] = dot(soil, x, force);
    KokkosBlas::axpy(-diagonal[k], x, force);
    if (k > 0)
      KokkosBlas::axpy(-beside[k - 1], before, force);
    beside[k] = length = std::sqrt(dot(soil, force, force));
    std::swap(before, x);
    Kokkos::deep_copy(x, force);

    // Of numbers near 1, for the solver takes large ones for ever.
    const double unit = diagonal.head(k + 1).maxCoeff();
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ritz;
    if (unit > 0.)
      ritz.computeFromTridiagonal(diagonal.head(k + 1) / unit, beside.head(k) / unit);
    if (!(unit > 0.) || ritz.info() != Eigen::Success)
      return bound;
    const double largest = unit * ritz.eigenvalues()[k], residual = length * std::abs(ritz.eigenvectors()(k, k));
    found = (1. + margin) * (largest + residual);
    if (length <= nothing_left * largest || (k + 1 >= fewest_products && residual <= accuracy * largest))
      break;
  }
  return found > 0. ? std::min(found, bound) : bound;
}

template double find_squared_frequency<2>(const ElasticSoil&, double);
template double find_squared_frequency<3>(const ElasticSoil&, double);
} // namespace kedge
