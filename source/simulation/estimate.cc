#include <cmath>
#include <fmt/format.h>
#include <kedge/particles/generation.h>
#include <kedge/simulation/estimate.h>
#include <kedge/simulation/layout.h>

namespace kedge
{
namespace
{
// Measured on one core with eight particles a cell; see benchmarks/speed.
constexpr double newton_iterations = 5.;
constexpr double seconds_per_particle = 12e-6; ///< and Newton iteration: stress, tangent, scatter
constexpr double seconds_per_dof = 40e-6;      ///< and Newton iteration: linear solver
constexpr double bytes_per_particle = 2000.;
constexpr double bytes_per_dof = 12. * 375. * 2.; ///< matrix rows and the multigrid hierarchy

template <int dim> std::vector<StageEstimate> estimate(const Input& input)
{
  const GridLayout<dim> grid = make_grid_layout<dim>(input);
  const MaterialPointParameters& soil = input.material_points;
  const double rows =
      make_rows(grid.base_size / soil.points_per_axis, grid.soil_extent[dim - 1], soil.layers, 1.).size();
  double columns = 1., cells = std::ceil(grid.soil_extent[dim - 1] / grid.base_size - 1e-9), nodes = cells + 1.;
  for (unsigned int d = 0; d < dim - 1; ++d)
  {
    columns *= static_cast<double>(grid.base_cells[d]) * soil.points_per_axis;
    cells *= grid.base_cells[d];
    nodes *= grid.base_cells[d] + 1.;
  }
  std::vector<StageEstimate> stages;
  for (const Stage& stage : input.stages)
  {
    StageEstimate estimate;
    estimate.cells = cells;
    estimate.dofs = dim * nodes;
    estimate.particles = rows * columns;
    estimate.steps = stage.stepping.load_steps;
    estimate.memory = bytes_per_particle * estimate.particles + bytes_per_dof * estimate.dofs;
    estimate.seconds = estimate.steps * newton_iterations *
                       (seconds_per_particle * estimate.particles + seconds_per_dof * estimate.dofs);
    stages.push_back(estimate);
  }
  return stages;
}
} // namespace

std::vector<StageEstimate> estimate_cost(const Input& input)
{
  return input.dimension == 2 ? estimate<2>(input) : estimate<3>(input);
}

std::string format_estimate(const Input& input, const std::vector<StageEstimate>& stages)
{
  std::string text = "stage        steps     cells      dofs    points    memory   rough time on one core\n";
  for (std::size_t i = 0; i < stages.size(); ++i)
  {
    const StageEstimate& stage = stages[i];
    text += fmt::format("{:<3} {:<8} {:>5} {:>9.0f} {:>9.0f} {:>9.0f} {:>6.2f} GB   {}\n", i + 1,
                        input.stages[i].stepping.type == StageType::static_ ? "static" : "dynamic", stage.steps,
                        stage.cells, stage.dofs, stage.particles, 1e-9 * stage.memory,
                        stage.seconds < 60.     ? fmt::format("{:.0f} s", stage.seconds)
                        : stage.seconds < 3600. ? fmt::format("{:.0f} min", stage.seconds / 60.)
                                                : fmt::format("{:.1f} h", stage.seconds / 3600.));
  }
  return text;
}
} // namespace kedge
