// Triangles in a plane polygon.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace kedge
{
/// Constrained Delaunay triangles (counter-clockwise) of a simple polygon, whose corners are the first `n_corners`
/// points in order; the other points lie inside it. Throws InputError if its sides cross.
std::vector<std::array<unsigned int, 3>> triangulate_polygon(const std::vector<Eigen::Vector2d>& points,
                                                             unsigned int n_corners);

/// Whether x lies inside the closed polygon (even-odd rule).
bool is_inside(const std::vector<Eigen::Vector2d>& polygon, const Eigen::Vector2d& x);
} // namespace kedge
