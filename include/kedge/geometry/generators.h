// Parametric, watertight, rounded bodies for STL files. SI units; outward normals. Rounding does not change the overall
// dimensions. The vertices of curved faces lie on the true surface, so the volume converges from below, with the square
// of the number of segments. Impossible sizes throw InputError with the name of the parameter.
#pragma once

#include <kedge/bodies/surface.h>

namespace kedge
{
/// Circular rounding of convex edges.
struct Rounding
{
  double radius = 0.;        ///< m; 0: sharp
  unsigned int segments = 4; ///< facets over a quarter turn
};

/// Box with edges along the axes, centred at the origin; size in m. Rounded edges, spherical corners.
TriangleMesh make_box(const Eigen::Vector3d& size, const Rounding& rounding);

/// Square plate of side b and thickness t (along x), centred at the origin, m.
TriangleMesh make_plate(double side, double thickness, const Rounding& rounding);

/// Frustum of a cone with its axis along x: major base (diameter D) at x = 0, minor base (d) at x = length, m. `sides`
/// is the number of facets around the axis; the diameters along y and z are exact if 4 divides it. A rounded frustum
/// keeps the diameter of its wider base, so its flank lies slightly outside that of the sharp one. The rounding of the
/// narrower rim lies inside its diameter.
TriangleMesh make_frustum(double major_diameter, double minor_diameter, double length, unsigned int sides,
                          const Rounding& rounding);

/// Penetrometer: cylinder of the given radius with a conical tip of the given full apex angle (degrees) and the given
/// total length (m). The axis is along z; the tip points down and ends at the origin. A rounded tip is a sphere tangent
/// to the cone. Length and radius stay the same, so the shoulder is lower than with a sharp tip.
TriangleMesh make_cone(double radius, double apex_angle, double length, unsigned int sides, const Rounding& rounding);

/// Sphere centred at the origin; `segments` facets over a quarter of a great circle, 8 segments^2 triangles.
TriangleMesh make_sphere(double radius, unsigned int segments);
} // namespace kedge
