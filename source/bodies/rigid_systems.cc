#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <kedge/base/exceptions.h>
#include <kedge/bodies/rigid_systems.h>
#include <limits>

namespace kedge
{
namespace
{
/// Bounds of an empty set of points.
const std::array<Eigen::Vector3d, 2> nothing{{Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()),
                                              Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity())}};

TriangleMesh in_body_frame(TriangleMesh mesh, const Eigen::Vector3d& origin)
{
  for (Eigen::Vector3d& vertex : mesh.vertices)
    vertex -= origin;
  return mesh;
}
} // namespace

RigidSystems make_rigid_systems(const std::vector<SystemParameters>& parameters, const unsigned int dim)
{
  RigidSystems systems;
  for (std::size_t s = 0; s < parameters.size(); ++s)
  {
    const SystemParameters& system = parameters[s];
    const unsigned int first = systems.points.size();
    systems.first_point.push_back(first);
    for (const PointParameters& point : system.points)
      systems.points.emplace_back(point, system.offset, dim);
    for (std::size_t i = 0; i < system.surfaces.size(); ++i)
    {
      const SurfaceParameters& surface = system.surfaces[i];
      const PointParameters& point = system.points[surface.point - 1];
      const std::string path = fmt::format("rigid bodies[{}].{}[{}]", s, dim == 3 ? "stl files" : "outline", i);
      TriangleMesh mesh = dim == 3 ? read_stl(surface.stl, path)
                                   : extrude_outline(round_outline(surface.outline, surface.edge_radius, path), path);
      // The input gives surfaces in global coordinates before the offset, like the points.
      systems.surfaces.push_back({Surface(in_body_frame(std::move(mesh), to_world_axes(point.position, dim))),
                                  first + surface.point - 1, surface.interface});
    }
    for (const JointParameters& joint : system.joints)
      systems.joints.push_back(make_joint(joint, system.points, first, dim));
    for (const TrackedNodeParameters& node : system.tracked_nodes)
      systems.tracked.push_back(
          {to_world_axes(node.position, dim) - to_world_axes(system.points[node.point - 1].position, dim),
           first + node.point - 1});
  }
  return systems;
}

void apply_conditions(RigidSystems& systems, const std::vector<SystemParameters>& parameters,
                      const std::vector<PointConditionsOverride>& overrides, const unsigned int dim)
{
  // RigidPoint turns the three conditions of plane strain into six, so a point is made from the conditions alone.
  const auto set = [&](const std::size_t system, const std::size_t point, const std::array<DofCondition, 6>& conditions)
  {
    PointParameters changed;
    changed.conditions = conditions;
    systems.points[systems.first_point[system] + point].conditions = RigidPoint(changed, {}, dim).conditions;
  };
  for (std::size_t s = 0; s < parameters.size(); ++s)
    for (std::size_t i = 0; i < parameters[s].points.size(); ++i)
      set(s, i, parameters[s].points[i].conditions);
  for (const PointConditionsOverride& change : overrides)
    set(change.system - 1, change.point - 1, change.conditions);
}

std::array<Eigen::Vector3d, 2> world_bounds(const RigidSystems& systems, const WeldedSurface& welded)
{
  std::array<Eigen::Vector3d, 2> box = nothing;
  for (const Eigen::Vector3d& vertex : welded.surface.mesh().vertices)
  {
    const Eigen::Vector3d x = systems.points[welded.point].pose.to_world(vertex);
    box[0] = box[0].cwiseMin(x);
    box[1] = box[1].cwiseMax(x);
  }
  return box;
}

namespace
{
void include(std::array<Eigen::Vector3d, 2>& box, const std::array<Eigen::Vector3d, 2>& other)
{
  box[0] = box[0].cwiseMin(other[0]);
  box[1] = box[1].cwiseMax(other[1]);
}

/// 0 where the box is empty.
double diagonal_of(const std::array<Eigen::Vector3d, 2>& box, const unsigned int dim)
{
  Eigen::Vector3d diagonal = box[1] - box[0];
  if (dim == 2)
    diagonal[1] = 0.;
  return box[0][0] <= box[1][0] ? diagonal.norm() : 0.;
}

/// Bounds of the surfaces of each point; empty for points without one.
std::vector<std::array<Eigen::Vector3d, 2>> bounds_of_points(const RigidSystems& systems)
{
  std::vector<std::array<Eigen::Vector3d, 2>> boxes(systems.points.size(), nothing);
  for (const WeldedSurface& welded : systems.surfaces)
    include(boxes[welded.point], world_bounds(systems, welded));
  return boxes;
}
} // namespace

