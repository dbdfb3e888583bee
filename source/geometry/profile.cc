#include "profile.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kedge
{
namespace
{
/// Angle by which the profile turns at an inner point, rad.
double turning(const Profile& profile, std::size_t i)
{
  const Eigen::Vector2d u = profile[i] - profile[i - 1], v = profile[i + 1] - profile[i];
  return std::atan2(std::abs(u[0] * v[1] - u[1] * v[0]), u.dot(v));
}

/// Appends the points after a up to b. Halves the side while its facets are much longer than wide at their narrow end.
/// Flat ends, and sides that end on the axis, stay whole: they become fans of triangles.
void append_divided(const Eigen::Vector2d& a, const Eigen::Vector2d& b, unsigned int sides, Profile& points)
{
  constexpr double longest_aspect = 20.;
  const double width = 2. * M_PI / sides * std::min(a[1], b[1]);
  if (a[0] == b[0] || width == 0. || (b - a).norm() <= longest_aspect * width)
  {
    points.push_back(b);
    return;
  }
  const Eigen::Vector2d middle = (a + b) / 2.;
  append_divided(a, middle, sides, points);
  append_divided(middle, b, sides, points);
}
} // namespace

Profile arc(const Eigen::Vector2d& centre, const Eigen::Vector2d& start, const Eigen::Vector2d& end, double angle,
            unsigned int segments)
{
  // Round-off must not add a facet to an exact quarter turn.
  const unsigned int n = std::max(1., std::ceil(segments * angle / (M_PI / 2.) - 1e-9));
  Profile points;
  for (unsigned int i = 0; i <= n; ++i)
    points.push_back(centre + std::cos(angle * i / n) * start + std::sin(angle * i / n) * end);
  return points;
}

CornerArc::CornerArc(const Eigen::Vector2d& before, const Eigen::Vector2d& corner, const Eigen::Vector2d& after,
                     double radius)
{
  const Eigen::Vector2d v = (after - corner).normalized();
  along = (corner - before).normalized();
  angle = turning({before, corner, after}, 1);
  inwards = (v - along.dot(v) * along).normalized();
  centre = corner - radius * std::tan(angle / 2.) * along + radius * inwards;
}

Profile fillet(const Profile& profile, const Rounding& rounding)
{
  if (rounding.radius == 0.)
    return profile;
  const double r = rounding.radius;
  Profile rounded{profile.front()};
  for (std::size_t i = 1; i + 1 < profile.size(); ++i)
  {
    const CornerArc corner(profile[i - 1], profile[i], profile[i + 1], r);
    const Eigen::Vector2d &u = corner.along, &inwards = corner.inwards;
    const double angle = corner.angle;
    const auto append_arc = [&](const Eigen::Vector2d& start, const Eigen::Vector2d& end, double angle)
    {
      const Profile points = arc(corner.centre, r * start, r * end, angle, rounding.segments);
      rounded.insert(rounded.end(), points.begin(), points.end());
    };
    // A vertex at the widest point of the arc makes the diameter exact.
    const double to_widest = std::atan2(u[1], u[0]);
    if (to_widest > 1e-9 && to_widest < angle - 1e-9)
    {
      append_arc(-inwards, u, to_widest);
      append_arc({0., 1.}, {1., 0.}, angle - to_widest);
    }
    else
      append_arc(-inwards, u, angle);
  }
  rounded.push_back(profile.back());
  // A fillet that uses its whole side ends where the next one begins, up to round-off.
  const auto coincide = [r](const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return (a - b).norm() < 1e-9 * r; };
  rounded.erase(std::unique(rounded.begin(), rounded.end(), coincide), rounded.end());
  rounded.back() = profile.back();
  return rounded;
}

double largest_fillet(const Profile& profile)
{
  double largest = std::numeric_limits<double>::infinity(), tangent_before = 0.;
  for (std::size_t i = 1; i < profile.size(); ++i)
  {
    const double tangent = i + 1 < profile.size() ? std::tan(turning(profile, i) / 2.) : 0.;
    largest = std::min(largest, (profile[i] - profile[i - 1]).norm() / (tangent_before + tangent));
    tangent_before = tangent;
  }
  return largest;
}

Profile shorten_facets(const Profile& profile, unsigned int sides)
{
  Profile divided{profile.front()};
  for (std::size_t i = 1; i < profile.size(); ++i)
    append_divided(profile[i - 1], profile[i], sides, divided);
  return divided;
}
} // namespace kedge
