// What corners see of the surfaces that they may touch: parts of them, or patches that stand for them within a step.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <kedge/contact_forces/pair.h>

namespace kedge
{
/// A surface goes on around a corner if its normal, half a size away, has turned by no more than this cosine tells.
constexpr double goes_on = 0.9;

/// In sizes of the particle: so far to either side of a patch its bend is taken, over facets that are not much longer.
constexpr double bends_within = 1.;

/// In sizes of the particle: far more than round-off and far less than what matters.
constexpr double aside = 1e-6;

/// Nearer to an edge or a vertex than this, in sizes of the particle, a corner counts as on it: the direction from
/// there is what the last solution has left of the distance.
constexpr double on_surface = 0.05;

/// Distance below which the normal at an edge or a vertex does not turn but jump, m.
constexpr double next_to_nothing = 1e-14;

constexpr double infinity = std::numeric_limits<double>::infinity();

KEDGE_FUNCTION double larger(const double a, const double b) { return a > b ? a : b; }
KEDGE_FUNCTION double smaller(const double a, const double b) { return a < b ? a : b; }

/// A part of a surface as a corner sees it.
struct SurfacePart
{
  double gap;
  Eigen::Vector3d normal;  ///< unit
  double steepness;        ///< d gap / d place = steepness * normal
  Eigen::Matrix3d turning; ///< d normal / d place, 1/m
};

/// The normal turns where the closest point stays on an edge or at a vertex.
KEDGE_FUNCTION SurfacePart part_at(const ClosestPoint& closest)
{
  const Eigen::Vector3d& n = closest.normal;
  SurfacePart part{closest.gap, n, 1., Eigen::Matrix3d::Zero()};
  if (closest.feature == Feature::face || !(std::fabs(closest.gap) > next_to_nothing))
    return part;
  part.turning = (Eigen::Matrix3d::Identity() - n * n.transpose()) * (1. / closest.gap);
  if (closest.feature == Feature::edge)
    part.turning -= closest.tangent * closest.tangent.transpose() * (1. / closest.gap);
  return part;
}

/// Of the surface, for a corner of a particle of that size.
KEDGE_FUNCTION Eigen::Vector3d normal_of(const ClosestPoint& closest, const double size)
{
  return std::fabs(closest.gap) < on_surface * size ? closest.pseudo_normal : closest.normal;
}

/// Normal of the surface nearest to a place in the body's frame, for a corner of a particle of that size.
KEDGE_FUNCTION Eigen::Vector3d normal_near(const Eigen::Vector3d& place, const SurfaceMotion& surface,
                                           const double size)
{
  KnownDistance nothing;
  ClosestPoint closest;
  if (!surface.tree.find_within(place, infinity, nothing, closest))
    return Eigen::Vector3d::Zero();
  return normal_of(closest, size);
}

/// How the normal turns around the point where the patch touches the surface; not at all across edges.
KEDGE_FUNCTION Eigen::Matrix3d find_bend(const ContactPair& pair, const SurfaceMotion& surface)
{
  const Eigen::Vector3d& n = pair.patch.normal;
  const Eigen::Vector3d first = n.unitOrthogonal(), directions[2] = {first, n.cross(first)};
  Eigen::Matrix3d rate = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& along : directions)
  {
    const double length = bends_within * pair.size;
    const Eigen::Vector3d step = length * along;
    const Eigen::Vector3d ahead = normal_near(pair.patch.point + step, surface, pair.size),
                          behind = normal_near(pair.patch.point - step, surface, pair.size);
    if (smaller(n.dot(ahead), n.dot(behind)) >= goes_on)
      rate += (ahead - behind) * along.transpose() * (0.5 / length);
  }
  const Eigen::Matrix3d within = Eigen::Matrix3d::Identity() - n * n.transpose();
  return 0.5 * within * (rate + rate.transpose()) * within;
}

/// The patch as the corner sees it after its slip d since the patch touched the surface, at n with the bend B:
/// gap + n d + d B d / 2, the distance from a bent surface up to terms of third order, the gap being as small as the
/// slip.
KEDGE_FUNCTION SurfacePart part_of_patch(const ContactPair& pair)
{
  const Eigen::Vector3d &n = pair.patch.normal, d = pair.slip - pair.patch_slip, bent = pair.bend * d;
  const Eigen::Vector3d gradient = n + bent;
  const double steepness = std::sqrt(gradient.squaredNorm());
  const Eigen::Vector3d normal = gradient * (1. / steepness);
  const Eigen::Matrix3d turning =
      (Eigen::Matrix3d::Identity() - normal * normal.transpose()) * pair.bend * (1. / steepness);
  return {pair.patch.gap + n.dot(d) + 0.5 * bent.dot(d), normal, steepness, turning};
}

/// The surface as a pair sees it from x, in the body's frame; nothing beyond `distance` (m) from the surface itself.
///
/// Within a step a smooth patch stands for the surface where its kinks would keep Newton's method from coming to rest:
/// tension pulls a corner inside a convex body into the kinks of the distance, where the normal jumps from facet to
/// facet, and a multiplier presses on however near the surface is, while the normal at an edge turns by 1/distance.
KEDGE_FUNCTION bool find_part(ContactPair& pair, const SurfaceMotion& surface, const Eigen::Vector3d& x,
                              const double distance, SurfacePart& part)
{
  if (!pair.on_patch && (pair.committed.bonded || pair.committed.multiplier > 0. || pair.committed.reference_gap > 0.))
  {
    KnownDistance nothing;
    pair.on_patch = surface.tree.find_within(surface.before.to_body(pair.start), infinity, nothing, pair.patch);
    pair.patch.normal = normal_of(pair.patch, pair.size);
    pair.patch_slip.setZero();
  }
  if (pair.on_patch)
  {
    if (!pair.knows_bend)
      pair.bend = find_bend(pair, surface);
    pair.knows_bend = true;
    part = part_of_patch(pair);
    return true;
  }
  ClosestPoint closest;
  if (!surface.tree.find_within(x, distance, pair.known, closest))
    return false;
  part = part_at(closest);
  pair.patch = closest; // should a multiplier press from now on
  pair.patch_slip = pair.slip;
  return true;
}

/// Finds which way the surface faces a corner at its start, and whether it goes on around it.
KEDGE_FUNCTION void look_around(ContactPair& pair, const SurfaceMotion& surface)
{
  // a little aside: round-off must not choose between sides that are equally near
  const Eigen::Vector3d x = surface.before.to_body(pair.start) + aside * pair.size * Eigen::Vector3d(0.61, 0.37, 0.7);
  const Eigen::Vector3d normal = normal_near(x, surface, pair.size);
  const Eigen::Vector3d along[2] = {normal.unitOrthogonal(), normal.cross(normal.unitOrthogonal())};
  pair.near_edge = false;
  for (int i = 0; i < 4; ++i)
  {
    const Eigen::Vector3d place = x + (i < 2 ? 0.5 : -0.5) * pair.size * along[i % 2];
    if (normal.dot(normal_near(place, surface, pair.size)) < goes_on)
      pair.near_edge = true;
  }
  pair.facing = surface.before.direction_to_world(normal);
}
} // namespace kedge
