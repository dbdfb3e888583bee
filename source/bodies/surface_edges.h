// Edges and normals of a closed mesh. The signed distance and the edge radius need them.
#pragma once

#include <kedge/bodies/surface.h>

namespace kedge
{
/// An edge of a closed mesh.
struct SurfaceEdge
{
  std::array<unsigned int, 2> vertices;  ///< in the order of the first triangle
  std::array<unsigned int, 2> triangles; ///< on either side
  std::array<unsigned int, 2> sides; ///< number 0..2 of the edge in each triangle; side i runs from corner i to i + 1
  double angle;                      ///< between the face normals, rad; positive where convex
};

/// Unit outward normal of every triangle.
std::vector<Eigen::Vector3d> face_normals(const TriangleMesh& mesh);

/// Radius (m) of the rounding that an edge belongs to: 0 if the edge is sharp, infinite if it does not count (see
/// Surface::sharpest_edge_radius). `angle` in rad, positive if convex; half widths of the two faces in m.
double rounding_radius(double angle, double half_width_0, double half_width_1);

/// All edges, each once. The mesh must be closed.
std::vector<SurfaceEdge> surface_edges(const TriangleMesh& mesh, const std::vector<Eigen::Vector3d>& normals);
} // namespace kedge
