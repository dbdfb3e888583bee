#include "surface_tree.h"
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace kedge
{
using namespace surface_tree;

namespace
{
/// Corners of a triangle in the frame of a box centred at the origin.
using Triangle = std::array<Eigen::Vector3d, 3>;

/// Whether a triangle meets the box, by their 13 separating axes (Akenine-Moeller 2001,
/// doi 10.1080/10867651.2001.10487535). Edges along an axis give zero vectors, which separate nothing.
bool meets(const Triangle& triangle, const Eigen::Vector3d& half_width)
{
  const auto separates = [&](const Eigen::Vector3d& axis)
  {
    const double a = axis.dot(triangle[0]), b = axis.dot(triangle[1]), c = axis.dot(triangle[2]);
    return std::max(std::min({a, b, c}), -std::max({a, b, c})) > axis.cwiseAbs().dot(half_width);
  };
  for (unsigned int d = 0; d < 3; ++d)
  {
    const Eigen::Vector3d axis = Eigen::Vector3d::Unit(d);
    if (separates(axis))
      return false;
    for (unsigned int i = 0; i < 3; ++i)
      if (separates(axis.cross(triangle[(i + 1) % 3] - triangle[i])))
        return false;
  }
  return !separates((triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]));
}

/// Squared distance from the segment a-b to the box. It is the minimum along the segment of a convex, piecewise
/// quadratic function, whose slope is linear between the planes of the box's faces.
double squared_distance(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& half_width)
{
  const Eigen::Vector3d along = b - a;
  const auto outside = [&](const double t) -> Eigen::Vector3d
  {
    const Eigen::Vector3d x = a + t * along;
    return x - x.cwiseMax(-half_width).cwiseMin(half_width);
  };
  const auto slope = [&](const double t) { return along.dot(outside(t)); };
  // Where the segment passes the planes of the faces.
  std::array<double, 8> kinks{{0., 1.}};
  for (unsigned int d = 0; d < 3; ++d)
    for (unsigned int side = 0; side < 2; ++side)
    {
      const double t = ((side ? 1. : -1.) * half_width[d] - a[d]) / along[d];
      kinks[2 + 2 * d + side] = t > 0. && t < 1. ? t : 0.;
    }
  std::sort(kinks.begin(), kinks.end());
  // The minimum lies where the slope passes zero, or at an end.
  double before = slope(0.);
  if (before >= 0.)
    return outside(0.).squaredNorm();
  for (unsigned int k = 1; k < kinks.size(); ++k)
  {
    const double after = slope(kinks[k]);
    if (after >= 0.)
      return outside(kinks[k - 1] + (kinks[k] - kinks[k - 1]) * before / (before - after)).squaredNorm();
    before = after;
  }
  return outside(1.).squaredNorm();
}

/// Whether the triangle comes within a distance of the box. If they do not meet, the nearest points lie on an edge of
/// the triangle or at a corner of the box.
bool is_near(const Triangle& triangle, const Eigen::Vector3d& half_width, const double distance)
{
  if (meets(triangle, half_width))
    return true;
  const double limit = distance * distance;
  for (unsigned int i = 0; i < 3; ++i)
    if (squared_distance(triangle[i], triangle[(i + 1) % 3], half_width) <= limit)
      return true;
  const Facet facet{triangle[0], triangle[1] - triangle[0], triangle[2] - triangle[0], 0};
  for (unsigned int corner = 0; corner < 8; ++corner)
  {
    Eigen::Vector3d x = half_width;
    for (unsigned int d = 0; d < 3; ++d)
      if (corner & (1u << d))
        x[d] = -x[d];
    if ((project(facet, x).point - x).squaredNorm() <= limit)
      return true;
  }
  return false;
}

/// True only if the face normals of one of the two boxes show that the tree's box is farther away than the distance.
bool surely_farther(const Node& node, const OrientedBox& box, const Eigen::Matrix3d& absolute_axes,
                    const double distance)
{
  const Eigen::Vector3d between = 0.5 * (node.lower + node.upper) - box.centre;
  const Eigen::Vector3d half = 0.5 * (node.upper - node.lower);
  return (between.cwiseAbs() - half - absolute_axes * box.half_width).maxCoeff() > distance ||
         ((box.axes.transpose() * between).cwiseAbs() - box.half_width - absolute_axes.transpose() * half).maxCoeff() >
             distance;
}
} // namespace

bool Surface::comes_within(const OrientedBox& box, const double distance) const
{
  const Eigen::Matrix3d absolute_axes = box.axes.cwiseAbs();
  std::array<unsigned int, 64> stack; // the tree is balanced: 64 levels are never reached
  unsigned int size = 0;
  stack[size++] = 0;
  while (size > 0)
  {
    const unsigned int number = stack[--size];
    const Node& node = tree->nodes[number];
    if (surely_farther(node, box, absolute_axes, distance))
      continue;
    for (unsigned int f = node.first_facet; f < node.first_facet + node.n_facets; ++f)
    {
      const Facet& facet = tree->facets[f];
      const Eigen::Vector3d a = facet.a - box.centre;
      const Eigen::Matrix3d to_box = box.axes.transpose();
      if (is_near({to_box * a, to_box * (a + facet.ab), to_box * (a + facet.ac)}, box.half_width, distance))
        return true;
    }
    if (node.n_facets == 0)
    {
      stack[size++] = node.other;
      stack[size++] = number + 1;
    }
  }
  return false;
}
} // namespace kedge
