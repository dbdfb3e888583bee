#include "slab.h"

#include "profile.h"
#include "triangulation.h"
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <kedge/base/exceptions.h>
#include <limits>
#include <numeric>

namespace kedge
{
namespace
{
using Eigen::Vector2d;

/// Appends the points after the last one up to b, at equal distances of at most `size`.
void append_side(const Vector2d& b, double size, std::vector<Vector2d>& points)
{
  const Vector2d a = points.back();
  const unsigned int n = std::ceil((b - a).norm() / size - 1e-9);
  for (unsigned int i = 1; i < n; ++i)
    points.push_back(a + (b - a) * i / n);
  if (n > 0)
    points.push_back(b);
}

/// Unit vectors into the material at the points of a chain. The chain meets the axis at right angles, so the vectors at
/// its ends lie exactly along the axis.
std::vector<Vector2d> inward_normals(const std::vector<Vector2d>& chain)
{
  const auto right_of = [&](std::size_t i)
  {
    const Vector2d along = (chain[i + 1] - chain[i]).normalized();
    return Vector2d(along[1], -along[0]);
  };
  const std::size_t last = chain.size() - 1;
  std::vector<Vector2d> normals;
  for (std::size_t i = 0; i <= last; ++i)
    if (i == 0 || i == last)
      normals.emplace_back(std::copysign(1., right_of(i == 0 ? 0 : last - 1)[0]), 0.);
    else
      normals.push_back((right_of(i - 1) + right_of(i)).normalized());
  return normals;
}

/// Mirrors a half planform in the axis; vertices on it are shared.
void mirror(Planform& half)
{
  const std::size_t n = half.positions.size(), n_triangles = half.triangles.size();
  std::vector<unsigned int> image(n);
  for (unsigned int i = 0; i < n; ++i)
  {
    image[i] = i;
    if (half.positions[i][1] == 0.)
      continue;
    image[i] = half.positions.size();
    half.positions.emplace_back(half.positions[i][0], -half.positions[i][1]);
    half.lift.push_back(half.lift[i]);
  }
  for (std::size_t t = 0; t < n_triangles; ++t)
  {
    const auto [a, b, c] = half.triangles[t];
    half.triangles.push_back({image[a], image[c], image[b]});
  }
}

/// How far the rings reach inwards, in widths of the rim.
constexpr double rim_reach = 1.35;

/// Adds the strip between a chain and its inset: rings of vertices at equal angles of the quarter ellipse, and one more
/// ring on the flat part. With this one the triangles of the rounding do not depend on the filling of the inside.
/// Returns the vertices of the last ring.
std::vector<unsigned int> add_rim(const std::vector<Vector2d>& chain, const PlaneFunction& rim_width,
                                  unsigned int rings, Planform& planform)
{
  const std::vector<Vector2d> normals = inward_normals(chain);
  const unsigned int first = planform.positions.size(), n = chain.size();
  for (unsigned int ring = 0; ring <= rings + 1; ++ring)
  {
    const double angle = M_PI / 2. * std::min(ring, rings) / rings,
                 inset = ring <= rings ? 1. - std::cos(angle) : rim_reach;
    for (unsigned int i = 0; i < n; ++i)
    {
      planform.positions.push_back(chain[i] + inset * rim_width(chain[i]) * normals[i]);
      planform.lift.push_back(std::sin(angle)); // exactly 0 on the outline
      if (ring == 0 || i == 0)
        continue;
      const unsigned int d = first + ring * n + i, c = d - 1, a = c - n, b = d - n; // material to the right of a-b
      planform.triangles.push_back({a, c, b});
      planform.triangles.push_back({b, c, d});
    }
  }
  std::vector<unsigned int> innermost(n);
  std::iota(innermost.begin(), innermost.end(), first + (rings + 1) * n);
  return innermost;
}

double distance_to_segment(const Vector2d& x, const Vector2d& a, const Vector2d& b)
{
  const double s = std::clamp((x - a).dot(b - a) / (b - a).squaredNorm(), 0., 1.);
  return (x - a - s * (b - a)).norm();
}

/// Distance from the sides of a polygon, and the length that edges should have there: that of the nearby sides at
/// first, growing inwards up to `size`.
std::array<double, 2> distance_and_length(const std::vector<Vector2d>& polygon, const Vector2d& x, double size)
{
  constexpr double growth = 0.5;
  double distance = std::numeric_limits<double>::infinity(), length = size;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++)
  {
    const double d = distance_to_segment(x, polygon[i], polygon[j]);
    distance = std::min(distance, d);
    length = std::min(length, (polygon[j] - polygon[i]).norm() + growth * d);
  }
  return {distance, length};
}

/// Points inside a polygon: a triangular lattice of the given size that keeps a distance from the sides. Near short
/// sides it has also points of the halved and quartered lattices.
std::vector<Vector2d> lattice_points(const std::vector<Vector2d>& polygon, double size)
{
  Vector2d lower = polygon[0], upper = polygon[0];
  for (const Vector2d& x : polygon)
  {
    lower = lower.cwiseMin(x);
    upper = upper.cwiseMax(x);
  }
  std::vector<Vector2d> points;
  for (unsigned int level = 0; level < 3; ++level)
  {
    const double step = size / (1 << level), row_height = step * std::sqrt(0.75);
    for (unsigned int row = 0; lower[1] + row * row_height < upper[1]; ++row)
      for (unsigned int column = 0; lower[0] + column * step < upper[0]; ++column)
      {
        const bool in_coarser = level > 0 && row % 2 == 0 && (column + row / 2) % 2 == 0;
        const Vector2d x = lower + Vector2d((column + (row % 2) / 2.) * step, row * row_height);
        if (in_coarser || !is_inside(polygon, x))
          continue;
        const auto [distance, length] = distance_and_length(polygon, x, size);
        if (distance > 0.6 * step && (level == 0 || length < 1.5 * step))
          points.push_back(x);
      }
  }
  return points;
}

/// Fills a polygon of vertices with triangles of edge length up to `size`.
void fill(const std::vector<unsigned int>& polygon, double size, Planform& planform)
{
  std::vector<Vector2d> points;
  for (const unsigned int v : polygon)
    points.push_back(planform.positions[v]);
  std::vector<unsigned int> number = polygon;
  for (const Vector2d& x : lattice_points(points, size))
  {
    number.push_back(planform.positions.size());
    planform.positions.push_back(x);
    planform.lift.push_back(1.);
    points.push_back(x);
  }
  for (const auto& [a, b, c] : triangulate_polygon(points, polygon.size()))
    planform.triangles.push_back({number[a], number[b], number[c]});
}
} // namespace

