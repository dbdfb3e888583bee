#include <kedge/geometry/generators.h>

#include "profile.h"
#include <Eigen/Geometry>
#include <cmath>
#include <fmt/format.h>
#include <kedge/base/exceptions.h>

namespace kedge
{
namespace
{
using Eigen::Vector3d;

/// Triangles of a convex body. Each is oriented away from a point inside the body. Triangles without area, as in the
/// strip of a rounding of radius zero, are left out.
class ConvexSoup
{
public:
  explicit ConvexSoup(const Vector3d& inside) : inside(inside) {}

  void add_triangle(const Vector3d& a, const Vector3d& b, const Vector3d& c)
  {
    if (a == b || b == c || c == a)
      return;
    const bool outwards = (b - a).cross(c - a).dot((a + b + c) / 3. - inside) > 0.;
    const unsigned int first = soup.vertices.size();
    soup.vertices.insert(soup.vertices.end(), {a, outwards ? b : c, outwards ? c : b});
    soup.triangles.push_back({first, first + 1, first + 2});
  }

  /// Corners in order around the quadrilateral.
  void add_quadrilateral(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d)
  {
    add_triangle(a, b, c);
    add_triangle(a, c, d);
  }

  TriangleMesh joined() const { return merge_vertices(soup, 0.); }

private:
  Vector3d inside;
  TriangleMesh soup;
};

void require_positive(const std::string& name, double value)
{
  if (!(value > 0.) || !std::isfinite(value))
    throw InputError(name, fmt::format("{:g} m is not a size", value), "give a positive length");
}

void require_rounding(const Rounding& rounding, double largest_radius)
{
  if (!(rounding.radius >= 0.) || !(rounding.radius <= largest_radius))
    throw InputError("edge radius", fmt::format("{:g} m does not fit the body", rounding.radius),
                     fmt::format("use 0 to {:g} m", largest_radius));
  if (rounding.segments == 0)
    throw InputError("edge segments", "a rounding cannot have 0 facets", "use at least 1");
}

void require_sides(unsigned int sides)
{
  if (sides < 3)
    throw InputError("sides", fmt::format("{} facets around the axis enclose nothing", sides), "use at least 3");
}

/// Direction (i, j, k), with n = i + j + k, in an octant of the unit sphere. Along the octant's sides angles are equal.
Vector3d octant_direction(unsigned int i, unsigned int j, unsigned int k)
{
  const double quarter = M_PI / 2. / (i + j + k);
  return Vector3d(std::sin(quarter * i), std::sin(quarter * j), std::sin(quarter * k)).normalized();
}

/// Revolves a profile, which starts and ends on the axis, about z.
TriangleMesh revolve(const Profile& profile, unsigned int sides)
{
  const auto point = [&](const Eigen::Vector2d& x, unsigned int side)
  {
    const double angle = 2. * M_PI * (side % sides) / sides;
    return Vector3d(x[1] * std::cos(angle), x[1] * std::sin(angle), x[0]);
  };
  ConvexSoup soup(Vector3d(0., 0., (profile.front()[0] + profile.back()[0]) / 2.));
  for (std::size_t ring = 0; ring + 1 < profile.size(); ++ring)
    for (unsigned int side = 0; side < sides; ++side)
      soup.add_quadrilateral(point(profile[ring], side), point(profile[ring], side + 1),
                             point(profile[ring + 1], side + 1), point(profile[ring + 1], side));
  return soup.joined();
}

/// The surface on which a sphere rolls around a box: corners, edges and faces. The box is shrunk by the sphere's
/// radius.
class RoundedBox
{
public:
  RoundedBox(const Vector3d& size, const Rounding& rounding)
      : inner(size / 2. - Vector3d::Constant(rounding.radius)), radius(rounding.radius), n(rounding.segments)
  {
  }

