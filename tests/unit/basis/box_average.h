// The basis of one box alone.
#pragma once

#include <kedge/basis/gimp.h>

namespace kedge::test
{
template <int dim>
std::vector<NodeShare<dim>> average_over_box(const LeafTable<dim>& table, const std::array<double, dim>& centre,
                                             const std::array<double, dim>& half_width)
{
  const HostStencils stencils = build_stencils<dim>(table, find_box_parts<dim>(table, {centre}, {half_width}));
  std::vector<NodeShare<dim>> shares;
  for (std::size_t v = 0; v < stencils.pattern_nodes.size(); ++v)
  {
    shares.push_back({stencils.pattern_nodes[v], stencils.value(v), {}});
    for (unsigned int d = 0; d < dim; ++d)
      shares.back().gradient[d] = stencils.gradient(dim * v + d);
  }
  return shares;
}
} // namespace kedge::test
