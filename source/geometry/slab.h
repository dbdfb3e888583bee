// Rounded slabs: bodies with two planes of symmetry, an outline in the plane X-Y and a thickness across it. Both parts
// of an anchor are such bodies. Local axes: Y = 0 and Z = 0 are the planes of symmetry. SI units.
#pragma once

#include <functional>
#include <kedge/geometry/generators.h>
#include <vector>

namespace kedge
{
/// A corner of an outline and the radius of its fillet in the plane, m.
struct OutlineCorner
{
  Eigen::Vector2d position;
  double radius;
};

/// Boundary of the half Y >= 0 of an outline: chains that start and end at right angles on the axis Y = 0. Their order
/// and direction are those of a tour around the half with the material on the right; the axis joins each to the next.
using OutlineChains = std::vector<std::vector<Eigen::Vector2d>>;

/// The polyline through filleted corners. Straight sides have edges of at most `size` (m), fillets `segments` facets
/// per quarter turn. Throws InputError if neighbouring fillets overlap.
std::vector<Eigen::Vector2d> make_outline_chain(const std::vector<OutlineCorner>& corners, double size,
                                                unsigned int segments);

/// Triangulated outline. The thickness at a vertex is lift * h(position): the lift falls from 1 to 0 along a quarter
/// ellipse over the rim, so that every edge is round.
struct Planform
{
  std::vector<Eigen::Vector2d> positions;             ///< m
  std::vector<double> lift;                           ///< 0 on the outline to 1 inside the rim
  std::vector<std::array<unsigned int, 3>> triangles; ///< counter-clockwise in X-Y
};

/// A length or half thickness as a function of the position in the plane, m.
using PlaneFunction = std::function<double(const Eigen::Vector2d&)>;

/// Triangulates both halves of the outline, equal to the last bit. `rim_width` is the width of the rounding in the
/// plane (m); convex fillets must be 1.5 times as large. `size` is the length of the edges inside the rim.
Planform triangulate_outline(const OutlineChains& chains, const PlaneFunction& rim_width, double size,
                             unsigned int rim_segments);

/// Volume (m3) and its first moment along X (m4) of the body with half thickness h: linear in h.
Eigen::Vector2d volume_and_moment(const Planform& planform, const PlaneFunction& half_thickness);

/// Volume and centroid that the thickness of a body must give.
struct Solid
{
  double volume;   ///< m3
  double centroid; ///< X, m
};

/// Finds a and b such that a body with the half thickness `given` + a p + b q has the volume and centroid of `solid`.
/// Throws InputError if an edge then has a smaller radius than `least_radius` (m).
PlaneFunction fit_half_thickness(const Planform& planform, const PlaneFunction& given, const PlaneFunction& p,
                                 const PlaneFunction& q, const Solid& solid, const PlaneFunction& rim_width,
                                 double least_radius);

/// The closed surface of the slab, outwards, in X Y Z.
TriangleMesh thicken(const Planform& planform, const PlaneFunction& half_thickness);
} // namespace kedge