  /// An octant of a sphere at the corner on the sides given by the signs.
  void add_corner(const Vector3d& signs, ConvexSoup& soup) const
  {
    const auto at = [&](unsigned int i, unsigned int j) { return point(signs, octant_direction(i, j, n - i - j)); };
    for (unsigned int i = 0; i < n; ++i)
      for (unsigned int j = 0; i + j < n; ++j)
      {
        soup.add_triangle(at(i, j), at(i + 1, j), at(i, j + 1));
        if (i + j + 1 < n)
          soup.add_triangle(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
      }
  }

  /// A quarter cylinder along an axis, on the sides given by the signs across it.
  void add_edge(int axis, double second_sign, double third_sign, ConvexSoup& soup) const
  {
    const auto at = [&](double end, unsigned int m)
    {
      std::array<unsigned int, 3> index{};
      index[(axis + 1) % 3] = m;
      index[(axis + 2) % 3] = n - m;
      return point(signs(axis, end, second_sign, third_sign), octant_direction(index[0], index[1], index[2]));
    };
    for (unsigned int m = 0; m < n; ++m)
      soup.add_quadrilateral(at(-1., m), at(1., m), at(1., m + 1), at(-1., m + 1));
  }

  /// The flat rectangle across an axis.
  void add_face(int axis, double sign, ConvexSoup& soup) const
  {
    const auto at = [&](double second, double third)
    { return point(signs(axis, sign, second, third), Vector3d::Unit(axis)); };
    soup.add_quadrilateral(at(-1., -1.), at(1., -1.), at(1., 1.), at(-1., 1.));
  }

private:
  static Vector3d signs(int axis, double first, double second, double third)
  {
    Vector3d signs;
    signs[axis] = first;
    signs[(axis + 1) % 3] = second;
    signs[(axis + 2) % 3] = third;
    return signs;
  }

  Vector3d point(const Vector3d& signs, const Vector3d& direction) const
  {
    return signs.cwiseProduct(inner + radius * direction);
  }

  Vector3d inner;
  double radius;
  unsigned int n;
};
} // namespace

TriangleMesh make_box(const Vector3d& size, const Rounding& rounding)
{
  for (int d = 0; d < 3; ++d)
    require_positive("size", size[d]);
  require_rounding(rounding, size.minCoeff() / 2.);

  const RoundedBox box(size, rounding);
  ConvexSoup soup(Vector3d::Zero());
  for (const double s : {-1., 1.})
    for (const double t : {-1., 1.})
    {
      box.add_corner({s, t, -1.}, soup);
      box.add_corner({s, t, 1.}, soup);
      for (int axis = 0; axis < 3; ++axis)
        box.add_edge(axis, s, t, soup);
    }
  for (int axis = 0; axis < 3; ++axis)
    for (const double s : {-1., 1.})
      box.add_face(axis, s, soup);
  return soup.joined();
}

TriangleMesh make_plate(double side, double thickness, const Rounding& rounding)
{
  require_positive("side", side);
  require_positive("thickness", thickness);
  return make_box({thickness, side, side}, rounding);
}

TriangleMesh make_sphere(double radius, unsigned int segments)
{
  require_positive("radius", radius);
  return make_box(Vector3d::Constant(2. * radius), {radius, segments});
}

namespace
{
/// Radius F of a sharp frustum at its wider base for which the rounded rim has radius R: F = R - r + y with
/// y = r (s + sqrt(1 + s^2)), the slope s = (F - narrow radius) / length of the flank and the rounding radius r <=
/// length / 2. Infinite where the flank would lie across the axis.
double flank_radius(double wide, double narrow, double length, double rounding_radius)
{
  if (rounding_radius == 0.)
    return wide;
  // a y^2 - b y = r^2
  const double w = wide - rounding_radius - narrow;
  const double a = 1. - 2. * rounding_radius / length, b = 2. * rounding_radius * w / length;
  const double root = std::sqrt(b * b + 4. * a * rounding_radius * rounding_radius);
  const double y = b > 0. ? (b + root) / (2. * a) : 2. * rounding_radius * rounding_radius / (root - b);
  return wide - rounding_radius + y;
}
} // namespace

TriangleMesh make_frustum(double major_diameter, double minor_diameter, double length, unsigned int sides,
                          const Rounding& rounding)
{
  require_positive("major diameter", major_diameter);
  require_positive("minor diameter", minor_diameter);
  require_positive("length", length);
  require_sides(sides);
  const double wide = std::max(major_diameter, minor_diameter) / 2.,
               narrow = std::min(major_diameter, minor_diameter) / 2.;
  require_rounding(rounding, length / 2.); // both rims' share of the flank
  const double flank = flank_radius(wide, narrow, length, rounding.radius);
  if (!std::isfinite(flank))
    throw InputError("edge radius", fmt::format("{:g} m leaves no flank between the rims", rounding.radius),
                     fmt::format("use less than {:g} m", rounding.radius));
  const bool narrows = major_diameter >= minor_diameter;
  const Profile sharp{{0., 0.}, {0., narrows ? flank : narrow}, {length, narrows ? narrow : flank}, {length, 0.}};
  require_rounding(rounding, largest_fillet(sharp));
  TriangleMesh mesh = revolve(shorten_facets(fillet(sharp, rounding), sides), sides);
  for (Vector3d& x : mesh.vertices) // z -> x keeps the handedness when x -> y and y -> z
    x = Vector3d(x[2], x[0], x[1]);
  return mesh;
}

TriangleMesh make_cone(double radius, double apex_angle, double length, unsigned int sides, const Rounding& rounding)
{
  require_positive("radius", radius);
  require_positive("length", length);
  require_sides(sides);
  if (!(apex_angle > 1. && apex_angle < 179.))
    throw InputError("apex angle", fmt::format("{:g} degrees does not give a cone", apex_angle),
                     "use 1 to 179 degrees");
  const double half = apex_angle / 2. * M_PI / 180., r = rounding.radius;
  require_rounding(rounding, radius / 2.);

  // The tip is a sphere of radius r that touches the origin; from here on the cone is tangent to it.
  const Eigen::Vector2d tangent_point(r - r * std::sin(half), r * std::cos(half));
  const double shoulder = tangent_point[0] + (radius - tangent_point[1]) / std::tan(half);
  if (length <= shoulder)
    throw InputError("length", fmt::format("{:g} m ends below the shoulder of the tip at {:g} m", length, shoulder),
                     "use a longer penetrometer");
  const Profile sharp{tangent_point, {shoulder, radius}, {length, radius}, {length, 0.}};
  require_rounding(rounding, largest_fillet(sharp));
  Profile profile;
  if (r > 0.)
    profile = arc({r, 0.}, {-r, 0.}, {0., r}, M_PI / 2. - half, rounding.segments);
  const Profile rest = fillet(sharp, rounding);
  profile.insert(profile.end(), rest.begin() + (r > 0.), rest.end());
  return revolve(shorten_facets(profile, sides), sides);
}
} // namespace kedge
