// Profiles of bodies of revolution. Points have the coordinates (along the axis, radius), m.
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

/// The arc that rounds the corner between two straight sides.
struct CornerArc
{
  CornerArc(const Eigen::Vector2d& before, const Eigen::Vector2d& corner, const Eigen::Vector2d& after, double radius);

  double angle;            ///< by which the sides turn, rad
  Eigen::Vector2d along;   ///< unit direction of the first side
  Eigen::Vector2d inwards; ///< unit vector from the first side to the centre
  Eigen::Vector2d centre;  ///< m
};

/// The profile with every inner corner rounded by an arc tangent to both of its sides.
Profile fillet(const Profile& profile, const Rounding& rounding);

/// Largest radius for which the arcs of neighbouring corners do not overlap.
double largest_fillet(const Profile& profile);

/// Divides long slanted or straight sides so that the triangles of a body with `sides` facets around its axis stay
/// compact.
Profile shorten_facets(const Profile& profile, unsigned int sides);
} // namespace kedge
