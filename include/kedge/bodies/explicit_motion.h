// Rigid points in explicit dynamics: kicks by the loads of the soil and their weight, drifts under their joints.
#pragma once

#include <kedge/bodies/rigid_balance.h>
#include <string>
#include <vector>

namespace kedge
{
/// The points on their way through a step of many small ones. Splitting after Strang (1968, SIAM J. Numer. Anal. 5):
/// half a kick, a drift, half a kick, which is velocity Verlet for a body without joints. In a drift the joints act
/// alone, and implicitly (Newmark's average acceleration), so that their stiffness does not limit the time step.
class ExplicitMotion
{
public:
  /// `begins_stage`: the accelerations of the points are not those of their joints yet.
  ExplicitMotion(const RigidSystems& committed, bool begins_stage);

  /// Lets loads (N, N m about the points where they stand, world axes; empty: none) and gravity (m/s2) act on the free
  /// dofs for a time, s.
  void kick(const BodyLoads& loads, const Eigen::Vector3d& gravity, double time);

  /// Moves on by a time, s, that is a `fraction` of an uncut step. Returns why it could not, or nothing.
  std::string drift(double fraction, double time);

  /// From the start of the step.
  std::vector<Vector6> increments() const;

  /// Hands position and motion to the points that the step started from; `fraction` is that of the whole step.
  void commit(RigidSystems& committed, double fraction) const;

private:
  std::vector<Pose> start;
  RigidSystems moving; ///< points and joints alone
  bool knows_accelerations;
};
} // namespace kedge
