#include <Eigen/Geometry>
#include <algorithm>
#include <kedge/base/communication.h>
#include <kedge/output/grids.h>
#include <map>

namespace kedge
{
namespace
{
/// The faces of one surface that are shown, in the frame of its point.
struct Faces
{
  std::vector<Eigen::Vector3d> corners;
  std::vector<std::int32_t> connectivity; ///< into `corners`
  std::vector<double> area;               ///< m2 (2-D: m)
  std::vector<int> of_triangle;           ///< face that each triangle of the surface belongs to, or -1
};

Faces show_triangles(const TriangleMesh& mesh)
{
  Faces faces;
  faces.corners = mesh.vertices;
  for (const auto& [a, b, c] : mesh.triangles)
  {
    faces.of_triangle.push_back(static_cast<int>(faces.area.size()));
    for (const unsigned int vertex : {a, b, c})
      faces.connectivity.push_back(static_cast<std::int32_t>(vertex));
    const Eigen::Vector3d &x = mesh.vertices[a], &y = mesh.vertices[b], &z = mesh.vertices[c];
    faces.area.push_back((y - x).cross(z - x).norm() / 2.);
  }
  return faces;
}

/// Turns the prism of a plane-strain body back into its outline: each triangle of a side projects to two points.
Faces show_outline(const TriangleMesh& mesh)
{
  using InPlane = std::pair<double, double>;
  Faces faces;
  std::map<InPlane, std::int32_t> corner_at;
  std::map<std::pair<std::int32_t, std::int32_t>, int> side_between;
  for (const auto& triangle : mesh.triangles)
  {
    std::vector<std::int32_t> ends;
    for (const unsigned int vertex : triangle)
    {
      const Eigen::Vector3d& x = mesh.vertices[vertex];
      const auto [entry, is_new] = corner_at.emplace(InPlane(x[0], x[2]), static_cast<std::int32_t>(corner_at.size()));
      if (is_new)
        faces.corners.emplace_back(x[0], 0., x[2]);
      if (std::find(ends.begin(), ends.end(), entry->second) == ends.end())
        ends.push_back(entry->second);
    }
    if (ends.size() != 2)
    {
      faces.of_triangle.push_back(-1); // an end cap
      continue;
    }
    std::sort(ends.begin(), ends.end());
    const auto [side, is_new] = side_between.emplace(std::make_pair(ends[0], ends[1]), faces.area.size());
    faces.of_triangle.push_back(side->second);
    if (!is_new)
      continue;
    faces.connectivity.insert(faces.connectivity.end(), ends.begin(), ends.end());
    faces.area.push_back((faces.corners[ends[1]] - faces.corners[ends[0]]).norm());
  }
  return faces;
}

/// Force per area on every face of one surface, three components each.
std::vector<double> contact_pressure(const Faces& faces, const Surface& surface, const Pose& pose, unsigned int number,
                                     const std::vector<ContactForce>& contact)
{
  std::vector<double> pressure(3 * faces.area.size(), 0.);
  for (const ContactForce& at : contact)
  {
    if (at.surface != number)
      continue;
    const int face = faces.of_triangle[surface.closest_point(pose.to_body(at.position)).triangle];
    if (face < 0)
      continue;
    for (unsigned int d = 0; d < 3; ++d)
      pressure[3 * face + d] -= at.force[d] / faces.area[face];
  }
  return pressure;
}

void add_up_on_root(std::vector<double>& values, const MPI_Comm communicator)
{
  const bool on_root = rank_of(communicator) == 0;
  MPI_Reduce(on_root ? MPI_IN_PLACE : values.data(), values.data(), message_length(values.size()), MPI_DOUBLE, MPI_SUM,
             0, communicator);
}
} // namespace

template <int dim>
UnstructuredGrid body_surfaces(const RigidSystems& bodies, const std::vector<ContactForce>& contact,
                               const MPI_Comm communicator)
{
  UnstructuredGrid grid;
  grid.shape = dim == 3 ? CellShape::triangle : CellShape::line;
  std::vector<std::int32_t> body;
  std::vector<float> velocity, force;
  for (unsigned int s = 0; s < bodies.surfaces.size(); ++s)
  {
    const WeldedSurface& welded = bodies.surfaces[s];
    const RigidPoint& point = bodies.points[welded.point];
    const Faces faces = dim == 3 ? show_triangles(welded.surface.mesh()) : show_outline(welded.surface.mesh());
    const auto first = static_cast<std::int32_t>(grid.n_points());
    for (const std::int32_t corner : faces.connectivity)
      grid.connectivity.push_back(first + corner);
    for (const Eigen::Vector3d& corner : faces.corners)
    {
      const Eigen::Vector3d x = point.pose.to_world(corner);
      grid.points.insert(grid.points.end(), x.data(), x.data() + 3);
      for (const double component : velocity_at(point, corner))
        velocity.push_back(static_cast<float>(component));
    }
    body.insert(body.end(), faces.area.size(), static_cast<std::int32_t>(welded.point + 1));
    std::vector<double> pressure = contact_pressure(faces, welded.surface, point.pose, s, contact);
    add_up_on_root(pressure, communicator);
    for (const double component : pressure)
      force.push_back(static_cast<float>(component));
  }
  grid.point_data.push_back({"velocity", 3, std::move(velocity), component_names(3)});
  grid.cell_data.push_back({"body", 1, std::move(body)});
  grid.cell_data.push_back({"contact force", 3, std::move(force), component_names(3)});
  return grid;
}

template UnstructuredGrid body_surfaces<2>(const RigidSystems&, const std::vector<ContactForce>&, MPI_Comm);
template UnstructuredGrid body_surfaces<3>(const RigidSystems&, const std::vector<ContactForce>&, MPI_Comm);
} // namespace kedge
