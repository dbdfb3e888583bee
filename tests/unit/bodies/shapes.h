// Small closed meshes with known distances and volumes.
#pragma once

#include <kedge/bodies/surface.h>
#include <random>

namespace kedge::test
{
/// Points of a box, the same in every run.
class RandomPoints
{
public:
  RandomPoints(double lower, double upper) : uniform(lower, upper) {}
  Eigen::Vector3d operator()() { return {uniform(engine), uniform(engine), uniform(engine)}; }

private:
  std::mt19937 engine{1};
  std::uniform_real_distribution<double> uniform;
};

/// Box between two corners, two triangles per face.
inline TriangleMesh box(const Eigen::Vector3d& lower, const Eigen::Vector3d& upper)
{
  TriangleMesh mesh;
  for (unsigned int v = 0; v < 8; ++v) // bit d of v: lower or upper along axis d
    mesh.vertices.emplace_back(v & 1 ? upper[0] : lower[0], v & 2 ? upper[1] : lower[1], v & 4 ? upper[2] : lower[2]);
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

inline TriangleMesh unit_box() { return box(Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones()); }

/// An octahedron whose triangles are split in four and pushed to the sphere `subdivisions` times.
inline TriangleMesh sphere(double radius, unsigned int subdivisions)
{
  TriangleMesh mesh;
  for (int d = 0; d < 3; ++d)
    for (const double s : {1., -1.})
      mesh.vertices.push_back(s * radius * Eigen::Vector3d::Unit(d));
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (unsigned int s = 0; s < subdivisions; ++s)
  {
    TriangleMesh finer;
    for (const auto& [i, j, k] : mesh.triangles)
    {
      const Eigen::Vector3d a = mesh.vertices[i], b = mesh.vertices[j], c = mesh.vertices[k];
      const unsigned int n = finer.vertices.size();
      for (const Eigen::Vector3d& x : {a, b, c, Eigen::Vector3d(a + b), Eigen::Vector3d(b + c), Eigen::Vector3d(c + a)})
        finer.vertices.push_back(radius * x.normalized());
      finer.triangles.insert(finer.triangles.end(),
                             {{n, n + 3, n + 5}, {n + 3, n + 1, n + 4}, {n + 5, n + 4, n + 2}, {n + 3, n + 4, n + 5}});
    }
    mesh = merge_vertices(finer, 1e-12 * radius);
  }
  return mesh;
}

/// An L: the square of side 2 without its upper right quarter, extruded; concave edge at [1, 1].
inline TriangleMesh angle_section()
{
  return extrude_outline({{0., 0.}, {2., 0.}, {2., 1.}, {1., 1.}, {1., 2.}, {0., 2.}}, "outline");
}

/// Whether anything is left of a polygon that is clipped by the six faces of a box (Sutherland & Hodgman 1974).
inline bool crosses_by_clipping(std::vector<Eigen::Vector3d> polygon, const OrientedBox& box)
{
  for (int d = 0; d < 3; ++d)
    for (const double side : {-1., 1.})
    {
      const Eigen::Vector3d normal = side * box.axes.col(d);
      const auto height = [&](const Eigen::Vector3d& x) { return normal.dot(x - box.centre) - box.half_width[d]; };
      std::vector<Eigen::Vector3d> rest;
      for (std::size_t i = 0; i < polygon.size(); ++i)
      {
        const Eigen::Vector3d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
        const double ha = height(a), hb = height(b);
        if (ha <= 0.)
          rest.push_back(a);
        if (ha * hb < 0.)
          rest.push_back(a + ha / (ha - hb) * (b - a));
      }
      polygon = rest;
    }
  return !polygon.empty();
}
} // namespace kedge::test
