#include <algorithm>
#include <cmath>
#include <kedge/bodies/joints.h>
#include <limits>

namespace kedge
{
namespace
{
/// Energy that depends on the length l of a vector alone.
struct CentralEnergy
{
  double energy;    ///< J
  double secant;    ///< energy' / l, N/m
  double curvature; ///< energy'', N/m
};

/// k/2 <x>^2, whose second derivative jumps at x = 0; here the jump is spread over the width w. The force is zero up to
/// x = -w/2, then k (x + w/2)^2 / (2 w), and k x from x = w/2 on.
CentralEnergy one_sided(const double x, const double length, const double stiffness, const double width)
{
  const double in = x + width / 2.;
  if (in <= 0.)
    return {0., 0., 0.};
  if (in < width)
    return {stiffness * in * in * in / (6. * width), stiffness * in * in / (2. * width) / length,
            stiffness * in / width};
  return {stiffness * (x * x / 2. + width * width / 24.), stiffness * x / length, stiffness};
}

CentralEnergy central_energy(const Joint& joint, const double length)
{
  const double k = joint.stiffness, stretch = length - joint.distance;
  switch (joint.type)
  {
    case JointType::rod:
      // A rod of no length has no direction. The bound only keeps the numbers finite.
      return {k / 2. * stretch * stretch, k * stretch / std::max(length, 1e-6 * joint.distance), k};
    case JointType::stop:
      return one_sided(stretch, length, k, 1e-3 * joint.distance);
    case JointType::ball:
    case JointType::hinge:
      break;
  }
  return {k / 2. * length * length, k, k};
}

/// A point or direction that a body carries, at the end of the step.
struct Carried
{
  Eigen::Vector3d place;                   ///< world axes
  Eigen::Vector3d arm;                     ///< the part of `place` that turns with the body
  Eigen::Matrix<double, 3, 6> by_movement; ///< d place / d increment
};

Carried carried_point(const Pose& start, const Vector6& increment, const Eigen::Vector3d& X)
{
  const Pose pose = start.moved(increment);
  return {pose.to_world(X), pose.direction_to_world(X), motion_tangent(start, increment, X)};
}

Carried carried_direction(const Pose& start, const Vector6& increment, const Eigen::Vector3d& D)
{
  Carried direction = carried_point(start, increment, D);
  direction.place = direction.arm;
  direction.by_movement.leftCols<3>().setZero();
  return direction;
}

/// Second derivative of f . place with respect to the increment. The first term stands for the turning arm, the second
/// one for the change of T: the rate of the rotation vector is not the spin.
Eigen::Matrix3d turning_stiffness(const Carried& carried, const Vector6& increment, const Eigen::Vector3d& f)
{
  const Eigen::Vector3d theta = increment.tail<3>();
  const Eigen::Matrix3d T = rotation_tangent(theta);
  return T.transpose() * skew(f) * skew(carried.arm) * T + generalised_moment_tangent(theta, carried.arm.cross(f));
}

/// Adds the energy of the difference of two carried vectors.
void add_spring(const CentralEnergy& central, const std::array<Carried, 2>& ends,
                const std::array<Vector6, 2>& increments, JointResponse& response)
{
  const Eigen::Vector3d difference = ends[0].place - ends[1].place;
  const double length = difference.norm();
  const Eigen::Vector3d unit = length > 0. ? Eigen::Vector3d(difference / length) : Eigen::Vector3d::Zero();
  const Eigen::Vector3d force = central.secant * difference;
  const Eigen::Matrix3d stiffness =
      central.secant * Eigen::Matrix3d::Identity() + (central.curvature - central.secant) * unit * unit.transpose();
  Eigen::Matrix<double, 3, 12> change;
  change << ends[0].by_movement, -ends[1].by_movement;
  response.energy += central.energy;
  response.force += change.transpose() * force;
  response.tangent += change.transpose() * stiffness * change;
  response.tangent.block<3, 3>(3, 3) += turning_stiffness(ends[0], increments[0], force);
  response.tangent.block<3, 3>(9, 9) += turning_stiffness(ends[1], increments[1], -force);

  const double noise = std::numeric_limits<double>::epsilon() * std::max(central.secant, central.curvature) *
                       (ends[0].place.norm() + ends[1].place.norm());
  for (unsigned int i = 0; i < 2; ++i)
  {
    const double arm = ends[i].arm.norm(),
                 moves = ends[i].by_movement(0, 0); // 0 for a direction: no force on the point
    response.magnitude[i][0] += moves * force.norm();
    response.magnitude[i][1] += arm * force.norm();
    response.round_off[i][0] += moves * noise;
    response.round_off[i][1] += arm * noise;
  }
}
} // namespace

Joint make_joint(const JointParameters& parameters, const std::vector<PointParameters>& points,
                 const unsigned int first_point, const unsigned int dim)
{
  Joint joint;
  joint.type = parameters.type;
  joint.distance = parameters.distance;
  joint.stiffness = parameters.stiffness;
  joint.rotational_stiffness = parameters.rotational_stiffness;
  const bool hinge = parameters.type == JointType::hinge;
  const Eigen::Vector3d centre = to_world_axes(parameters.rotation_centre, dim);
  const std::array<Eigen::Vector3d, 2> places = {
      hinge ? centre : to_world_axes(parameters.position_1, dim),
      hinge ? centre : to_world_axes(parameters.position_2, dim),
  };
  // Anchors are given in global coordinates before the offset, like the points, which start unrotated.
  for (unsigned int i = 0; i < 2; ++i)
  {
    joint.points[i] = first_point + parameters.points[i] - 1;
    joint.anchors[i] = places[i] - to_world_axes(points[parameters.points[i] - 1].position, dim);
  }
  if (hinge)
  {
    joint.axes = {to_world_axes(parameters.direction_1, dim).normalized(),
                  to_world_axes(parameters.direction_2, dim).normalized()};
    if (joint.axes[0].dot(joint.axes[1]) < 0.)
      joint.axes[1] *= -1.;
  }
  if (parameters.type == JointType::stop)
  {
    const double a = (places[0] - centre).norm(), b = (places[1] - centre).norm();
    const double cosine = std::cos(parameters.angle_limit * M_PI / 180.);
    joint.distance = std::sqrt(a * a + b * b - 2. * a * b * cosine);
  }
  return joint;
}

JointResponse evaluate_joint(const Joint& joint, const std::array<Pose, 2>& start,
                             const std::array<Vector6, 2>& increments)
{
  JointResponse response;
  const auto ends = [&](const auto& carried, const std::array<Eigen::Vector3d, 2>& vectors)
  {
    return std::array<Carried, 2>{carried(start[0], increments[0], vectors[0]),
                                  carried(start[1], increments[1], vectors[1])};
  };
  const std::array<Carried, 2> anchors = ends(carried_point, joint.anchors);
  add_spring(central_energy(joint, (anchors[0].place - anchors[1].place).norm()), anchors, increments, response);
  if (joint.type == JointType::hinge)
  {
    const std::array<Carried, 2> axes = ends(carried_direction, joint.axes);
    const double k = joint.rotational_stiffness;
    add_spring({k / 2. * (axes[0].place - axes[1].place).squaredNorm(), k, k}, axes, increments, response);
  }
  return response;
}

JointForce joint_force(const Joint& joint, const std::array<Pose, 2>& poses)
{
  const Vector12 resistance = evaluate_joint(joint, poses, {Vector6::Zero(), Vector6::Zero()}).force;
  const Eigen::Vector3d force = resistance.head<3>(), moment = resistance.segment<3>(3);
  return {-force, poses[0].direction_to_world(joint.anchors[0]).cross(force) - moment};
}
} // namespace kedge
