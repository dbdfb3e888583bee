#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <kedge/bodies/surface.h>
#include <limits>
#include <unordered_map>

namespace kedge
{
namespace
{
using Cell = std::array<std::int64_t, 3>;

struct CellHash
{
  std::size_t operator()(const Cell& cell) const
  {
    std::uint64_t hash = 0;
    for (const std::int64_t index : cell)
      hash = (hash ^ static_cast<std::uint64_t>(index)) * 0x9e3779b97f4a7c15ull + (hash >> 29);
    return hash;
  }
};

/// Numbers points so that points closer than the tolerance share a number. The cells of its grid are as wide as the
/// tolerance, so a neighbour can only lie in 27 of them.
class PointNumbering
{
public:
  explicit PointNumbering(double tolerance) : tolerance(tolerance) {}

  unsigned int operator()(const Eigen::Vector3d& x)
  {
    const Cell own = cell_of(x);
    if (tolerance > 0.)
      for (int i = -1; i <= 1; ++i)
        for (int j = -1; j <= 1; ++j)
          for (int k = -1; k <= 1; ++k)
            if (const auto found = find({own[0] + i, own[1] + j, own[2] + k}, x))
              return *found;
    if (const auto found = find(own, x))
      return *found;
    cells.emplace(own, static_cast<unsigned int>(points.size()));
    points.push_back(x);
    return points.size() - 1;
  }

  std::vector<Eigen::Vector3d> points;

private:
  Cell cell_of(const Eigen::Vector3d& x) const
  {
    Cell cell;
    for (int d = 0; d < 3; ++d)
      if (tolerance > 0.)
        cell[d] = static_cast<std::int64_t>(std::floor(x[d] / tolerance));
      else
        cell[d] = static_cast<std::int64_t>(std::hash<double>()(x[d]));
    return cell;
  }

  std::optional<unsigned int> find(const Cell& cell, const Eigen::Vector3d& x) const
  {
    const auto [begin, end] = cells.equal_range(cell);
    for (auto it = begin; it != end; ++it)
      if ((points[it->second] - x).norm() <= tolerance)
        return it->second;
    return std::nullopt;
  }

  double tolerance;
  std::unordered_multimap<Cell, unsigned int, CellHash> cells;
};
} // namespace

TriangleMesh merge_vertices(const TriangleMesh& mesh, double tolerance)
{
  // Most vertices of an STL repeat exactly. These need one look-up each instead of 27.
  PointNumbering exact(0.);
  std::vector<unsigned int> number;
  number.reserve(mesh.vertices.size());
  for (const Eigen::Vector3d& x : mesh.vertices)
    number.push_back(exact(x));
  if (tolerance > 0.)
  {
    PointNumbering close(tolerance);
    std::vector<unsigned int> joined;
    for (const Eigen::Vector3d& x : exact.points)
      joined.push_back(close(x));
    for (unsigned int& n : number)
      n = joined[n];
    exact.points = std::move(close.points);
  }

  TriangleMesh merged{std::move(exact.points), mesh.triangles};
  for (auto& triangle : merged.triangles)
    for (unsigned int& v : triangle)
      v = number[v];
  return merged;
}

std::array<Eigen::Vector3d, 2> bounds(const TriangleMesh& mesh)
{
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Eigen::Vector3d lower = Eigen::Vector3d::Constant(infinity), upper = -lower;
  for (const auto& triangle : mesh.triangles)
    for (const unsigned int v : triangle)
    {
      lower = lower.cwiseMin(mesh.vertices[v]);
      upper = upper.cwiseMax(mesh.vertices[v]);
    }
  return {lower, upper};
}

MassProperties mass_properties(const TriangleMesh& mesh)
{
  if (mesh.triangles.empty())
    return {0., 0., Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero()};

  // Integrate relative to a point of the mesh, so that a body far from the origin loses no digits.
  const Eigen::Vector3d origin = mesh.vertices[mesh.triangles[0][0]];
  double volume = 0., area = 0.;
  Eigen::Vector3d first_moment = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second_moment = Eigen::Matrix3d::Zero(); // integral of x x^T
  for (const auto& triangle : mesh.triangles)
  {
    const Eigen::Vector3d a = mesh.vertices[triangle[0]] - origin, b = mesh.vertices[triangle[1]] - origin,
                          c = mesh.vertices[triangle[2]] - origin, sum = a + b + c;
    const double v = a.dot(b.cross(c)) / 6.;
    volume += v;
    area += (b - a).cross(c - a).norm() / 2.;
    first_moment += v / 4. * sum;
    second_moment += v / 20. * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  const Eigen::Vector3d offset = first_moment / volume;
  second_moment -= volume * offset * offset.transpose();
  return {volume, area, origin + offset, second_moment.trace() * Eigen::Matrix3d::Identity() - second_moment};
}
} // namespace kedge
