#include "surface_crossing.h"
#include "surface_edges.h"

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
using Point = std::array<double, 2>;

/// Twice the signed area of a triangle; positive where a, b, c turn left.
double turn(const Point& a, const Point& b, const Point& c)
{
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

double distance(const Point& a, const Point& b) { return std::hypot(b[0] - a[0], b[1] - a[1]); }

/// Twice the area of a triangle that is none, m2: points along a slanted side lie on one line but for round-off, which
/// must not make corners of them.
double next_to_none(const Point& a, const Point& b, const Point& c)
{
  const double longest = std::max({distance(a, b), distance(b, c), distance(c, a)});
  const double farthest = std::max({std::hypot(a[0], a[1]), std::hypot(b[0], b[1]), std::hypot(c[0], c[1])});
  return 8. * std::numeric_limits<double>::epsilon() * (longest + farthest) * longest;
}

bool turns_left(const Point& a, const Point& b, const Point& c) { return turn(a, b, c) > next_to_none(a, b, c); }

/// On the sides, too.
bool holds(const Point& a, const Point& b, const Point& c, const Point& x)
{
  const double least = -next_to_none(a, b, c);
  return turn(a, b, x) >= least && turn(b, c, x) >= least && turn(c, a, x) >= least;
}

/// Triangulates a simple, counter-clockwise polygon by cutting ears. The list is incomplete if no ear is left before
/// the end, as in a polygon that crosses itself. A corner that turns left never comes to turn right, so only those that
/// do not turn left at the start can lie in an ear.
std::vector<std::array<unsigned int, 3>> cut_ears(const std::vector<Point>& polygon)
{
  std::vector<unsigned int> rest(polygon.size()), inward;
  std::iota(rest.begin(), rest.end(), 0u);
  std::vector<std::array<unsigned int, 3>> triangles;
  const auto corners = [&](std::size_t i)
  {
    const std::size_t n = rest.size();
    return std::array<unsigned int, 3>{rest[(i + n - 1) % n], rest[i], rest[(i + 1) % n]};
  };
  for (std::size_t i = 0; i < rest.size(); ++i)
    if (const auto [a, b, c] = corners(i); !turns_left(polygon[a], polygon[b], polygon[c]))
      inward.push_back(b);
  const auto is_ear = [&](const std::array<unsigned int, 3>& ear)
  {
    const Point &a = polygon[ear[0]], &b = polygon[ear[1]], &c = polygon[ear[2]];
    return turns_left(a, b, c) &&
           std::none_of(inward.begin(), inward.end(),
                        [&](unsigned int v)
                        { return v != ear[0] && v != ear[1] && v != ear[2] && holds(a, b, c, polygon[v]); });
  };
  for (std::size_t i = 0; rest.size() > 2 && i < rest.size();)
    if (is_ear(corners(i)))
    {
      triangles.push_back(corners(i));
      if (const auto gone = std::find(inward.begin(), inward.end(), rest[i]); gone != inward.end())
        inward.erase(gone);
      rest.erase(rest.begin() + i);
      i = i > 0 ? i - 1 : 0; // the corner before may be an ear now
    }
    else
      ++i;
  return triangles;
}

std::string text_of(const Point& x) { return fmt::format("[{:.6g}, {:.6g}]", x[0], x[1]); }

/// Twice the area; positive where the outline runs counter-clockwise.
double twice_area(const std::vector<Point>& outline)
{
  double area = 0.;
  for (std::size_t i = 0; i < outline.size(); ++i)
    area += turn(outline[0], outline[i], outline[(i + 1) % outline.size()]);
  return area;
}

/// Angle by which the outline turns at b, rad; `sense` is 1 where left turns are positive, -1 where right ones are.
double corner_angle(const Point& a, const Point& b, const Point& c, const double sense)
{
  const double along = (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]);
  return std::atan2(sense * turn(a, b, c), along);
}

void check_points(const std::vector<Point>& outline, const std::string& json_path)
{
  const std::size_t n = outline.size();
  if (n < 3)
    throw InputError(json_path, fmt::format("an outline of {} points encloses nothing", n),
                     "give at least three points");
  double length = 0.;
  for (std::size_t i = 0; i < n; ++i)
    length += distance(outline[i], outline[(i + 1) % n]);
  for (std::size_t i = 0; i < n; ++i)
  {
    const Point &a = outline[i], &b = outline[(i + 1) % n];
    if (distance(a, b) <= 1e-9 * length) // the same but for round-off
      throw InputError(json_path, "the outline repeats the point " + text_of(a),
                       "remove one; the outline closes by itself");
  }
}

void check_outline(const std::vector<Point>& outline, const std::string& json_path)
{
  check_points(outline, json_path);
  const std::size_t n = outline.size();
  if (const auto touching = find_touching_sides(outline))
  {
    const auto [i, j] = *touching;
    throw InputError(
        json_path,
        fmt::format("the outline crosses or touches itself: the side from {} to {} and the side from {} to {}",
                    text_of(outline[i]), text_of(outline[(i + 1) % n]), text_of(outline[j]),
                    text_of(outline[(j + 1) % n])),
        "order the points along the outline and remove points that lie on another side");
  }
}
} // namespace

