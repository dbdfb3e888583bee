// Size and deformation of a particle's domain, from its properties.
#pragma once

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <kedge/particles/fields.h>

namespace kedge
{
/// Bounds on the volume of a particle over its initial one: on what F tells and on the elastic part of it.
constexpr double least_volume_ratio = 0.1, largest_volume_ratio = 10.;
/// Bounds on the stretch of a domain along an axis.
constexpr double least_stretch = 0.1, largest_stretch = 1.99;
/// Bound on the volume of a domain that follows the flow over the particle's initial one, unless stress holds it there.
constexpr double largest_flow_volume = 1.5;

/// m3 (2-D: m2).
template <int dim> double domain_volume(const double* data)
{
  double volume = 1.;
  for (unsigned int d = 0; d < dim; ++d)
    volume *= 2. * data[field::half_width + d];
  return volume;
}

/// Geometric mean of the edges, m.
template <int dim> double domain_width(const double* data) { return std::pow(domain_volume<dim>(data), 1. / dim); }

/// The axes, by bits, along which the domain is wider than this, m.
template <int dim> unsigned int axes_wider_than(const double* data, const double width)
{
  unsigned int axes = 0;
  for (unsigned int d = 0; d < dim; ++d)
    axes |= unsigned(2. * data[field::half_width + d] > width) << d;
  return axes;
}

/// Takes from F what is more than the largest volume; in plane strain within the plane. Soil without stress opens
/// without limit, and F, which no stress depends on, then only counts what its voids have taken.
template <int dim> void bound_volume(double* data)
{
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> F(data + field::deformation_gradient);
  if (const double ratio = F.determinant(); ratio > largest_volume_ratio)
    F.template topLeftCorner<dim, dim>() *= std::pow(largest_volume_ratio / ratio, 1. / dim);
}

/// Lets the domain follow an increment of the deformation: its second moments along the axes become those of the
/// deformed box, l_i^2 = sum_j (dF_ij l_j)^2, and its volume V0 J of the new F: what is integrated is then what the
/// cells hold. Soil that has opened without stress counts only up to a bound, for its voids hold none. Soil that is
/// pulled apart along an axis leaves no gaps between its domains; shear and rotation leave them as they are. dF is
/// row-major, 3 x 3.
template <int dim> void follow_flow(double* data, const double* dF)
{
  double width[dim], volume = 1.;
  for (unsigned int i = 0; i < dim; ++i)
  {
    double square = 0.;
    for (unsigned int j = 0; j < dim; ++j)
      square += dF[3 * i + j] * dF[3 * i + j] * data[field::half_width + j] * data[field::half_width + j];
    width[i] = std::max(std::sqrt(square), least_stretch * data[field::initial_half_width + i]);
    volume *= 2. * width[i];
  }
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> F(data + field::deformation_gradient);
  const double* strain = data + field::elastic_strain;
  const double largest = std::max(largest_flow_volume, std::exp(strain[0] + strain[1] + strain[2]));
  const double aim = data[field::initial_volume] * std::clamp(F.determinant(), least_volume_ratio, largest);
  for (unsigned int i = 0; i < dim; ++i)
    data[field::half_width + i] = width[i] * std::pow(aim / volume, 1. / dim);
}

/// Stretches the domain by the diagonal of the right stretch tensor U of F = R U, as Coombs et al. (2020) advise: a
/// rotation leaves it as it is.
template <int dim> void stretch_domain(double* data)
{
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> F(data + field::deformation_gradient);
  const Eigen::Matrix3d C = F.transpose() * F;
  const Eigen::Matrix3d U = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(C).operatorSqrt();
  for (unsigned int d = 0; d < dim; ++d)
    data[field::half_width + d] =
        data[field::initial_half_width + d] * std::clamp(U(d, d), least_stretch, largest_stretch);
}
} // namespace kedge
