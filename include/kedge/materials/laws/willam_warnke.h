// A cone with the smooth deviatoric section of Willam and Warnke.
#pragma once

#include <kedge/materials/cone.h>
#include <kedge/materials/friction.h>

namespace kedge
{
/// f = rho - r(theta) tan(phi) (xi_c - xi), xi_c = sqrt(3) c cot(phi), with Willam & Warnke's (1975, IABSE reports 19)
/// elliptic section r between e = (3 - sin(phi)) / (3 + sin(phi)) on the extension meridian (theta = 0) and 1 on the
/// compression meridian (theta = 60 degrees). Flow from g = rho + tan(psi) xi, a circular section, so that the law is
/// not associated even where psi = phi.
/// In triaxial compression it is stronger than Mohr-Coulomb: by 2 % at phi = 30 degrees, by 9 % at 40 (c = 0).
struct WillamWarnke
{
  static constexpr const char* name = "willam warnke";
  static constexpr std::array keys = {&law_keys::friction_angle, &law_keys::dilation_angle, &law_keys::cohesion};
  static constexpr std::array<StateVariable, 0> state_variables = {};

  double slope = unset; ///< tan(phi)
  double eccentricity = unset;
  double dilatancy = unset; ///< tan(psi)
  double cohesion = unset;  ///< Pa

  static WillamWarnke make(const LawConstants& constants)
  {
    const double friction = constants[law_keys::friction_angle];
    const double sine = sine_of_degrees(friction);
    return {tangent_of_degrees(friction), (3. - sine) / (3. + sine),
            tangent_of_degrees(constants[law_keys::dilation_angle]), constants[law_keys::cohesion]};
  }

  static void check(const LawConstants& constants, const Refuse& refuse)
  {
    check_dilation(constants, refuse);
    if (constants[law_keys::friction_angle] == 0.)
      refuse(law_keys::friction_angle, "expected a number above 0 (degrees), found 0",
             "the cone needs a slope; use \"von mises\" for a soil without friction");
  }

  struct Section
  {
    double radius;
    double derivative; ///< d radius / d theta
  };

  /// The section at the Lode angle theta in [0, 60] degrees, given by its cosine and sine.
  KEDGE_FUNCTION Section section(const double cos_theta, const double sin_theta) const
  {
    const double e = eccentricity, w = 2. * e - 1., a = 4. * (1. - e * e);
    const double root = std::sqrt(a * cos_theta * cos_theta + e * (5. * e - 4.));
    const double numerator = 0.5 * a * cos_theta + w * root;
    const double denominator = a * cos_theta * cos_theta + w * w;
    const double d_numerator = 0.5 * a + w * a * cos_theta / root;
    const double d_denominator = 2. * a * cos_theta;
    const double radius = numerator / denominator;
    return {radius, -sin_theta * (d_numerator - radius * d_denominator) / denominator};
  }

  template <bool with_tangent>
  KEDGE_FUNCTION Response respond(const Eigen::Vector3d& trial_strain, const MaterialPoint& point,
                                  const HenckyElasticity& elasticity, double*) const
  {
    constexpr double sqrt3 = 1.7320508075688772;
    const double x = trial_strain[0], y = trial_strain[1], z = trial_strain[2];
    const double high = std::fmax(x, std::fmax(y, z)), low = std::fmin(x, std::fmin(y, z));
    const double middle = std::fmax(std::fmin(x, y), std::fmin(std::fmax(x, y), z));
    // theta from differences of the principal values: an arc cosine would lose half the digits on the meridians.
    const double along = ((high - middle) + (high - low)) / sqrt3, across = middle - low;
    const double length = std::sqrt(along * along + across * across);
    const double cos_theta = length > 0. ? std::fmin(1., std::fmax(0.5, along / length)) : 1.;
    const double sin_theta = length > 0. ? across / length : 0.;
    const Section here = section(cos_theta, sin_theta);
    // theta runs against the screw about (1, 1, 1) in every second of the six sectors.
    const double sense = (x - y) * (y - z) * (x - z) >= 0. ? 1. : -1.;

    const double intercept = sqrt3 * effective_cohesion(cohesion, point.young);
    return Cone{slope, intercept, dilatancy, here.radius, sense * here.derivative, 0.}.respond<with_tangent>(
        trial_strain, elasticity);
  }
};
} // namespace kedge
