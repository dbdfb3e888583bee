// What the soil bears of its initial stress.
#pragma once

#include <kedge/mesh/grid_layout.h>
#include <kedge/particles/parameters.h>
#include <string>
#include <vector>

namespace kedge
{
/// A warning for each layer whose law refuses the initial stress somewhere: the first step then returns it to the yield
/// surface, and the soil moves. `gravity` is its magnitude in m/s2.
template <int dim>
std::vector<std::string> find_unborne_stress(const MaterialPointParameters& soil, const GridLayout<dim>& grid,
                                             double gravity);
} // namespace kedge
