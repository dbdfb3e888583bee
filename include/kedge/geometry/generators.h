// Parametric, watertight, rounded bodies for STL files. SI units; outward normals.
#pragma once

#include <kedge/bodies/surface.h>

namespace kedge
{
struct Rounding
{
  double radius = 0.;        ///< of convex edges, m; 0: sharp
  unsigned int segments = 4; ///< facets over a quarter turn of the rounding
};

/// Box with edges along the axes, centred at the origin; size in m.
TriangleMesh make_box(const Eigen::Vector3d& size, const Rounding& rounding);
/// Square plate of side b and thickness t (along x), centred at the origin.
TriangleMesh make_plate(double side, double thickness, const Rounding& rounding);
/// Frustum of a cone with its axis along x: major base (diameter D) at x = 0, minor base (d) at x = length.
TriangleMesh make_frustum(
  double major_diameter, double minor_diameter, double length, unsigned int sides, const Rounding& rounding);
/// Penetrometer: cylinder of given radius with a conical tip of the given full apex angle (degrees); axis along z, tip at
/// the origin pointing down, total length as given.
TriangleMesh make_cone(double radius, double apex_angle, double length, unsigned int sides, const Rounding& rounding);
/// Sphere centred at the origin, from a subdivided icosahedron.
TriangleMesh make_sphere(double radius, unsigned int subdivisions);
} // namespace kedge
