#include "step_limit.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <kedge/particles/generation.h>
#include <kedge/simulation/estimate.h>
#include <kedge/simulation/layout.h>
#include <kedge/soil/adaptation.h>
#include <kedge/soil/placement.h>
#include <set>

namespace kedge
{
namespace
{
// Means of the cone and plate scenes on one core that other programs shared; benchmarks/speed has the kernels alone.
constexpr double newton_iterations = 15.;        // elastic soil takes 3, plastic soil in contact 7 to 25
constexpr double seconds_per_particle = 8e-6;    ///< and Newton iteration: stress, tangent, scatter
constexpr double seconds_per_dof = 15e-6;        ///< and Newton iteration: linear solver
constexpr double seconds_per_time_step = 0.6e-6; ///< and particle, of explicit stages
constexpr double bytes_of_program = 0.2e9;
constexpr double bytes_per_particle = 2000.;
constexpr double bytes_per_dof = 12. * 375. * 2.; ///< matrix rows and the multigrid hierarchy

/// What a stage begins with.
struct Contents
{
  double cells = 0., nodes = 0., particles = 0.;
  bool counting_stopped = false;
};

template <int dim> Contents count_base_cells(const Input& input)
{
  const GridLayout<dim> grid = make_grid_layout<dim>(input);
  const MaterialPointParameters& soil = input.material_points;
  Contents contents;
  contents.particles =
      make_rows(grid.base_size / soil.points_per_axis, grid.soil_extent[dim - 1], soil.layers, 1.).size();
  contents.cells = std::ceil(grid.soil_extent[dim - 1] / grid.base_size - 1e-9);
  contents.nodes = contents.cells + 1.;
  for (unsigned int d = 0; d < dim - 1; ++d)
  {
    const double cells = std::round(grid.soil_extent[d] / grid.base_size);
    contents.particles *= cells * soil.points_per_axis;
    contents.cells *= cells;
    contents.nodes *= cells + 1.;
  }
  return contents;
}

bool is_refined(const Stage& stage)
{
  return stage.rigid_bodies && stage.adaptivity.type == AdaptivityType::rigid_body_surface;
}

/// Edge of the smallest cells (m).
double finest_size(const Adaptivity& adaptivity, const double base_size)
{
  double finest = base_size;
  for (const double size : finer_sizes(adaptivity))
    finest = std::min(finest, size);
  return finest;
}

/// The soil at rest on the mesh that the bodies refine, without a solution.
template <int dim> class RefinedSoil
{
public:
  RefinedSoil(const Input& input_, const double most_particles_)
      : input(input_),
        most_particles(most_particles_),
        soil(make_grid_layout<dim>(input_), input_.material_points, input_.contact, MPI_COMM_SELF),
        bodies(make_rigid_systems(input_.systems, dim))
  {
    soil.generate(0.);
  }

  void begin(const Stage& stage)
  {
    apply_conditions(bodies, input.systems, stage.point_conditions, dim);
    if (stage.rigid_bodies && stage.surface_placement)
      place_on_soil<dim>(bodies, soil);
    if (is_refined(stage))
      refine(stage.adaptivity);
    if (stage.rigid_bodies && stage.wished_in_place)
      soil.remove_buried(bodies);
  }

  void end(const Stage& stage)
  {
    if (stage.rigid_bodies)
      for (RigidPoint& point : bodies.points)
        point.pose = point.pose.moved(point.prescribed_increment(count_steps(stage.stepping)));
  }

  Contents contents() const
  {
    const LeafTable<dim>& table = soil.mesh().leaves();
    const ParticleSet<dim>& particles = soil.particles();
    const std::set<unsigned int> cells(particles.leaves().begin(), particles.leaves().end());
    std::set<unsigned int> nodes;
    for (const unsigned int cell : cells)
    {
      const auto& leaf = table.leaves[cell];
      const auto first = table.nodes.begin() + leaf.node_begin;
      nodes.insert(first, first + leaf.n_nodes);
    }
    return {double(cells.size()), double(nodes.size()), double(particles.n_global()), counting_stopped};
  }

private:
  /// Level by level, to stop before a level that would hold too much.
  void refine(const Adaptivity& adaptivity)
  {
    Adaptivity level = adaptivity;
    const double base_size = soil.mesh().layout().base_size;
    const double finest = finest_size(adaptivity, base_size);
    for (double size = base_size; size > finest && !counting_stopped;)
    {
      size *= 0.5;
      level.element_size = std::max(size, adaptivity.element_size);
      level.element_size_in_region = std::max(size, adaptivity.element_size_in_region);
      for (std::size_t i = 0; i < level.boxes.size(); ++i)
        level.boxes[i].element_size = std::max(size, adaptivity.boxes[i].element_size);
      counting_stopped = count_after(level) > most_particles;
      if (!counting_stopped)
        soil.adapt(bodies, level);
    }
  }

  /// Particles after the next level, without those of cells that 2:1 asks for.
  double count_after(const Adaptivity& level) const
  {
    const LeafTable<dim>& table = soil.mesh().leaves();
    std::vector<double> growth(table.leaves.size(), 0.); // 0: not asked yet
    double n = 0.;
    for (const unsigned int leaf : soil.particles().leaves())
    {
      if (growth[leaf] == 0.)
      {
        const auto& cell = table.leaves[leaf];
        const double wanted = wanted_size<dim>(bodies, level, table.base_size, cell.lower, cell.size);
        growth[leaf] = std::pow(std::max(1., cell.size / wanted), dim);
      }
      n += growth[leaf];
    }
    return n;
  }

  const Input& input;
  double most_particles;
  Soil<dim> soil;
  RigidSystems bodies;
  bool counting_stopped = false;
};

/// By stage.
template <int dim> std::vector<Contents> count_contents(const Input& input, const double most_particles)
{
  std::vector<Contents> contents(input.stages.size(), count_base_cells<dim>(input));
  if (std::none_of(input.stages.begin(), input.stages.end(), is_refined))
    return contents;
  if (contents.front().particles > most_particles)
  {
    for (std::size_t i = 0; i < contents.size(); ++i)
      contents[i].counting_stopped = is_refined(input.stages[i]);
    return contents;
  }
  RefinedSoil<dim> soil(input, most_particles);
  for (std::size_t i = 0; i < contents.size(); ++i)
  {
    soil.begin(input.stages[i]);
    contents[i] = soil.contents();
    soil.end(input.stages[i]);
  }
  return contents;
}

/// Of an explicit stage, from the layer with the fastest waves in cells of regular shape, s.
double estimate_critical_time_step(const Input& input, const Stage& stage)
{
  const SteppingParameters& stepping = stage.stepping;
  const double base = input.material_points.element_size;
  const double size = finest_size(stage.cells, base);
  double fastest = 0.;
  for (const Layer& layer : input.material_points.layers)
  {
    const double young = layer.material.young, poisson = std::min(layer.material.poisson, 0.499);
    const double constrained = young * (1. - poisson) / ((1. + poisson) * (1. - 2. * poisson));
    fastest = std::max(fastest, std::sqrt(constrained / layer.material.density));
  }
  // of a row of cells with their masses at the nodes; for damping see find_stable_step()
  return size * std::sqrt(stepping.mass_scaling / (1. + stepping.damping)) / fastest;
}

/// In how many steps a requested one is made.
unsigned int count_parts(const Input& input, const Stage& stage)
{
  RigidSystems bodies = make_rigid_systems(input.systems, input.dimension);
  apply_conditions(bodies, input.systems, stage.point_conditions, input.dimension);
  const double base =
      input.dimension == 2 ? make_grid_layout<2>(input).base_size : make_grid_layout<3>(input).base_size;
  return find_step_limit(stage, bodies, base).n_parts;
}
} // namespace

std::vector<StageEstimate> estimate_cost(const Input& input, const double most_particles)
{
  const std::vector<Contents> contents =
      input.dimension == 2 ? count_contents<2>(input, most_particles) : count_contents<3>(input, most_particles);
  std::vector<StageEstimate> stages(input.stages.size());
  for (std::size_t i = 0; i < stages.size(); ++i)
  {
    StageEstimate& stage = stages[i];
    stage.cells = contents[i].cells;
    stage.dofs = input.dimension * contents[i].nodes;
    stage.particles = contents[i].particles;
    stage.counting_stopped = contents[i].counting_stopped;
    stage.steps = count_steps(input.stages[i].stepping) * count_parts(input, input.stages[i]);
    stage.memory = bytes_of_program + bytes_per_particle * stage.particles + bytes_per_dof * stage.dofs;
    if (const SteppingParameters& stepping = input.stages[i].stepping; stepping.type == StageType::explicit_)
    {
      const double critical = stage.critical_time_step = estimate_critical_time_step(input, input.stages[i]);
      const double dt = stepping.dt > 0. ? std::min(stepping.dt, critical) : stepping.cfl * critical;
      stage.seconds = stepping.final_time / dt * seconds_per_time_step * stage.particles;
    }
    else
      stage.seconds =
          stage.steps * newton_iterations * (seconds_per_particle * stage.particles + seconds_per_dof * stage.dofs);
  }
  return stages;
}

std::string format_estimate(const Input& input, const std::vector<StageEstimate>& stages)
{
  std::string text = "What each stage begins with; moving bodies and windows may need several times as much later.\n"
                     "stage        steps     cells      dofs    points    memory   rough time on one core\n";
  for (std::size_t i = 0; i < stages.size(); ++i)
  {
    const StageEstimate& stage = stages[i];
    text += fmt::format("{:<3} {:<8} {:>5} {:>9.0f} {:>9.0f} {:>9.0f} {:>6.2f} GB   {}\n", i + 1,
                        name_of(input.stages[i].stepping.type), stage.steps, stage.cells, stage.dofs, stage.particles,
                        1e-9 * stage.memory,
                        stage.seconds < 60.     ? fmt::format("{:.0f} s", stage.seconds)
                        : stage.seconds < 3600. ? fmt::format("{:.0f} min", stage.seconds / 60.)
                                                : fmt::format("{:.1f} h", stage.seconds / 3600.));
  }
  for (std::size_t i = 0; i < stages.size(); ++i)
    if (const double critical = stages[i].critical_time_step; critical > 0.)
    {
      const SteppingParameters& stepping = input.stages[i].stepping;
      text +=
          fmt::format("stage {}: critical time step about {:.2g} s, less where contact is stiffer than the soil; {}\n",
                      i + 1, critical,
                      stepping.dt > critical ? fmt::format("\"dt\", {:.2g} s, is cut to it", stepping.dt)
                      : stepping.dt > 0.     ? fmt::format("given {:.2g} s", stepping.dt)
                                             : fmt::format("{:.2g} of it is taken", stepping.cfl));
    }
  for (std::size_t i = 0; i < stages.size(); ++i)
    if (stages[i].counting_stopped)
      text += fmt::format("stage {} costs more than that: its refined cells are too many to count here\n", i + 1);
  return text;
}
} // namespace kedge
