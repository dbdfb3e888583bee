// The surface of a rigid body in its own frame.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <string>
#include <vector>

namespace kedge
{
/// Closed triangulated surface, vertices merged, triangles oriented outwards.
struct TriangleMesh
{
  std::vector<Eigen::Vector3d> vertices;            ///< m
  std::vector<std::array<unsigned int, 3>> triangles; ///< vertex numbers, counter-clockwise seen from outside
};

/// Volume (m3), area (m2), centroid (m) and inertia tensor per unit density about the centroid (m5) of a closed mesh.
struct MassProperties
{
  double volume, area;
  Eigen::Vector3d centroid;
  Eigen::Matrix3d inertia;
};
MassProperties mass_properties(const TriangleMesh& mesh);

/// Reads an ASCII or binary STL, merges coincident vertices and checks that it is closed, manifold, oriented outwards and
/// free of self-intersections. Throws InputError with `json_path` in front and says where (coordinates) it fails.
TriangleMesh read_stl(const std::string& file, const std::string& json_path);

/// Writes binary STL. Throws FileError.
void write_stl(const TriangleMesh& mesh, const std::string& file);

/// Part of the surface that holds a closest point.
enum class Feature
{
  face,
  edge,
  vertex
};

struct ClosestPoint
{
  double gap;              ///< signed distance, m; negative inside
  Eigen::Vector3d point;   ///< on the surface
  Eigen::Vector3d normal;  ///< unit, outwards: d gap / d x
  Feature feature;         ///< face, edge or vertex
  Eigen::Vector3d tangent; ///< direction of the edge where feature is edge, else zero
  unsigned int triangle;   ///< one triangle that holds the point
};

/// Signed-distance queries against a closed mesh by an AABB tree; the tree is built once.
/// Sign by angle-weighted pseudo-normals (Baerentzen & Aanaes 2005, doi 10.1109/TVCG.2005.49).
class Surface
{
public:
  explicit Surface(TriangleMesh mesh);
  ~Surface();
  Surface(Surface&&) noexcept;
  Surface& operator=(Surface&&) noexcept;

  const TriangleMesh& mesh() const;
  ClosestPoint closest_point(const Eigen::Vector3d& x) const;
  /// Lower and upper corner of the axis-aligned bounding box.
  std::array<Eigen::Vector3d, 2> bounds() const;
  /// Smallest radius to which a convex edge is rounded, estimated from dihedral angles and triangle sizes: for each
  /// convex edge with angle a between its face normals, r = (distance between the centroid heights) / a. Edges flatter
  /// than 5 degrees do not count; infinity if none.
  double sharpest_edge_radius() const;

private:
  struct Tree;
  std::unique_ptr<Tree> tree;
};
} // namespace kedge
