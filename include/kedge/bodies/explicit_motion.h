// Rigid points in explicit dynamics: loads of the soil kick them, then they drift under their joints and weight.
#pragma once

#include <kedge/bodies/rigid_balance.h>
#include <string>
#include <vector>

namespace kedge
{
/// Motion of the points within a step that consists of many small ones. Each small step is half a kick, a drift and
/// half a kick (splitting after Strang 1968, SIAM J. Numer. Anal. 5); without joints this is velocity Verlet. In a
/// drift joints and weight act alone, implicitly (Newmark's average acceleration), so the joints' stiffness does not
/// limit the time step; it is made in as many parts as keep their energy.
class ExplicitMotion
{
public:
  /// `begins_stage`: the points do not know yet which accelerations their joints cause.
  ExplicitMotion(const RigidSystems& committed, bool begins_stage);

  /// Loads act on the free dofs for `time` (s). Loads: N and N m about the present position of each point, world axes;
  /// empty: none.
  void kick(const BodyLoads& loads, double time);

  /// Moves the points under gravity (m/s2) for `time` (s), which is `fraction` of an uncut step. Returns why this
  /// failed; empty on success.
  std::string drift(const Eigen::Vector3d& gravity, double fraction, double time);

  /// Motion of every point since the start of the step.
  std::vector<Vector6> increments() const;

  /// Mean rate of the momentum of every point since the start of the step, N and N m, world axes.
  std::vector<Vector6> momentum_rates() const;

  /// Copies position and motion to `committed`, from which the step started. `fraction` is that of the whole step, over
  /// which the acceleration that it reports is the mean.
  void commit(RigidSystems& committed, double fraction) const;

  /// Equal parts in which the next drift is made, so many that points do not turn far in one beside how stiff their
  /// joints are.
  unsigned int count_parts(const Eigen::Vector3d& gravity, double fraction, double time) const;

private:
  std::vector<Pose> start;
  std::vector<Vector6> start_momentum;
  RigidSystems moving; ///< points and joints alone
  double passed = 0.;  ///< s
  bool knows_accelerations;
};
} // namespace kedge
