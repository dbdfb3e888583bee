#include <Eigen/Geometry>
#include <algorithm>
#include <kedge/bodies/passage.h>

namespace kedge
{
namespace
{
/// In lengths of the smaller body's box: bodies that lie against each other do not overlap.
constexpr double round_off = 1e-6;

/// Whether a vertex or the middle of a triangle of `other` that `box` holds lies inside `welded`.
bool holds_part(const RigidSystems& systems, const WeldedSurface& welded, const WeldedSurface& other,
                const Eigen::AlignedBox3d& box, const double tolerance, const unsigned int dim)
{
  const Pose &pose = systems.points[welded.point].pose, &pose_of_other = systems.points[other.point].pose;
  const auto is_inside = [&](const Eigen::Vector3d& of_other)
  {
    Eigen::Vector3d x = pose_of_other.to_world(of_other);
    if (dim == 2)
      x[1] = 0.; // prisms have their vertices at their ends
    if (!box.contains(x))
      return false;
    const auto closest = welded.surface.closest_point_within(pose.to_body(x), 0.);
    return closest && closest->gap < -tolerance;
  };
  const TriangleMesh& mesh = other.surface.mesh();
  const auto& x = mesh.vertices;
  return std::any_of(x.begin(), x.end(), is_inside) ||
         std::any_of(mesh.triangles.begin(), mesh.triangles.end(),
                     [&](const auto& t) { return is_inside((x[t[0]] + x[t[1]] + x[t[2]]) / 3.); });
}

std::vector<Eigen::AlignedBox3d> boxes_of(const RigidSystems& systems)
{
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const WeldedSurface& welded : systems.surfaces)
  {
    const auto bounds = world_bounds(systems, welded);
    boxes.emplace_back(bounds[0], bounds[1]);
  }
  return boxes;
}

bool overlap(const RigidSystems& systems, const std::vector<Eigen::AlignedBox3d>& boxes, const unsigned int i,
             const unsigned int j, const unsigned int dim)
{
  const Eigen::AlignedBox3d common = boxes[i].intersection(boxes[j]);
  if (common.isEmpty())
    return false;
  const WeldedSurface &a = systems.surfaces[i], &b = systems.surfaces[j];
  const double tolerance = round_off * std::min(boxes[i].diagonal().norm(), boxes[j].diagonal().norm());
  return holds_part(systems, a, b, common, tolerance, dim) || holds_part(systems, b, a, common, tolerance, dim);
}
} // namespace

PassageWatch::PassageWatch(const RigidSystems& systems, const unsigned int dim_) : dim(dim_)
{
  const auto& surfaces = systems.surfaces;
  const std::vector<Eigen::AlignedBox3d> boxes = boxes_of(systems);
  for (unsigned int i = 0; i < surfaces.size(); ++i)
    for (unsigned int j = i + 1; j < surfaces.size(); ++j)
      if (system_of(systems, surfaces[i].point) != system_of(systems, surfaces[j].point) &&
          !overlap(systems, boxes, i, j, dim))
        apart.emplace_back(i, j);
}

std::optional<std::pair<unsigned int, unsigned int>> PassageWatch::find(const RigidSystems& systems) const
{
  if (apart.empty())
    return std::nullopt;
  const std::vector<Eigen::AlignedBox3d> boxes = boxes_of(systems);
  for (const auto& [i, j] : apart)
    if (overlap(systems, boxes, i, j, dim))
      return std::make_pair(i, j);
  return std::nullopt;
}
} // namespace kedge
