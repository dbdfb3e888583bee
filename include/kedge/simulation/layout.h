#pragma once

#include <kedge/mesh/grid_layout.h>
#include <kedge/simulation/input.h>

namespace kedge
{
/// The grid that an input asks for; every size named in any stage counts.
template <int dim> GridLayout<dim> make_grid_layout(const Input& input);
} // namespace kedge
