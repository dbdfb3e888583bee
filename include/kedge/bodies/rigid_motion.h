// How rigid points move in a step of statics or dynamics: Newmark's method for translations and finite rotations.
//
// The rotations follow the momentum form of Simo & Wong 1991, ALGO-C1 (doi 10.1002/nme.1620310103), in Newmark's two
// parameters: the increment is related to the convected angular velocity as in Simo & Vu-Quoc 1988
// (doi 10.1016/0045-7825(88)90073-4), and Newmark's formula for the velocity is applied to the angular momentum in
// world axes, which a body without moment so keeps exactly. With beta = gamma / 2 (1/4 and 1/2, but also 1/2 and 1) it
// keeps its energy exactly, too, and rotation about a principal axis is exact for any pair.
#pragma once

#include <kedge/bodies/rigid_systems.h>
#include <vector>

namespace kedge
{
/// What a step asks of the rigid points. The accelerations at the start of a step count unless beta = 1/2 and gamma
/// = 1. Where they are not known, as at the start of a stage, a first step with that pair finds them and costs no
/// order.
struct RigidStep
{
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero(); ///< m/s2, with the load factor of the step
  double fraction = 1.;                              ///< of an uncut step, for the prescribed motion
  double dt = 0.;                                    ///< s; 0: static, no inertia
  double beta = 0.25, gamma = 0.5;                   ///< Newmark; both above 0
};

/// Momentum (kg m/s) and angular momentum about the point (kg m2/s), world axes.
Vector6 momentum(const RigidPoint& point);

/// Changes velocity and spin of the free dofs by an impulse (N s, N m s about the point, world axes) at once. The
/// acceleration stays that of the forces which it stood for. Free dofs need inertia.
void apply_impulse(RigidPoint& point, const Vector6& impulse);

/// Increments of all points from which Newton's method starts: the prescribed motion, and rest of the free dofs. To
/// extrapolate their motion would strain stiff joints by whatever their velocity swings about its mean, and takes more
/// iterations.
std::vector<Vector6> start_increments(const RigidSystems& systems, const RigidStep& step);

/// The same with the free dofs moving on as in the last step, which is how soil that is predicted to move on expects
/// to meet them.
std::vector<Vector6> predicted_increments(const RigidSystems& systems, const RigidStep& step);

/// Velocity and acceleration at the end of a step, world axes. Dofs that are not free take the mean velocity of the
/// step and change it evenly: Newmark's formulas would answer a prescribed motion with a velocity that swings about it.
struct EndOfStep
{
  Vector6 velocity;                         ///< m/s, rad/s
  Vector6 acceleration;                     ///< m/s2, rad/s2; zero about principal axes without inertia
  Vector6 momentum;                         ///< kg m/s; angular about the point, kg m2/s
  Vector6 momentum_rate;                    ///< N, N m
  Eigen::Matrix<double, 6, 6> rate_tangent; ///< d momentum_rate / d increment
};

/// All zero in a static step. Needs the point as it was at the start of the step.
EndOfStep end_of_step(const RigidPoint& point, const RigidStep& step, const Vector6& increment);

/// Moves all points to the end of the step. Static steps leave them at rest.
void commit_increments(RigidSystems& systems, const RigidStep& step, const std::vector<Vector6>& increments);
} // namespace kedge
