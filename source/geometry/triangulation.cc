#include "triangulation.h"

// CGAL's headers are slow to compile: no other file of this room includes them.
#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <kedge/base/exceptions.h>

namespace kedge
{
bool is_inside(const std::vector<Eigen::Vector2d>& polygon, const Eigen::Vector2d& x)
{
  bool inside = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++)
  {
    const Eigen::Vector2d &a = polygon[i], &b = polygon[j];
    if ((a[1] > x[1]) != (b[1] > x[1]) && x[0] < a[0] + (b[0] - a[0]) * (x[1] - a[1]) / (b[1] - a[1]))
      inside = !inside;
  }
  return inside;
}

std::vector<std::array<unsigned int, 3>> triangulate_polygon(const std::vector<Eigen::Vector2d>& points,
                                                             unsigned int n_corners)
{
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  using Vertices = CGAL::Triangulation_vertex_base_with_info_2<unsigned int, Kernel>;
  using Faces = CGAL::Constrained_triangulation_face_base_2<Kernel>;
  using Triangulation =
      CGAL::Constrained_Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<Vertices, Faces>,
                                                 CGAL::No_constraint_intersection_tag>;

  Triangulation triangulation;
  std::vector<Triangulation::Vertex_handle> vertices;
  for (unsigned int i = 0; i < points.size(); ++i)
  {
    vertices.push_back(triangulation.insert(Kernel::Point_2(points[i][0], points[i][1])));
    vertices.back()->info() = i;
  }
  try
  {
    for (unsigned int i = 0; i < n_corners; ++i)
      triangulation.insert_constraint(vertices[i], vertices[(i + 1) % n_corners]);
  }
  catch (const Triangulation::Intersection_of_constraints_exception&)
  {
    throw InputError("outline", "the rounded rims of opposite sides cross", "enlarge the dimensions of the part");
  }

  const std::vector<Eigen::Vector2d> polygon(points.begin(), points.begin() + n_corners);
  std::vector<std::array<unsigned int, 3>> triangles;
  for (const auto face : triangulation.finite_face_handles())
  {
    const std::array<unsigned int, 3> t{face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info()};
    if (is_inside(polygon, (points[t[0]] + points[t[1]] + points[t[2]]) / 3.))
      triangles.push_back(t);
  }
  return triangles;
}
} // namespace kedge
