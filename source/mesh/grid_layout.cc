#include <algorithm>
#include <cmath>
#include <kedge/mesh/grid_layout.h>

namespace kedge
{
namespace
{
// Sizes come from decimal input: 0.8 / 0.1 must count as 8, despite round-off.
constexpr double rounding_slack = 1e-9;
constexpr unsigned int largest_base_level = 3; // deeper trees cost more to search than they save

unsigned int count_rounded_up(const double length, const double unit)
{
  return static_cast<unsigned int>(std::max(1., std::ceil(length / unit - rounding_slack)));
}
} // namespace

double round_down_to_level(const double size, const double finest)
{
  const double levels = std::floor(std::log2(size / finest) + rounding_slack);
  return finest * std::exp2(std::max(0., levels));
}

template <int dim> unsigned int GridLayout<dim>::base_level() const
{
  unsigned int level = 0;
  const auto divides = [&](const unsigned int n) { return n % (2u << level) == 0; };
  while (level < largest_base_level && std::all_of(base_cells.begin(), base_cells.end(), divides))
    ++level;
  return level;
}

template <int dim>
GridLayout<dim> make_grid_layout(const double base, const std::vector<double>& sizes,
                                 const std::array<double, dim - 1>& footprint, const double soil_thickness,
                                 const unsigned int particles_per_axis, const std::array<double, dim>& extent)
{
  GridLayout<dim> grid;
  grid.finest_size = base;
  for (const double size : sizes)
    grid.finest_size = std::min(grid.finest_size, size);
  grid.base_size = round_down_to_level(base, grid.finest_size);
  for (unsigned int axis = 0; axis < dim - 1; ++axis)
  {
    const unsigned int soil_cells = count_rounded_up(footprint[axis], grid.base_size);
    grid.soil_extent[axis] = grid.base_size * soil_cells;
    grid.base_cells[axis] = std::max(soil_cells, count_rounded_up(extent[axis], grid.base_size));
  }
  const double row = grid.base_size / particles_per_axis;
  grid.soil_extent[dim - 1] = row * count_rounded_up(soil_thickness, row);
  const double top = extent[dim - 1] > 0. ? extent[dim - 1] : 2. * grid.soil_extent[dim - 1];
  grid.base_cells[dim - 1] = count_rounded_up(std::max(top, grid.soil_extent[dim - 1]), grid.base_size);
  return grid;
}

template struct GridLayout<2>;
template struct GridLayout<3>;
template GridLayout<2> make_grid_layout<2>(double, const std::vector<double>&, const std::array<double, 1>&, double,
                                           unsigned int, const std::array<double, 2>&);
template GridLayout<3> make_grid_layout<3>(double, const std::vector<double>&, const std::array<double, 2>&, double,
                                           unsigned int, const std::array<double, 3>&);
} // namespace kedge
