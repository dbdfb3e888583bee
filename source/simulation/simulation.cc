#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <kedge/base/communication.h>
#include <kedge/base/exceptions.h>
#include <kedge/output/snapshots.h>
#include <kedge/output/summary.h>
#include <kedge/particles/generation.h>
#include <kedge/simulation/layout.h>
#include <kedge/simulation/simulation.h>
#include <kedge/simulation/step_problem.h>
#include <kedge/simulation/version.h>
#include <kedge/time/clock.h>
#include <numeric>

namespace kedge
{
namespace
{
/// A particle's work in a step relative to that of an empty cell, for the partition.
constexpr double particle_cost = 20.;

Materials upload_materials(const std::vector<Layer>& layers)
{
  const Materials materials("materials", layers.size());
  const auto host = Kokkos::create_mirror_view(materials);
  for (std::size_t i = 0; i < layers.size(); ++i)
    host(i) = make_material(layers[i].material);
  Kokkos::deep_copy(materials, host);
  return materials;
}

double magnitude(const std::array<double, 3>& x)
{
  return std::sqrt(std::inner_product(x.begin(), x.end(), x.begin(), 0.));
}

std::string format_residuals(const NewtonReport& newton)
{
  std::string text;
  for (const double residual : newton.residuals)
    text += fmt::format(" {:.2e}", residual);
  return text;
}

template <int dim> class Simulation
{
public:
  Simulation(const Input& input, const RunOptions& options);
  void run();

private:
  void warn_of_sharp_edges();
  void begin_stage(unsigned int number);
  void run_stage();
  NewtonReport find_equilibrium(const Clock& clock);
  void commit_trial();
  void count(const NewtonReport& newton, const Clock& clock);
  void report_progress(const Clock& clock, const NewtonReport& newton);
  void write_output(const Clock& clock, bool even_if_not_due);
  [[noreturn]] void give_up(const Clock& clock, const NewtonReport& newton);
  void finish_summary(const std::string& status);
  void remove_buried_particles();

  const Input& input;
  const RunOptions& options;
  std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  const Stage* stage = nullptr;
  unsigned int stage_number = 0; ///< from 0
  Report report;
  Timings timings;
  RunSummary summary;

  BackgroundMesh<dim> mesh;
  ParticleSet<dim> particles;
  Materials materials;
  RigidSystems bodies;
  Contact<dim> contact;
  OutputWriter<dim> writer;

  std::unique_ptr<StepProblem<dim>> problem; ///< of the current step; survives a cut
  typename StepProblem<dim>::Load load;
  typename StepProblem<dim>::Prediction prediction; ///< for the next step of this stage
  std::vector<Vector6> reactions;
  bool take_reference_gaps = false; ///< at the first step of a stage whose bodies are wished in place
  long long deleted = 0;
  unsigned int step = 1; ///< global counter; the first converged step is number 2, as the file names have it
};

template <int dim>
Simulation<dim>::Simulation(const Input& input_, const RunOptions& options_)
    : input(input_),
      options(options_),
      report(rank_of(MPI_COMM_WORLD) == 0, options_.quiet),
      mesh(MPI_COMM_WORLD, make_grid_layout<dim>(input_)),
      particles(mesh),
      materials(upload_materials(input_.material_points.layers)),
      bodies(make_rigid_systems(input_.systems, dim)),
      contact(input_.contact, MPI_COMM_WORLD),
      writer(input_.output, options_.output_directory, input_.material_points.layers.size(), MPI_COMM_WORLD)
{
  if (rank_of(MPI_COMM_WORLD) == 0)
    write_text_file((std::filesystem::path(options.output_directory) / "input.json").string(), input.effective_json);
  summary.version = version();
  summary.input_file = options.input_file;
  summary.back_end = back_end();
  summary.gpu_requested = input.gpu;
  summary.ranks = size_of(MPI_COMM_WORLD);
  summary.libraries = library_versions();
  if (input.gpu && back_end() != "Cuda" && back_end() != "HIP")
    report.warn("\"GPU\" is \"on\", but this build has no GPU back end: running on the CPU");
  warn_of_sharp_edges();
  const auto scope = timings.measure("generation");
  generate_particles(particles, mesh, input.material_points, magnitude(input.gravity));
  particles.balance_load(mesh, particle_cost);
  particles.load();
}

template <int dim> void Simulation<dim>::warn_of_sharp_edges()
{
  const double particle = mesh.layout().finest_size / input.material_points.points_per_axis;
  constexpr double facets = 0.9; // a rounding of a few facets measures a little less than its radius
  for (std::size_t i = 0; i < bodies.surfaces.size(); ++i)
    if (const double radius = bodies.surfaces[i].surface.sharpest_edge_radius(); radius < facets * 0.5 * particle)
      report.warn(
          fmt::format("surface {} has convex edges of radius {:.3g} m, sharper than half a material point ({:.3g} m): "
                      "soil may slip past them; round them, as kedge geometry --edge-radius does",
                      i + 1, radius, 0.5 * particle));
}

template <int dim> void Simulation<dim>::run()
{
  for (unsigned int number = 0; number < input.stages.size(); ++number)
  {
    begin_stage(number);
    run_stage();
  }
  finish_summary("finished");
  report.line(fmt::format("finished in {:.1f} s, results in {}", summary.total_seconds, options.output_directory));
}

template <int dim> void Simulation<dim>::begin_stage(const unsigned int number)
{
  stage_number = number;
  stage = &input.stages[number];
  prediction.clear();
  summary.stages.emplace_back();
  summary.stages.back().type = "static";
  writer.begin_stage(stage->stepping.load_steps);
  apply_conditions(bodies, input.systems, stage->point_conditions, dim);
  if (!stage->rigid_bodies)
    return;
  if (stage->surface_placement)
    place_on_surface(bodies, 2, mesh.layout().soil_extent[dim - 1]);
  if (stage->wished_in_place)
    remove_buried_particles();
  take_reference_gaps = stage->wished_in_place;
}

template <int dim> void Simulation<dim>::remove_buried_particles()
{
  const long long removed = particles.remove_if(
      [this](const auto& particle)
      {
        const dealii::Point<dim> x = particle.get_location();
        return is_inside(bodies, dim == 3 ? Eigen::Vector3d(x[0], x[1], x[dim - 1]) : Eigen::Vector3d(x[0], 0., x[1]));
      });
  deleted += removed;
  particles.load();
  report.line(fmt::format("{} material points inside buried bodies removed", removed));
}

template <int dim> void Simulation<dim>::run_stage()
{
  Clock clock(stage->stepping.load_steps, input.solver.minimum_step_fraction);
  while (!clock.at_end())
  {
    const NewtonReport newton = find_equilibrium(clock);
    if (newton.converged)
    {
      commit_trial();
      clock.advance();
      ++step;
    }
    count(newton, clock);
    if (newton.converged)
    {
      report_progress(clock, newton);
      write_output(clock, false);
    }
    else if (!clock.cut())
      give_up(clock, newton);
  }
  report.end_progress();
}

template <int dim> void Simulation<dim>::count(const NewtonReport& newton, const Clock& clock)
{
  StageSummary& counts = summary.stages.back();
  counts.steps += newton.converged;
  counts.cuts = clock.cuts();
  counts.newton_iterations += newton.iterations;
  counts.krylov_iterations += newton.krylov_iterations;
  if (options.verbose)
    report.line(fmt::format("step {} {}: {} Krylov iterations, residuals{}", step,
                            newton.converged ? "converged" : newton.failure, newton.krylov_iterations,
                            format_residuals(newton)));
}

template <int dim> void Simulation<dim>::write_output(const Clock& clock, const bool even_if_not_due)
{
  const auto scope = timings.measure("output");
  const double time = clock.steps_done() / clock.requested_steps();
  writer.write_if_due(
      {particles, mesh, bodies, reactions, contact.touches(), stage_number + 1, step, time, stage_number + time},
      summary.stages.back().steps, clock.at_end() || even_if_not_due);
}

template <int dim> NewtonReport Simulation<dim>::find_equilibrium(const Clock& clock)
{
  if (!problem)
    problem = std::make_unique<StepProblem<dim>>(input, *stage, mesh, particles, materials, bodies, contact, timings);
  if (take_reference_gaps)
    contact.take_reference_gaps(bodies);
  take_reference_gaps = false;

  load.gravity_factor = stage->stepping.load == GravityLoad::ramp ? clock.steps_after() / clock.requested_steps() : 1.;
  load.step_fraction = clock.step_fraction();
  load.body_increments.clear();
  for (const RigidPoint& point : bodies.points)
    load.body_increments.push_back(point.prescribed_increment(clock.step_fraction()));
  return problem->solve(load, prediction);
}

template <int dim> void Simulation<dim>::commit_trial()
{
  const ParticleIncrements increments = problem->particle_increments();
  const BodyLoads loads = problem->body_loads();
  reactions.clear();
  for (std::size_t i = 0; i < bodies.points.size(); ++i)
  {
    RigidPoint& point = bodies.points[i];
    point.pose = point.pose.moved(load.body_increments[i]);
    Vector6 reaction = stage->rigid_bodies ? Vector6(-loads[i]) : Vector6(Vector6::Zero());
    for (unsigned int d = 0; d < 3; ++d)
      reaction[d] -= load.gravity_factor * point.mass * input.gravity[d];
    reactions.push_back(reaction);
  }

  const auto scope = timings.measure("commit");
  if (stage->rigid_bodies)
  {
    particles.set_contact_gaps(contact.smallest_gaps());
    contact.commit();
  }
  summary.stages.back().dofs = problem->n_dofs();
  prediction = problem->predict_next();
  problem.reset();
  particles.commit(increments, input.material_points.domain_update);
  particles.load();
  contact.follow_particles(particles.ids());
}

template <int dim> void Simulation<dim>::report_progress(const Clock& clock, const NewtonReport& newton)
{
  Progress state;
  state.stage = stage_number + 1;
  state.n_stages = input.stages.size();
  state.time = clock.steps_done() / clock.requested_steps();
  state.step = step;
  state.increment = clock.step_fraction() / clock.requested_steps();
  state.newton_iterations = newton.iterations;
  state.krylov_iterations = newton.krylov_iterations;
  state.cuts = clock.cuts();
  state.deleted = deleted + particles.n_lost();
  state.particles = particles.n_global();
  report.progress(state);
}

template <int dim> void Simulation<dim>::give_up(const Clock& clock, const NewtonReport& newton)
{
  report.end_progress();
  if (summary.stages.back().steps > 0)
    write_output(clock, true);
  finish_summary("failed: " + newton.failure);
  throw SolverError(
      fmt::format(
          "stage {}, step {} of {}: {} even with a step cut to {:.3g} of the requested one.\n"
          "Residual over the soil's weight:{}\n"
          "Smaller load steps, a finer mesh at the body, a little cohesion or a larger \"ghost factor\" may help.",
          stage_number + 1, clock.steps_done() + 1., clock.requested_steps(), newton.failure, clock.step_fraction(),
          format_residuals(newton)),
      newton.residuals);
}

template <int dim> void Simulation<dim>::finish_summary(const std::string& status)
{
  const MPI_Comm world = MPI_COMM_WORLD;
  summary.status = status;
  summary.warnings = report.warnings();
  summary.seconds = timings.seconds();
  summary.total_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  summary.peak_memory = max_over_ranks(peak_memory(), world);
  summary.bytes_per_particle = sum_over_ranks(peak_memory(), world) / std::max(1ll, particles.n_global());
  StageSummary& last = summary.stages.back();
  last.particles = particles.n_global();
  last.deleted = deleted + particles.n_lost();
  long long cells = 0;
  for (const auto& cell : mesh.triangulation().active_cell_iterators())
    cells += cell->is_locally_owned() && particles.handler().n_particles_in_cell(cell) > 0;
  last.cells = sum_over_ranks(cells, world);
  if (rank_of(world) == 0)
    write_summary(summary, (std::filesystem::path(options.output_directory) / "summary.json").string());
}
} // namespace

void check_surfaces(const Input& input) { make_rigid_systems(input.systems, input.dimension); }

void run_simulation(const Input& input, const RunOptions& options)
{
  if (input.dimension == 2)
    Simulation<2>(input, options).run();
  else
    Simulation<3>(input, options).run();
}
} // namespace kedge
