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

/// Joint between two points; which members count depends on the type.
struct Joint
{
  ConstraintType type = ConstraintType::coincidence;
  std::array<unsigned int, 2> points{};     ///< from 0, over all systems
  std::array<Eigen::Vector3d, 2> anchors{}; ///< in the frames of the two points, m
  std::array<Eigen::Vector3d, 2> axes{};    ///< hinge: unit vectors in the frames of the two points
  double distance = 0.;                     ///< between the anchors, m: rod: its length; stop: where it is taut
  double stiffness = 0.;                    ///< N/m
  double rotational_stiffness = 0.;         ///< hinge: N m (per radian)
};

/// Turns a constraint of the input into the frames of its points, as they stand in the input; `first_point` is the
/// number of the system's first point over all systems. An axis has no sense: opposite directions are turned to agree.
///
/// A stop is taut at the distance of its anchors at which their arms from the rotation centre enclose the angle limit
/// (law of cosines). So where both anchors start at one place, the hinge opens by the limit to either side.
Joint make_joint(const ConstraintParameters& parameters, const std::vector<PointParameters>& points,
                 unsigned int first_point, unsigned int dim);

/// The answer of a joint to the increments of its two points.
struct JointResponse
{
  double energy = 0.;                  ///< J
  Vector12 force = Vector12::Zero();   ///< d energy / d increments, N and N m: what the joint resists with
  Matrix12 tangent = Matrix12::Zero(); ///< d force / d increments, symmetric
  /// Magnitude of force (N) and moment (N m) on each point before they cancel, and how much of it may be round-off.
  std::array<std::array<double, 2>, 2> magnitude{}, round_off{};
};

/// Energy of the springs, with g = x_1 - x_2 the distance vector of the anchors and d_1, d_2 the hinge axes:
///   ball   k/2 |g|^2
///   hinge  k/2 |g|^2 + k_r/2 |d_1 - d_2|^2 = k/2 |g|^2 + k_r (1 - cos(angle between the axes))
///   rod    k/2 (|g| - L)^2, in tension and compression
///   stop   k/2 <|g| - L>^2, with its kink rounded over a thousandth of L, so that the stiffness is continuous. No
///   angle
///          enters, and there is none to be singular.
/// `start` are the poses at the start of the step, `increments` the motion since then.
JointResponse evaluate_joint(const Joint& joint, const std::array<Pose, 2>& start,
                             const std::array<Vector6, 2>& increments);

/// What a joint exerts on the body of its first point, world axes: a force at its anchor and, of a hinge, a couple
/// beside it. The body of the second point gets the opposite at its own anchor.
struct JointForce
{
  Eigen::Vector3d force;  ///< N
  Eigen::Vector3d couple; ///< N m
};

JointForce joint_force(const Joint& joint, const std::array<Pose, 2>& poses);
} // namespace kedge
