// Joints between two rigid points, as stiff springs. Each is an energy of the two poses; its forces and its tangent are
// the exact first and second derivative with respect to the increments of a step.
#pragma once

#include <Eigen/Core>
#include <array>
#include <kedge/bodies/parameters.h>
#include <kedge/bodies/rigid_body.h>
#include <vector>

namespace kedge
{
/// Increments of the first point, then of the second.
using Vector12 = Eigen::Matrix<double, 12, 1>;
using Matrix12 = Eigen::Matrix<double, 12, 12>;

/// Joint between two points. Which members a joint uses depends on its type (JointType).
struct Joint
{
  JointType type = JointType::ball;
  std::array<unsigned int, 2> points{};     ///< from 0, over all systems
  std::array<Eigen::Vector3d, 2> anchors{}; ///< in the frames of the two points, m
  std::array<Eigen::Vector3d, 2> axes{};    ///< hinge: unit vectors in the frames of the two points
  double distance = 0.;                     ///< between the anchors, m: rod: its length; stop: where it is taut
  double stiffness = 0.;                    ///< N/m
  double rotational_stiffness = 0.;         ///< hinge: N m (per radian)
};

/// Expresses a joint of the input in the frames of its points, which stand where the input puts them. `first_point` is
/// the number of the system's first point, counted over all systems. Only the line of an axis counts, not its sense:
/// the second axis is reversed where it opposes the first.
///
/// A stop goes taut when the arms from the rotation centre to its anchors enclose the angle limit; the law of cosines
/// turns this angle into a distance of the anchors. If both anchors start at one place, the hinge can open by the limit
/// to either side.
Joint make_joint(const JointParameters& parameters, const std::vector<PointParameters>& points,
                 unsigned int first_point, unsigned int dim);

/// Response of a joint to the increments of its two points.
struct JointResponse
{
  double energy = 0.;                  ///< J
  Vector12 force = Vector12::Zero();   ///< d energy / d increments, N and N m: resistance of the joint
  Matrix12 tangent = Matrix12::Zero(); ///< d force / d increments, symmetric
  /// Magnitude of force (N) and moment (N m) on each point before they cancel, and the part that may be round-off.
  std::array<std::array<double, 2>, 2> magnitude{}, round_off{};
};

/// Evaluates the energy of a joint (JointType lists the formulas) and its derivatives. A stop works with a distance and
/// not with an angle, so no angle can become singular. `start`: poses at the start of the step; `increments`: motion
/// since then.
JointResponse evaluate_joint(const Joint& joint, const std::array<Pose, 2>& start,
                             const std::array<Vector6, 2>& increments);

/// Action of a joint on the body of its first point, in world axes: a force at the anchor and, for a hinge, also a
/// couple. The opposite acts on the body of the second point, at that body's own anchor.
struct JointForce
{
  Eigen::Vector3d force;  ///< N
  Eigen::Vector3d couple; ///< N m
};

JointForce joint_force(const Joint& joint, const std::array<Pose, 2>& poses);
} // namespace kedge
