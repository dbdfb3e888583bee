// The axes of plane strain, which lies in the plane y = 0 of the three-dimensional world of the bodies.
//
// In 2-D the analysis has the axes x and z. Stored vectors and tensors still have three axes, in the order x, z and y,
// where y is the direction out of the plane.
#pragma once

#include <Eigen/Core>
#include <array>

namespace kedge
{
/// World axis of a component along axis `component` of the analysis.
constexpr unsigned int world_axis(const unsigned int dim, const unsigned int component)
{
  return dim == 2 && component == 1 ? 2 : component;
}

/// Which stored axis is the world's x, y, z.
template <int dim> constexpr std::array<unsigned int, 3> stored_axis = {{0, dim == 3 ? 1 : 2, dim == 3 ? 2 : 1}};

/// Which stored entry of a symmetric tensor is the world's xx, yy, zz, xy, yz, xz.
template <int dim>
constexpr std::array<unsigned int, 6> stored_entry = {
    {0, dim == 3 ? 1 : 2, dim == 3 ? 2 : 1, dim == 3 ? 3 : 5, 4, dim == 3 ? 5 : 3}};

/// A point of the analysis (dim coordinates, any type with operator[]) in the world.
template <int dim, typename Point> Eigen::Vector3d to_world(const Point& x)
{
  return dim == 3 ? Eigen::Vector3d(x[0], x[1], x[dim - 1]) : Eigen::Vector3d(x[0], 0., x[1]);
}
} // namespace kedge
