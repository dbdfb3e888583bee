// The law of one contact point: penalty in the normal direction, elastic stick and slip by friction and adhesion across
// it, both from where multipliers have brought them.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <kedge/base/kokkos.h>
#include <kedge/bodies/interface.h>

namespace kedge
{
struct ContactStiffness
{
  double normal, tangential; ///< N/m
  double friction;           ///< Coulomb coefficient
  double adhesion = 0.;      ///< N: adhesion times the area that the corner stands for
  TangentialLimit limit = TangentialLimit::friction;
};

KEDGE_FUNCTION double stiffest(const ContactStiffness& stiffness)
{
  return stiffness.normal > stiffness.tangential ? stiffness.normal : stiffness.tangential;
}

/// Where a soil point is relative to a body, and how it got there.
struct ContactGeometry
{
  double gap;              ///< signed distance less the reference gap, m; negative: penetration
  Eigen::Vector3d normal;  ///< unit, out of the body
  double steepness = 1.;   ///< d gap / d soil point = steepness * normal
  Eigen::Matrix3d turning; ///< d normal / d soil point, 1/m: zero on a face
  Eigen::Vector3d slip;    ///< displacement of the soil point relative to the body in this step, m
};

/// Forces act on the soil, N.
struct ContactResponse
{
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d tangential = Eigen::Vector3d::Zero(); ///< tangential part, the history of the next step
  Eigen::Matrix3d tangent = Eigen::Matrix3d::Zero();    ///< d force / d soil point, N/m
  Eigen::Vector3d by_gap = Eigen::Vector3d::Zero();     ///< d force / d gap, the place being held, N/m
  bool active = false, sliding = false;
};

/// Largest tangential force, and how it grows with the pressure.
struct SlipLimit
{
  double force; ///< N
  double slope; ///< d force / d pressure
};

/// Pressure over adhesion from which on their sum has all of the adhesion.
constexpr double full_adhesion = 0.1;

/// With the pressure p (N; negative: tension), p+ = max(p, 0), friction coefficient mu and adhesion a A (N):
///   friction  mu p+             (Coulomb)
///   smaller   min(mu p+, a A)   (undrained clay: Rowe & Davis 1982, doi 10.1680/geot.1982.32.1.9)
///   sum       a A + mu p+       (Potyondy 1961, doi 10.1680/geot.1961.11.4.339)
/// A bonded point has the adhesion at any pressure: "smaller" is a A there. Any other carries nothing at p <= 0, and
/// "sum" rises from there to its value at p = a A / 10: if it fell from a A to zero at once, no force would balance a
/// body that comes off soil which it has sheared.
KEDGE_FUNCTION SlipLimit slip_limit(const ContactStiffness& stiffness, const double pressure, const bool bonded)
{
  const SlipLimit friction =
      pressure > 0. ? SlipLimit{stiffness.friction * pressure, stiffness.friction} : SlipLimit{0., 0.};
  switch (stiffness.limit)
  {
    case TangentialLimit::friction:
      return friction;
    case TangentialLimit::smaller:
      return bonded || friction.force > stiffness.adhesion ? SlipLimit{stiffness.adhesion, 0.} : friction;
    case TangentialLimit::sum:
      if (!bonded && pressure < full_adhesion * stiffness.adhesion)
      {
        const double slope = 1. / full_adhesion + stiffness.friction;
        return pressure > 0. ? SlipLimit{slope * pressure, slope} : SlipLimit{0., 0.};
      }
      return {stiffness.adhesion + friction.force, friction.slope};
  }
  return {0., 0.}; // no other limit exists
}

/// Share of the slip limit within which a point counts as sliding in the tangent; its force is continuous. A point
/// that has slid lies on the limit when the next step begins: without this round-off, and so the number of ranks, would
/// choose its side and with it Newton's path.
constexpr double on_the_limit = 1e-6;

/// Return mapping on the tangential force (Wriggers 2006, Computational Contact Mechanics, ch. 5; Bird et al. 2025,
/// arXiv:2412.01565). `previous` is the tangential force at the start of the step, already turned with the body, or its
/// multiplier; `multiplier` (N) is that of the normal force: the pressure of a corner that just touches. The normal
/// spring of a `bonded` point pulls too (no breakaway: Rowe & Davis 1982).
KEDGE_FUNCTION ContactResponse respond_to_contact(const ContactGeometry& at, const ContactStiffness& stiffness,
                                                  const Eigen::Vector3d& previous, const double multiplier = 0.,
                                                  const bool bonded = false)
{
  ContactResponse response;
  const double pressure = multiplier - stiffness.normal * at.gap;
  if (!(pressure > 0.) && !bonded)
    return response;
  response.active = true;
  const Eigen::Vector3d& n = at.normal;
  const Eigen::Matrix3d across = n * n.transpose();
  const Eigen::Matrix3d along = Eigen::Matrix3d::Identity() - across;
  const double steep = at.steepness * stiffness.normal;

  response.force = pressure * n;
  response.tangent = pressure * at.turning - steep * across;
  response.by_gap = -stiffness.normal * n;

  const SlipLimit limit = slip_limit(stiffness, pressure, bonded);
  if (limit.force == 0. && limit.slope == 0.)
    return response;
  const Eigen::Vector3d elastic = previous - stiffness.tangential * at.slip, trial = along * elastic;
  const Eigen::Matrix3d trial_change = -(stiffness.tangential * along + n.dot(elastic) * at.turning +
                                         n * (at.turning.transpose() * elastic).transpose());
  const double size = std::sqrt(trial.dot(trial));
  response.tangential = size > limit.force ? Eigen::Vector3d(trial * (limit.force / size)) : trial;
  if (size <= (1. - on_the_limit) * limit.force || size == 0.)
    response.tangent += trial_change;
  else
  {
    response.sliding = true;
    const Eigen::Vector3d direction = trial * (1. / size);
    response.tangent -= limit.slope * steep * direction * n.transpose();
    response.by_gap -= limit.slope * stiffness.normal * direction;
    response.tangent +=
        std::fmin(1., limit.force / size) * (trial_change - direction * (direction.transpose() * trial_change));
  }
  response.force += response.tangential;
  return response;
}
} // namespace kedge
