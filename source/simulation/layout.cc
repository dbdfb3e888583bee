#include <algorithm>
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