std::vector<Vector2d> make_outline_chain(const std::vector<OutlineCorner>& corners, double size, unsigned int segments)
{
  std::vector<Vector2d> points{corners.front().position};
  for (std::size_t i = 1; i + 1 < corners.size(); ++i)
  {
    const CornerArc corner(corners[i - 1].position, corners[i].position, corners[i + 1].position, corners[i].radius);
    const std::vector<Vector2d> fillet = arc(corner.centre, -corners[i].radius * corner.inwards,
                                             corners[i].radius * corner.along, corner.angle, segments);
    const Vector2d side = corners[i].position - corners[i - 1].position;
    if ((fillet.front() - points.back()).dot(side) < -1e-9 * side.squaredNorm())
      throw InputError("outline",
                       fmt::format("the fillets at ({:g}, {:g}) and before it overlap", corners[i].position[0],
                                   corners[i].position[1]),
                       "enlarge the dimensions or reduce the radii");
    append_side(fillet.front(), size, points);
    points.insert(points.end(), fillet.begin() + 1, fillet.end());
  }
  append_side(corners.back().position, size, points);
  return points;
}

Planform triangulate_outline(const OutlineChains& chains, const PlaneFunction& rim_width, double size,
                             unsigned int rim_segments)
{
  Planform planform;
  std::vector<std::vector<unsigned int>> rings;
  for (const std::vector<Vector2d>& chain : chains)
    rings.push_back(add_rim(chain, rim_width, rim_segments, planform));
  std::vector<unsigned int> polygon;
  for (std::size_t i = 0; i < rings.size(); ++i)
  {
    polygon.insert(polygon.end(), rings[i].begin(), rings[i].end());
    std::vector<Vector2d> axis{planform.positions[rings[i].back()]};
    append_side(planform.positions[rings[(i + 1) % rings.size()].front()], size, axis);
    for (std::size_t j = 1; j + 1 < axis.size(); ++j)
    {
      polygon.push_back(planform.positions.size());
      planform.positions.push_back(axis[j]);
      planform.lift.push_back(1.);
    }
  }
  fill(polygon, size, planform);
  mirror(planform);
  return planform;
}

