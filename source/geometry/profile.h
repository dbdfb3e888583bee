// Profiles of bodies of revolution: points (along the axis, radius), m.
#pragma once

#include <Eigen/Core>
#include <kedge/geometry/generators.h>
#include <vector>

namespace kedge
{
using Profile = std::vector<Eigen::Vector2d>;

/// Points of the arc centre + start cos(a) + end sin(a), a from 0 to `angle` (rad), with `segments` facets per quarter
/// turn.
Profile arc(const Eigen::Vector2d& centre, const Eigen::Vector2d& start, const Eigen::Vector2d& end, double angle,
            unsigned int segments);

/// The profile with every inner corner rounded by an arc tangent to both of its sides.
Profile fillet(const Profile& profile, const Rounding& rounding);

/// Largest radius for which the arcs of neighbouring corners do not overlap.
double largest_fillet(const Profile& profile);

/// Divides long slanted or straight sides so that the triangles of a body with `sides` facets around its axis stay
/// compact.
Profile shorten_facets(const Profile& profile, unsigned int sides);
} // namespace kedge
