// The surface of a rigid body in its own frame.
#pragma once

#include <Eigen/Core>
#include <array>
#include <kedge/bodies/triangle_tree.h>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace kedge
{
/// Closed triangulated surface, vertices merged, triangles oriented outwards.
struct TriangleMesh
{
  std::vector<Eigen::Vector3d> vertices;              ///< m
  std::vector<std::array<unsigned int, 3>> triangles; ///< vertex numbers, counter-clockwise seen from outside
};

/// Volume (m3), area (m2), centroid (m) and inertia tensor per unit density about the centroid (m5) of a closed mesh.
struct MassProperties
{
  double volume, area;
  Eigen::Vector3d centroid;
  Eigen::Matrix3d inertia;
};

/// Exact for the polyhedron: signed tetrahedra from the first vertex to every triangle.
MassProperties mass_properties(const TriangleMesh& mesh);

/// Lower and upper corner of the axis-aligned bounding box, m.
std::array<Eigen::Vector3d, 2> bounds(const TriangleMesh& mesh);

/// Joins vertices that are closer than `tolerance` (m; 0: equal ones only). A triangle that loses a corner remains and
/// repeats a vertex number.
TriangleMesh merge_vertices(const TriangleMesh& mesh, double tolerance);

/// Throws InputError(path, problem, remedy) unless the mesh is closed, manifold, oriented outwards and free of
/// degenerate triangles and self-intersections. The problem says where and begins with `name` (a file name, say).
/// Triangles lower than `resolution` (m) count as degenerate.
void check_surface(const TriangleMesh& mesh, const std::string& path, const std::string& name = "",
                   double resolution = 0.);

/// Two triangles that cross, and where.
struct Crossing
{
  std::array<unsigned int, 2> triangles;
  Eigen::Vector3d position;
};

/// A pair of triangles that cross or overlap, if there is one; shared vertices and edges do not count. Needs a closed,
/// manifold mesh. Uses exact predicates (CGAL).
std::optional<Crossing> find_crossing(const TriangleMesh& mesh);

/// Reads an ASCII or binary STL and joins all its solids, merges coincident vertices and checks the result with
/// check_surface(). Throws InputError with `json_path` in front.
TriangleMesh read_stl(const std::string& file, const std::string& json_path);

/// Writes binary STL: coordinates are rounded to single precision. Throws FileError.
void write_stl(const TriangleMesh& mesh, const std::string& file);

/// The outline with an arc of `radius` (m) in place of every convex corner. The arc touches both sides; its chords turn
/// by at most 22.5 degrees each, so they lie at most 0.02 radii inside it. Throws InputError with `json_path` in front
/// where a side is too short for the arcs at its ends.
std::vector<std::array<double, 2>> round_outline(const std::vector<std::array<double, 2>>& outline, double radius,
                                                 const std::string& json_path);

/// The prism that represents a plane-strain body. `outline` is a closed polygon of [x, z], in either direction and
/// without repeating the first point. It is extruded along y so far that a query at y = 0 never sees the end caps.
/// Throws InputError with `json_path` in front if the polygon is degenerate or crosses itself.
TriangleMesh extrude_outline(const std::vector<std::array<double, 2>>& outline, const std::string& json_path);

/// Surface::sharpest_edge_radius of the corners of an outline, m. The edges of the end caps, which soil never meets, do
/// not count.
double sharpest_corner_radius(const std::vector<std::array<double, 2>>& outline);

/// A box of any orientation in the frame of a surface. A half-width may be zero, as across the plane in plane strain.
struct OrientedBox
{
  Eigen::Vector3d centre;     ///< m
  Eigen::Matrix3d axes;       ///< columns: unit vectors along its edges
  Eigen::Vector3d half_width; ///< along the axes, m
};

/// Signed-distance queries against a closed mesh. A TriangleTree, built once, answers them. Queries are const and may
/// run in any number of threads.
class Surface
{
public:
  explicit Surface(TriangleMesh mesh);
  ~Surface();
  Surface(Surface&&) noexcept;
  Surface& operator=(Surface&&) noexcept;

  const TriangleMesh& mesh() const;
  /// Lower and upper corner of the axis-aligned bounding box, m.
  std::array<Eigen::Vector3d, 2> bounds() const;

  ClosestPoint closest_point(const Eigen::Vector3d& x) const;
  /// The closest point if gap <= distance, else nothing. This finds every point inside the body, however deep. A far
  /// point costs one comparison with the bounding box.
  std::optional<ClosestPoint> closest_point_within(const Eigen::Vector3d& x, double distance) const;
  /// The same result to the last digit, but faster: uses what the last query for this point left in `known`.
  std::optional<ClosestPoint> closest_point_within(const Eigen::Vector3d& x, double distance,
                                                   KnownDistance& known) const;
  /// Whether closest_point_within() finds something, in less time; at the very distance round-off may decide.
  bool is_within(const Eigen::Vector3d& x, double distance) const;
  /// A distance (m) that the gap at x is not below, from the bounding box and what the last query left in `known`; 0
  /// where these tell nothing.
  double least_gap(const Eigen::Vector3d& x, const KnownDistance& known = {}) const;
  /// What answers the next `n_queries` queries of kernels, in memory that they reach. It lives as long as the surface.
  TriangleTree for_kernels(std::size_t n_queries) const;
  /// Whether the distance from the surface (not from the solid) to the closed box is at most `distance`, m; exact up to
  /// round-off. A surface that crosses the box, or lies in it, is at distance zero.
  bool comes_within(const OrientedBox& box, double distance) const;

  /// Smallest radius (m) to which a convex edge is rounded. At an edge the normal turns by an angle a over the half
  /// widths d1, d2 of the two faces, so r = (d1 + d2) / (2 sin(a/2)); exact for circular arcs of at least two facets. A
  /// face more than three times as wide as the other one counts as flat and adds nothing. The radius is zero if an edge
  /// turns by more than 60 degrees, or if the normals around a convex vertex spread by more than 90 degrees. Edges that
  /// turn by less than 5 degrees do not count; without any other edge the radius is infinite.
  double sharpest_edge_radius() const;

private:
  struct Tree;
  std::unique_ptr<Tree> tree;
};
} // namespace kedge