double sharpest_corner_radius(const std::vector<Point>& outline)
{
  const std::size_t n = outline.size();
  const double sense = std::copysign(1., twice_area(outline));
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < n; ++i)
  {
    const Point &a = outline[(i + n - 1) % n], &b = outline[i], &c = outline[(i + 1) % n];
    smallest =
        std::min(smallest, rounding_radius(corner_angle(a, b, c, sense), distance(a, b) / 2., distance(b, c) / 2.));
  }
  return smallest;
}

std::vector<Point> round_outline(const std::vector<Point>& outline, const double radius, const std::string& json_path)
{
  if (radius == 0.)
    return outline;
  check_points(outline, json_path); // a corner that is given twice turns by no angle
  const std::size_t n = outline.size();
  const double sense = std::copysign(1., twice_area(outline));
  std::vector<double> angles(n); // of the arcs, rad; 0 at corners that stay
  for (std::size_t i = 0; i < n; ++i)
    angles[i] = std::max(0., corner_angle(outline[(i + n - 1) % n], outline[i], outline[(i + 1) % n], sense));
  for (std::size_t i = 0; i < n; ++i)
  {
    const Point &a = outline[i], &b = outline[(i + 1) % n];
    const double tangents = std::tan(angles[i] / 2.) + std::tan(angles[(i + 1) % n] / 2.), length = distance(a, b);
    if (radius * tangents > length * (1. + 1e-9))
      throw InputError(json_path + ".edge radius",
                       fmt::format("the side from {} to {}, {:.4g} m long, is too short for arcs of {:.4g} m",
                                   text_of(a), text_of(b), length, radius),
                       fmt::format("give at most {:.4g}, or lengthen the side", length / tangents));
  }

  std::vector<Point> rounded;
  const auto add = [&](const Point& x)
  {
    // arcs that use up a side share a point, up to round-off
    if (rounded.empty() || distance(rounded.back(), x) > 1e-9 * radius)
      rounded.push_back(x);
  };
  for (std::size_t i = 0; i < n; ++i)
  {
    const Point &before = outline[(i + n - 1) % n], &corner = outline[i];
    if (angles[i] == 0.)
    {
      add(corner);
      continue;
    }
    const double length = distance(before, corner), tangent = radius * std::tan(angles[i] / 2.);
    const Point along{(corner[0] - before[0]) / length, (corner[1] - before[1]) / length};
    const Point inwards{-sense * along[1], sense * along[0]};
    const double chords = std::max(1., std::ceil(angles[i] / (M_PI / 8.) - 1e-9)); // round-off must not add one
    for (int k = 0; k <= chords; ++k)
    {
      const double angle = angles[i] * k / chords;
      const double forwards = radius * std::sin(angle) - tangent, sideways = radius * (1. - std::cos(angle));
      add({corner[0] + forwards * along[0] + sideways * inwards[0],
           corner[1] + forwards * along[1] + sideways * inwards[1]});
    }
  }
  if (distance(rounded.back(), rounded.front()) <= 1e-9 * radius)
    rounded.pop_back();
  return rounded;
}

TriangleMesh extrude_outline(const std::vector<Point>& outline, const std::string& json_path)
{
  check_outline(outline, json_path);
  const std::size_t n = outline.size();
  double size = 0.;
  for (const Point& x : outline)
    size = std::max({size, std::abs(x[0] - outline[0][0]), std::abs(x[1] - outline[0][1])});
  std::vector<Point> polygon = outline;
  if (twice_area(outline) < 0.)
    polygon.assign(outline.rbegin(), outline.rend());
  const std::vector<std::array<unsigned int, 3>> cap = cut_ears(polygon);
  if (cap.size() + 2 != n)
    throw InputError(json_path, "the outline encloses next to no area", "move its points apart");

  // An inner point is no farther from the sides than `size`, so caps at this distance are never nearest.
  const double half_width = 4. * size;
  TriangleMesh mesh;
  for (const double y : {-half_width, half_width})
    for (const Point& x : polygon)
      mesh.vertices.emplace_back(x[0], y, x[1]);
  // Two triangles per side, then both caps.
  const auto front = [](std::size_t i) { return static_cast<unsigned int>(i); };
  const auto back = [n](std::size_t i) { return static_cast<unsigned int>(n + i); };
  for (std::size_t i = 0; i < n; ++i)
  {
    const std::size_t j = (i + 1) % n;
    mesh.triangles.push_back({front(i), back(j), front(j)});
    mesh.triangles.push_back({front(i), back(i), back(j)});
  }
  for (const auto& [a, b, c] : cap)
  {
    mesh.triangles.push_back({front(a), front(b), front(c)});
    mesh.triangles.push_back({back(a), back(c), back(b)});
  }
  check_connections(mesh, json_path, "the extruded outline");
  return mesh;
}
} // namespace kedge
