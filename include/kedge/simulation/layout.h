#pragma once

#include <kedge/mesh/grid_layout.h>
#include <kedge/simulation/input.h>

namespace kedge
{
/// The grid that an input asks for; every size named in any stage counts.
template <int dim> GridLayout<dim> make_grid_layout(const Input& input);

/// The size of the soil's block, and the one asked for where that is rounded up.
struct BlockSize
{
  std::string text;        ///< "102.4 x 12.8 x 19.2 m, rounded up from 100 x 10 x 18.123 m to ..."
  bool is_rounded = false; ///< by more than a millionth
};
BlockSize describe_block(const Input& input);

/// Of all layers, m.
double thickness_of(const std::vector<Layer>& layers);

/// By layer, the state variables that its law uses.
std::vector<std::vector<StateVariable>> states_of(const std::vector<Layer>& layers);
} // namespace kedge