Vector2d volume_and_moment(const Planform& planform, const PlaneFunction& half_thickness)
{
  std::vector<double> z;
  for (std::size_t i = 0; i < planform.positions.size(); ++i)
    z.push_back(planform.lift[i] * half_thickness(planform.positions[i]));
  Vector2d integral = Vector2d::Zero();
  for (const auto& t : planform.triangles)
  {
    const Vector2d a = planform.positions[t[0]], u = planform.positions[t[1]] - a, v = planform.positions[t[2]] - a;
    const double area = (u[0] * v[1] - u[1] * v[0]) / 2.;
    double sum_z = 0., sum_x = 0., sum_xz = 0.;
    for (const unsigned int i : t)
    {
      sum_z += z[i];
      sum_x += planform.positions[i][0];
      sum_xz += planform.positions[i][0] * z[i];
    }
    integral += 2. * area *
                Vector2d(sum_z / 3., (sum_x * sum_z + sum_xz) / 12.); // exact for linear functions; both sides of Z = 0
  }
  return integral;
}

PlaneFunction fit_half_thickness(const Planform& planform, const PlaneFunction& given, const PlaneFunction& p,
                                 const PlaneFunction& q, const Solid& solid, const PlaneFunction& rim_width,
                                 double least_radius)
{
  Eigen::Matrix2d unit;
  unit << volume_and_moment(planform, p), volume_and_moment(planform, q);
  const Vector2d whole(solid.volume, solid.volume * solid.centroid);
  const Vector2d factors = unit.inverse() * (whole - volume_and_moment(planform, given));
  const PlaneFunction h = [=](const Vector2d& x) { return given(x) + factors[0] * p(x) + factors[1] * q(x); };
  for (std::size_t i = 0; i < planform.positions.size(); ++i)
  {
    if (planform.lift[i] == 1.)
      continue; // beyond the rim
    const Vector2d& x = planform.positions[i];
    // An ellipse with semi-axes a and b is sharpest at the end of the longer one: radius b^2 / a.
    const double thickness = h(x), radius = std::min(std::abs(thickness) * thickness / rim_width(x),
                                                     rim_width(x) * rim_width(x) / thickness);
    if (!(radius >= least_radius))
      throw InputError(
          "mass, centroid",
          fmt::format("they require a half thickness of {:.3g} m at ({:.3g}, {:.3g}), where edges would have "
                      "a radius below {:g} m",
                      thickness, x[0], x[1], least_radius),
          "change the outline, the mass or the centroid");
  }
  return h;
}

TriangleMesh thicken(const Planform& planform, const PlaneFunction& half_thickness)
{
  TriangleMesh mesh;
  std::vector<std::array<unsigned int, 2>> sides; // vertex above and below
  for (std::size_t i = 0; i < planform.positions.size(); ++i)
  {
    const Vector2d& x = planform.positions[i];
    const double z = planform.lift[i] * half_thickness(x);
    const unsigned int above = mesh.vertices.size();
    mesh.vertices.emplace_back(x[0], x[1], z);
    if (z > 0.)
      mesh.vertices.emplace_back(x[0], x[1], -z);
    sides.push_back({above, z > 0. ? above + 1 : above});
  }
  for (const auto& [a, b, c] : planform.triangles)
  {
    mesh.triangles.push_back({sides[a][0], sides[b][0], sides[c][0]});
    mesh.triangles.push_back({sides[a][1], sides[c][1], sides[b][1]});
  }
  return mesh;
}
} // namespace kedge
