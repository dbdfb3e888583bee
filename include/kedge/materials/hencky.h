// Logarithmic (Hencky) strain, the principal frame and isotropic elasticity in it.
#pragma once

#include <cmath>
#include <kedge/materials/tensors.h>

namespace kedge
{
/// Eigenvalues in no particular order; the columns of the proper rotation `directions` are the eigenvectors.
struct PrincipalFrame
{
  Eigen::Vector3d values;
  Eigen::Matrix3d directions;
};

/// Largest root in magnitude, sqrt(3) <= x <= 2, of x^3 - 3 x - 2 h = 0 for 0 <= h <= 1: the scaled characteristic
/// polynomial of a deviator. Unlike the other two roots this one is well conditioned for every h.
KEDGE_FUNCTION double isolated_root(const double h)
{
  // The parabola is exact at both ends; each Newton step squares its error of 2e-3.
  double x = 1.7320508075688772 + h * (1. / 3. - 0.0653841409022105 * h);
  for (int i = 0; i < 3; ++i)
    x -= (x * (x * x - 3.) - 2. * h) / (3. * (x * x - 1.));
  return x;
}

/// Eigenvalues and eigenvectors of a symmetric tensor, to round-off of its largest entry, equal eigenvalues included.
///
/// Without iteration to convergence: the eigenvalue farthest from the others is a well-conditioned root of the
/// characteristic polynomial of the deviator, its eigenvector a column of the adjugate, and what is left is the 2x2
/// problem in the plane across it, solved by one Jacobi rotation. The same idea is found in Scherzinger & Dohrmann 2008
/// (Comput. Methods Appl. Mech. Eng. 197). Nor with branches, so that PrincipalFrames finds several at once in vectors.
KOKKOS_FORCEINLINE_FUNCTION PrincipalFrame principal_frame_of(const double (&s)[6])
{
  const double mean = (s[0] + s[1] + s[2]) / 3.;
  // From differences: with s - mean the round-off of the mean would be all the deviator of a nearly isotropic tensor,
  // and that is not traceless.
  const double xy_difference = s[0] - s[1], yz_difference = s[1] - s[2], zx_difference = s[2] - s[0];
  const double dx = (xy_difference - zx_difference) / 3., dy = (yz_difference - xy_difference) / 3.,
               dz = (zx_difference - yz_difference) / 3.;
  const double p =
      std::sqrt((dx * dx + dy * dy + dz * dz + 2. * (s[3] * s[3] + s[4] * s[4] + s[5] * s[5])) * (1. / 6.));
  const bool isotropic = !(p > 1e-150); // squares of less would underflow
  const double scale = 1. / p;
  const double a = dx * scale, b = dy * scale, c = dz * scale;
  const double d = s[3] * scale, e = s[4] * scale, f = s[5] * scale; // xy, yz, xz
  const double half_determinant = 0.5 * (a * (b * c - e * e) - d * (d * c - e * f) + f * (d * e - b * f));
  const double size = std::fabs(half_determinant);
  const double root = std::copysign(isolated_root(size < 1. ? size : 1.), half_determinant);

  // The adjugate of (deviator - root) is a positive multiple of v v^T: its largest column is a safe choice.
  const double ar = a - root, br = b - root, cr = c - root;
  const double xx = br * cr - e * e, yy = ar * cr - f * f, zz = ar * br - d * d;
  const double xy = e * f - d * cr, xz = d * e - f * br, yz = d * f - e * ar;
  const bool first = xx >= yy && xx >= zz, second = yy >= zz;
  double v[3] = {first ? xx : second ? xy : xz, first ? xy : second ? yy : yz, first ? xz : second ? yz : zz};
  const double normalise = 1. / std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  for (double& component : v)
    component *= normalise;

  // Two unit vectors across v without a square root (Duff et al. 2017, J. Comput. Graph. Tech. 6(1)).
  const double sign = std::copysign(1., v[2]);
  const double q = -1. / (sign + v[2]);
  const double r = v[0] * v[1] * q;
  const double g[3] = {1. + sign * v[0] * v[0] * q, sign * r, -sign * v[0]};
  const double h[3] = {r, sign + v[1] * v[1] * q, -v[1]};
  const double dg[3] = {a * g[0] + d * g[1] + f * g[2], d * g[0] + b * g[1] + e * g[2], f * g[0] + e * g[1] + c * g[2]};
  const double dh[3] = {a * h[0] + d * h[1] + f * h[2], d * h[0] + b * h[1] + e * h[2], f * h[0] + e * h[1] + c * h[2]};
  const double gg = g[0] * dg[0] + g[1] * dg[1] + g[2] * dg[2];
  const double gh = g[0] * dh[0] + g[1] * dh[1] + g[2] * dh[2];
  const double hh = h[0] * dh[0] + h[1] * dh[1] + h[2] * dh[2];

  const double half_difference = 0.5 * (gg - hh);
  const double denominator =
      half_difference + std::copysign(std::sqrt(half_difference * half_difference + gh * gh), half_difference);
  const double quotient = gh / denominator, tangent = denominator != 0. ? quotient : 0.;
  const double cosine = 1. / std::sqrt(1. + tangent * tangent), sine = tangent * cosine;

  PrincipalFrame frame;
  frame.values[0] = isotropic ? s[0] : mean + p * (gg + tangent * gh);
  frame.values[1] = isotropic ? s[1] : mean + p * (hh - tangent * gh);
  frame.values[2] = isotropic ? s[2] : mean + p * root;
  for (int i = 0; i < 3; ++i)
  {
    frame.directions(i, 0) = isotropic ? i == 0 : cosine * g[i] + sine * h[i];
    frame.directions(i, 1) = isotropic ? i == 1 : cosine * h[i] - sine * g[i];
    frame.directions(i, 2) = isotropic ? i == 2 : v[i];
  }
  return frame;
}

KEDGE_FUNCTION PrincipalFrame principal_frame(const SymmetricTensor& s)
{
  return principal_frame_of({s[0], s[1], s[2], s[3], s[4], s[5]});
}

/// The same for a tensor without out-of-plane shears: directions 0 and 1 lie in the plane, 2 across it.
KEDGE_FUNCTION PrincipalFrame plane_frame(const SymmetricTensor& s)
{
  const double half_difference = 0.5 * (s[0] - s[1]);
  const double denominator =
      half_difference + std::copysign(std::sqrt(half_difference * half_difference + s[3] * s[3]), half_difference);
  const double tangent = denominator != 0. ? s[3] / denominator : 0.;
  const double cosine = 1. / std::sqrt(1. + tangent * tangent), sine = tangent * cosine;
  PrincipalFrame frame;
  frame.values = Eigen::Vector3d(s[0] + tangent * s[3], s[1] - tangent * s[3], s[2]);
  frame.directions.setZero();
  frame.directions(0, 0) = frame.directions(1, 1) = cosine;
  frame.directions(1, 0) = sine;
  frame.directions(0, 1) = -sine;
  frame.directions(2, 2) = 1.;
  return frame;
}

/// Principal logarithmic strains of a left Cauchy-Green tensor with these principal values.
KEDGE_FUNCTION Eigen::Vector3d principal_strain(const Eigen::Vector3d& values)
{
  return Eigen::Vector3d(0.5 * std::log(values[0]), 0.5 * std::log(values[1]), 0.5 * std::log(values[2]));
}

/// Logarithmic strain 1/2 ln b of a left Cauchy-Green tensor b.
KEDGE_FUNCTION SymmetricTensor logarithmic_strain(const SymmetricTensor& left_cauchy_green)
{
  const PrincipalFrame frame = principal_frame(left_cauchy_green);
  return from_principal(principal_strain(frame.values), frame.directions);
}

/// Left Cauchy-Green tensor b = exp(2 eps) of a logarithmic strain eps.
KEDGE_FUNCTION SymmetricTensor left_cauchy_green(const SymmetricTensor& logarithmic_strain)
{
  const PrincipalFrame frame = principal_frame(logarithmic_strain);
  return from_principal(
      Eigen::Vector3d(std::exp(2. * frame.values[0]), std::exp(2. * frame.values[1]), std::exp(2. * frame.values[2])),
      frame.directions);
}

/// Hencky's law tau = lame tr(eps) 1 + 2 shear eps between Kirchhoff stress and elastic logarithmic strain, in their
/// common principal frame.
struct HenckyElasticity
{
  double lame;  ///< first Lame constant, Pa
  double shear; ///< shear modulus, Pa

  KEDGE_FUNCTION double bulk() const { return lame + 2. / 3. * shear; }

  KEDGE_FUNCTION Eigen::Vector3d stress(const Eigen::Vector3d& strain) const
  {
    const double pressure = lame * (strain[0] + strain[1] + strain[2]);
    return Eigen::Vector3d(pressure + 2. * shear * strain[0], pressure + 2. * shear * strain[1],
                           pressure + 2. * shear * strain[2]);
  }

  KEDGE_FUNCTION Eigen::Vector3d strain(const Eigen::Vector3d& stress) const
  {
    const double mean = (stress[0] + stress[1] + stress[2]) / 3., flexibility = 0.5 / shear;
    const double volumetric = mean / (3. * bulk());
    return Eigen::Vector3d(volumetric + flexibility * (stress[0] - mean), volumetric + flexibility * (stress[1] - mean),
                           volumetric + flexibility * (stress[2] - mean));
  }

  /// d tau_i / d eps_j.
  KEDGE_FUNCTION Eigen::Matrix3d tangent() const
  {
    Eigen::Matrix3d d = Eigen::Matrix3d::Constant(lame);
    for (int i = 0; i < 3; ++i)
      d(i, i) += 2. * shear;
    return d;
  }
};
} // namespace kedge
