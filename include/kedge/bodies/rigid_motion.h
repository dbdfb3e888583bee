// How rigid points move in a step of statics or dynamics: Newmark's method for translations and finite rotations.
//
// The rotations follow the momentum form of Simo & Wong 1991, ALGO-C1 (doi 10.1002/nme.1620310103), written with
// Newmark's two parameters. The increment is related to the convected angular velocity as in Simo & Vu-Quoc 1988
// (doi 10.1016/0045-7825(88)90073-4). Newmark's formula for the velocity is applied to the angular momentum in world
// axes, so a body without moment keeps its angular momentum exactly. It also keeps its energy exactly if
// beta = gamma / 2, for instance 1/4 and 1/2 or 1/2 and 1. Rotation about a principal axis is exact for any pair.
#pragma once

#include <kedge/bodies/rigid_systems.h>
#include <vector>

namespace kedge
{
/// Load and length of a step. The step uses the accelerations at its start unless beta = 1/2 and gamma = 1. At the
/// start of a stage they are unknown: a first step with that pair finds them and keeps the order of convergence.
struct RigidStep
{
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero(); ///< m/s2, with the load factor of the step
  double fraction = 1.;                              ///< of an uncut step, for the prescribed motion
  double dt = 0.;                                    ///< s; 0: static, no inertia
  double beta = 0.25, gamma = 0.5;                   ///< Newmark; both above 0
};

/// Momentum (kg m/s) and angular momentum about the point (kg m2/s), world axes.
Vector6 momentum(const RigidPoint& point);

/// Changes velocity and spin of the free dofs at once by an impulse (N s, and N m s about the point, world axes). The
/// acceleration afterwards belongs to the same forces as before. Free dofs need inertia.
void apply_impulse(RigidPoint& point, const Vector6& impulse);

/// Increments of all points from which Newton's method starts: the prescribed motion; free dofs rest. Extrapolating
/// their motion takes more iterations, because their velocity swings about its mean and would strain stiff joints.
std::vector<Vector6> start_increments(const RigidSystems& systems, const RigidStep& step);

/// The same, but the free dofs continue the motion of the last step. Use it where the soil is extrapolated too, so that
/// both still touch.
std::vector<Vector6> predicted_increments(const RigidSystems& systems, const RigidStep& step);

/// Velocity and acceleration at the end of a step, world axes. Dofs that are not free take the mean velocity of the
/// step and a constant acceleration; Newmark's formulas would let their velocity swing about the prescribed one.
struct EndOfStep
{
  Vector6 velocity;                         ///< m/s, rad/s
  Vector6 acceleration;                     ///< m/s2, rad/s2; zero about principal axes without inertia
  Vector6 momentum;                         ///< kg m/s; about the point, kg m2/s
  Vector6 momentum_rate;                    ///< N, N m
  Eigen::Matrix<double, 6, 6> rate_tangent; ///< d momentum_rate / d increment
};

/// `point` is in its state at the start of the step. All results are zero in a static step.
EndOfStep end_of_step(const RigidPoint& point, const RigidStep& step, const Vector6& increment);

/// Moves all points to the end of the step. After a static step they are at rest.
void commit_increments(RigidSystems& systems, const RigidStep& step, const std::vector<Vector6>& increments);
} // namespace kedge
