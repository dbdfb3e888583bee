// What the input says of one stage of the analysis.
#pragma once

#include <kedge/bodies/parameters.h>
#include <kedge/mesh/parameters.h>
#include <kedge/time/parameters.h>
#include <vector>

namespace kedge
{
enum class Basis
{
  gimp,
  mpm
};

struct Stage
{
  SteppingParameters stepping;
  bool rigid_bodies = false;
  BoundaryConditions boundary_conditions;
  Adaptivity adaptivity;
  Adaptivity cells; ///< of the last stage up to this one that refines, for its cells stay
  bool surface_placement = false;
  bool wished_in_place = false;
  double largest_motion = 0.1; ///< of surfaces in a step as prescribed, over the cells at them; infinite: no limit
  std::vector<PointConditionsOverride> point_conditions;
  BoundaryTrack track;
};
} // namespace kedge
