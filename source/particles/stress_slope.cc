#include "stress_slope.h"
#include <algorithm>
#include <kedge/materials/tensors.h>

namespace kedge
{
namespace
{
/// Least standard deviation of positions along an axis, in cells, that tells how something changes along it. It is 1/4
/// for two rows of particles.
constexpr double least_spread = 0.1;

/// What the law may take away of the differences between children: up to the first number they have all of them, from
/// the second on none.
constexpr double accepted = 0.1, refused = 0.5;
} // namespace

template <int dim> void StressFit<dim>::add(const std::array<double, dim>& position, const double* data)
{
  const Eigen::Map<const Vector> x(position.data());
  if (volume == 0.)
    origin = x; // moments about a point nearby lose no digits
  const double weight = data[field::initial_volume];
  const Eigen::Map<const SymmetricTensor> tau(data + field::stress);
  volume += weight;
  first += weight * (x - origin);
  second += weight * (x - origin) * (x - origin).transpose();
  stress += weight * tau;
  moment += weight * tau * (x - origin).transpose();
}

template <int dim> StressSlope<dim> StressFit<dim>::slope(const double cell_size) const
{
  StressSlope<dim> result = StressSlope<dim>::Zero();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, dim, dim>> spread(
      second / volume - first * first.transpose() / (volume * volume));
  const StressSlope<dim> covariance = moment / volume - stress * first.transpose() / (volume * volume);
  for (int d = 0; d < dim; ++d)
  {
    const Vector axis = spread.eigenvectors().col(d);
    if (const double square = spread.eigenvalues()[d]; square > std::pow(least_spread * cell_size, 2))
      result += covariance * axis * axis.transpose() / square;
  }
  return result;
}

template <int dim>
void add_slope(const StressSlope<dim>& slope, const Eigen::Vector3d& offset, const Material& material, double* data)
{
  const SymmetricTensor change = slope * offset.head<dim>();
  const HenckyElasticity elasticity = material.elasticity(data[field::young]);
  const double mean = (change[0] + change[1] + change[2]) / 3.;
  for (int i = 0; i < 6; ++i)
  {
    const double pressure = i < 3 ? mean : 0.;
    data[field::stress + i] += change[i];
    data[field::elastic_strain + i] +=
        (change[i] - pressure) / (2. * elasticity.shear) + pressure / (3. * elasticity.bulk());
  }
}

template <int dim>
double bearable_share(const StressSlope<dim>& slope, const Eigen::Vector3d& distance, const Material& material,
                      const double cell_size, const double* data)
{
  double worst = 0.;
  for (unsigned int octant = 0; octant < (1u << dim); ++octant)
  {
    Eigen::Vector3d offset = distance;
    for (int d = 0; d < dim; ++d)
      offset[d] *= (octant >> d) & 1u ? 1. : -1.;
    std::array<double, field::count> child;
    std::copy_n(data, child.size(), child.begin());
    add_slope<dim>(slope, offset, material, child.data());
    const Eigen::Map<const SymmetricTensor> strain(child.data() + field::elastic_strain);
    double state[Laws::max_state];
    std::copy_n(data + field::law_state, Laws::max_state, state);
    const StressUpdate borne = update_stress(Eigen::Matrix3d::Identity(), left_cauchy_green(strain),
                                             {child[field::young], cell_size, state}, material, state);
    const Eigen::Map<const SymmetricTensor> parent(data + field::stress), wanted(child.data() + field::stress);
    if (const double change = (wanted - parent).norm(); change > 0.)
      worst = std::fmax(worst, (borne.stress - wanted).norm() / change);
  }
  return std::clamp((refused - worst) / (refused - accepted), 0., 1.);
}

#define KEDGE_INSTANTIATE(dim)                                                                                         \
  template class StressFit<dim>;                                                                                       \
  template void add_slope<dim>(const StressSlope<dim>&, const Eigen::Vector3d&, const Material&, double*);             \
  template double bearable_share<dim>(const StressSlope<dim>&, const Eigen::Vector3d&, const Material&, double,        \
                                      const double*);
KEDGE_INSTANTIATE(2)
KEDGE_INSTANTIATE(3)
} // namespace kedge
