// Parametric, watertight, rounded bodies for STL files. SI units; outward normals. Rounding never changes the overall
// dimensions. Curved faces are inscribed: vertices lie on the true surface, so volumes converge from below with the
// square of the number of segments. Sizes that cannot be built throw InputError with the name of the parameter.
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
/// is the number of facets around the axis; the diameters along y and z are exact where 4 divides it. Rounded, the
/// largest diameter is still that of the wider base (the flank lies a little further out than on the sharp frustum),
/// while the narrower rim is rounded off inside its diameter.
TriangleMesh make_frustum(double major_diameter, double minor_diameter, double length, unsigned int sides,
                          const Rounding& rounding);

/// Penetrometer: cylinder of given radius with a conical tip of the given full apex angle (degrees); axis along z, tip
/// at the origin pointing down, total length as given (m). The tip is rounded to a sphere tangent to the cone whose
/// lowest point is the origin: the shoulder then sits lower than that of a sharp tip, while length and radius are kept.
TriangleMesh make_cone(double radius, double apex_angle, double length, unsigned int sides, const Rounding& rounding);

/// Sphere centred at the origin; `segments` facets over a quarter of a great circle, 8 segments^2 triangles.
TriangleMesh make_sphere(double radius, unsigned int segments);
} // namespace kedge
