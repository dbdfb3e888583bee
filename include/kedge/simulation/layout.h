#pragma once

#include <kedge/mesh/grid_layout.h>
#include <kedge/simulation/input.h>

namespace kedge
{
/// The grid that an input asks for; every size named in any stage counts.
template <int dim> GridLayout<dim> make_grid_layout(const Input& input);

/// Of all layers, m.
double thickness_of(const std::vector<Layer>& layers);

/// By layer, the state variables that its law uses.
std::vector<std::vector<StateVariable>> states_of(const std::vector<Layer>& layers);
} // namespace kedge
