#include <algorithm>
#include <fmt/format.h>
#include <kedge/materials/material.h>
#include <kedge/simulation/layout.h>

namespace kedge
{
template <int dim> GridLayout<dim> make_grid_layout(const Input& input)
{
  std::vector<double> sizes;
  for (const Stage& stage : input.stages)
    if (stage.rigid_bodies) // nothing is refined around frozen ones
      for (const double size : finer_sizes(stage.adaptivity))
        sizes.push_back(size);
  const MaterialPointParameters& soil = input.material_points;
  std::array<double, dim - 1> footprint;
  std::copy_n(soil.plan_extent.begin(), dim - 1, footprint.begin());
  std::array<double, dim> extent;
  std::copy_n(input.grid_extent.begin(), dim, extent.begin());
  return make_grid_layout<dim>(soil.element_size, sizes, footprint, thickness_of(soil.layers), soil.points_per_axis,
                               extent);
}

namespace
{
constexpr double round_off = 1e-6;

template <int dim> BlockSize describe_block(const Input& input)
{
  const GridLayout<dim> grid = make_grid_layout<dim>(input);
  const MaterialPointParameters& soil = input.material_points;
  std::vector<double> asked(soil.plan_extent.begin(), soil.plan_extent.begin() + dim - 1);
  asked.push_back(thickness_of(soil.layers));
  BlockSize block;
  for (int d = 0; d < dim; ++d)
    block.is_rounded = block.is_rounded || grid.soil_extent[d] > asked[d] * (1. + round_off);
  block.text = fmt::format("{:.6g} m", fmt::join(grid.soil_extent, " x "));
  if (block.is_rounded)
    block.text +=
        fmt::format(", rounded up from {:.6g} m to whole cells and rows of material points", fmt::join(asked, " x "));
  return block;
}
} // namespace

BlockSize describe_block(const Input& input)
{
  return input.dimension == 2 ? describe_block<2>(input) : describe_block<3>(input);
}

double thickness_of(const std::vector<Layer>& layers)
{
  double thickness = 0.;
  for (const Layer& layer : layers)
    thickness += layer.thickness;
  return thickness;
}

std::vector<std::vector<StateVariable>> states_of(const std::vector<Layer>& layers)
{
  std::vector<std::vector<StateVariable>> states;
  for (const Layer& layer : layers)
    states.push_back(state_variables_of(layer.material));
  return states;
}

template GridLayout<2> make_grid_layout<2>(const Input&);
template GridLayout<3> make_grid_layout<3>(const Input&);
} // namespace kedge