std::array<Eigen::Vector3d, 2> world_bounds(const RigidSystems& systems)
{
  std::array<Eigen::Vector3d, 2> box = nothing;
  for (const WeldedSurface& welded : systems.surfaces)
    include(box, world_bounds(systems, welded));
  return box;
}

std::vector<double> levers_of_points(const RigidSystems& systems, const unsigned int dim)
{
  std::vector<double> levers;
  for (const auto& box : bounds_of_points(systems))
    levers.push_back(0.5 * diagonal_of(box, dim));
  return levers;
}

std::vector<SystemSize> sizes_of_systems(const RigidSystems& systems, const unsigned int dim)
{
  std::vector<SystemSize> sizes(std::max<std::size_t>(1, systems.first_point.size()));
  std::vector<std::array<Eigen::Vector3d, 2>> boxes(sizes.size(), nothing);
  const std::vector<std::array<Eigen::Vector3d, 2>> box_of_point = bounds_of_points(systems);
  for (std::size_t i = 0; i < systems.points.size(); ++i)
  {
    const unsigned int system = system_of(systems, i);
    include(boxes[system], box_of_point[i]);
    const RigidPoint& point = systems.points[i];
    if (point.n_free_dofs() == 0)
      continue;
    SystemSize& size = sizes[system];
    size.free_mass += point.mass;
    const double gyration = point.mass > 0. ? std::sqrt(point.world_inertia().diagonal().maxCoeff() / point.mass) : 0.;
    const double lever = 0.5 * diagonal_of(box_of_point[i], dim);
    size.lever = std::max(size.lever, lever > 0. ? lever : gyration);
  }
  for (const WeldedSurface& welded : systems.surfaces)
  {
    double& farthest = sizes[system_of(systems, welded.point)].farthest;
    for (const Eigen::Vector3d& vertex : welded.surface.mesh().vertices)
      farthest = std::max(farthest, dim == 2 ? std::hypot(vertex[0], vertex[2]) : vertex.norm());
  }
  for (std::size_t s = 0; s < sizes.size(); ++s)
    sizes[s].extent = diagonal_of(boxes[s], dim);
  return sizes;
}

unsigned int system_of(const RigidSystems& systems, const unsigned int point)
{
  const auto& first = systems.first_point;
  return first.empty() ? 0 : std::upper_bound(first.begin(), first.end(), point) - first.begin() - 1;
}

std::vector<double> farthest_apart(const RigidSystems& systems, const std::vector<Vector6>& increments,
                                   const std::vector<Vector6>& others)
{
  std::vector<double> farthest(systems.points.size(), 0.);
  for (const WeldedSurface& welded : systems.surfaces)
  {
    const unsigned int i = welded.point;
    if (increments[i] == others[i])
      continue;
    const Pose one = systems.points[i].pose.moved(increments[i]), other = systems.points[i].pose.moved(others[i]);
    for (const Eigen::Vector3d& vertex : welded.surface.mesh().vertices)
      farthest[i] = std::max(farthest[i], (one.to_world(vertex) - other.to_world(vertex)).norm());
  }
  return farthest;
}

double largest_prescribed_motion(const RigidSystems& systems)
{
  std::vector<Vector6> increments;
  for (const RigidPoint& point : systems.points)
    increments.push_back(point.prescribed_increment(1.));
  const std::vector<Vector6> rest(systems.points.size(), Vector6::Zero());
  double largest = 0.;
  for (const double motion : farthest_apart(systems, increments, rest))
    largest = std::max(largest, motion);
  return largest;
}

bool surface_comes_within(const RigidSystems& systems, const Eigen::Vector3d& lower, const Eigen::Vector3d& upper,
                          const double distance)
{
  return std::any_of(systems.surfaces.begin(), systems.surfaces.end(),
                     [&](const WeldedSurface& welded)
                     {
                       const Pose& pose = systems.points[welded.point].pose;
                       return welded.surface.comes_within({pose.to_body(0.5 * (lower + upper)),
                                                           pose.rotation.conjugate().toRotationMatrix(),
                                                           0.5 * (upper - lower)},
                                                          distance);
                     });
}

void place_on_surface(RigidSystems& systems, const unsigned int axis, const double height)
{
  if (systems.surfaces.empty())
    return;
  const double shift = height - world_bounds(systems)[0][axis];
  for (RigidPoint& point : systems.points)
    point.pose.position[axis] += shift;
}

bool is_inside(const RigidSystems& systems, const Eigen::Vector3d& x)
{
  return std::any_of(systems.surfaces.begin(), systems.surfaces.end(),
                     [&](const WeldedSurface& welded)
                     { return welded.surface.is_within(systems.points[welded.point].pose.to_body(x), 0.); });
}
} // namespace kedge
