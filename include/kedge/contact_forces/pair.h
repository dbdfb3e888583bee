// A corner of a particle's domain and a surface that it may touch, as host and kernels know them: plain data.
#pragma once

#include <cmath>
#include <cstdint>
#include <kedge/bodies/frame.h>
#include <kedge/bodies/triangle_tree.h>
#include <kedge/contact_forces/coulomb.h>
#include <limits>
#include <tuple>

namespace kedge
{
struct ContactKey
{
  long long particle;
  std::uint32_t corner, surface;
  bool operator<(const ContactKey& other) const
  {
    return std::tie(particle, corner, surface) < std::tie(other.particle, other.corner, other.surface);
  }
};

/// How far a body has come towards the soil at a corner since that first touched it, m.
struct BodyApproach
{
  double now = 0., most = 0., least = 0.; ///< least <= now <= most
  double beside_edges = 0.; ///< length of its path, in whatever direction, while the surface ended near the corner
};

/// What the reference gap of a corner goes by, m.
struct ReferenceMemory
{
  /// How far off the surface, and inside the body, the burial has put it, less what has faded.
  double farthest_off = 0., farthest_in = 0.;
  double opening = 0.; ///< how far the corner has left the reference
  BodyApproach approach;
};

/// Of a corner whose reference gap a burial, or a first place inside, has put there (m).
KEDGE_FUNCTION ReferenceMemory begins_at(const double reference_gap)
{
  ReferenceMemory memory;
  (reference_gap > 0. ? memory.farthest_off : memory.farthest_in) = std::fabs(reference_gap);
  return memory;
}

struct ContactHistory
{
  Eigen::Vector3d tangential = Eigen::Vector3d::Zero(); ///< N, world axes
  double reference_gap = 0.;                            ///< m
  ReferenceMemory memory;
  double multiplier = 0.; ///< of the normal force, N
  bool bonded = false;    ///< also carries tension
  double pressure = 0.;   ///< normal force, N; below 0 only where bonded
};

struct ContactPair
{
  ContactKey key;
  unsigned int point;    ///< of PointForces
  Eigen::Vector3d start; ///< corner at the start of the step, m
  ContactStiffness stiffness;
  double size = 0.;   ///< of the particle, m
  bool bonds = false; ///< whether the surface is one that bonds what touches it
  ContactHistory committed, trial;
  /// Multipliers in use and from the last evaluation, axes as at the start of the step.
  ContactHistory augmented, proposed;
  double gap = std::numeric_limits<double>::infinity();  ///< signed distance in the last evaluation
  double reference_gap = 0.;                             ///< in the last evaluation: faded
  BodyApproach approach, approach_begin;                 ///< what it fades with; the same at the last follow_path()
  Eigen::Vector3d facing = Eigen::Vector3d::Zero();      ///< out of the body at `start`; zero while nobody has asked
  bool near_edge = false;                                ///< the surface turns within half a size from `start`
  Eigen::Vector3d fading = Eigen::Vector3d::Zero();      ///< d reference gap / d place of the body
  Eigen::Vector3d carried = Eigen::Vector3d::Zero();     ///< the corner's start, moved with the body, m
  Eigen::Vector3d carry_begin = Eigen::Vector3d::Zero(); ///< `carried` less `start` at the last follow_path(), m
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();      ///< out of the body, in the last evaluation
  Eigen::Vector3d slip = Eigen::Vector3d::Zero();        ///< in the last evaluation, in the body's frame, m
  Eigen::Vector3d slip_begin = Eigen::Vector3d::Zero();  ///< what the tangential force in use belongs to, so too
  KnownDistance known;                                   ///< in the body's frame
  bool on_patch = false;                                 ///< a patch stands for the surface
  bool knows_bend = false;                               ///< that of the patch
  ClosestPoint patch; ///< where it touches the surface, and the gap of the corner then; in the body's frame
  Eigen::Vector3d patch_slip = Eigen::Vector3d::Zero(); ///< of the corner then, so too, m
  Eigen::Matrix3d bend = Eigen::Matrix3d::Zero();       ///< d normal / d place along the patch, so too, 1/m
  bool active = false;
  Eigen::Vector3d position = Eigen::Vector3d::Zero(), force = Eigen::Vector3d::Zero();
  Eigen::Matrix3d tangent = Eigen::Matrix3d::Zero(); ///< d force / d soil point
  Eigen::Vector3d by_gap = Eigen::Vector3d::Zero();  ///< d force / d gap, the place being held
};

/// What evaluations need of a pair that is far from touching, so that they leave it alone.
struct ContactRest
{
  unsigned int surface;
  bool asleep;      ///< the last response is that of a pair that touches nothing
  bool followed;    ///< follow_path() has taken over the last response
  double lever;     ///< distance of the corner from the body's origin at the start of the step, m
  double clearance; ///< m that they may go against each other, from the start of the step, without touching
};

/// A surface, and where its body is before and after the increments of an evaluation.
struct SurfaceMotion
{
  TriangleTree tree;
  Frame before, now;
  double shift, turn;       ///< the body takes a corner that goes with it at most shift + turn * lever far, m
  unsigned int rigid_point; ///< of the body
};
} // namespace kedge
