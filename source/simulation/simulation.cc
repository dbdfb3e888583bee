#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <kedge/base/communication.h>
#include <kedge/base/exceptions.h>
#include <kedge/output/checkpoint.h>
#include <kedge/output/snapshots.h>
#include <kedge/particles/cleaning.h>
#include <kedge/particles/generation.h>
#include <kedge/particles/merging.h>
#include <kedge/particles/splitting.h>
#include <kedge/simulation/adaptation.h>
#include <kedge/simulation/checkpoints.h>
#include <kedge/simulation/doubts.h>
#include <kedge/simulation/explicit_step.h>
#include <kedge/simulation/layout.h>
#include <kedge/simulation/moving_window.h>
#include <kedge/simulation/placement.h>
#include <kedge/simulation/run_log.h>
#include <kedge/simulation/simulation.h>
#include <kedge/simulation/step_problem.h>
#include <numeric>
#include <optional>

namespace kedge
{
namespace
{
/// A particle's work in a step relative to that of an empty cell, for the partition.
constexpr double particle_cost = 20.;

Materials upload_layers(const std::vector<Layer>& layers)
{
  std::vector<MaterialParameters> parameters;
  for (const Layer& layer : layers)
    parameters.push_back(layer.material);
  return upload_materials(parameters);
}

double magnitude(const std::array<double, 3>& x)
{
  return std::sqrt(std::inner_product(x.begin(), x.end(), x.begin(), 0.));
}

template <int dim> class Simulation
{
public:
  Simulation(const Input& input, const RunOptions& options);
  bool run();

private:
  void generate(const RunOptions& options);
  void resume();
  void enter_stage(unsigned int number);
  void begin_stage(unsigned int number);
  bool run_stage();
  void write_restart_file(const Clock& clock);
  NewtonReport attempt_step(const Clock& clock);
  void prepare_step();
  void follow_bodies_with_window();
  void move_window_to(const Window<dim>& window);
  void remove_hopeless();
  void adapt();
  NewtonReport find_equilibrium(const Clock& clock);
  void commit_trial();
  StepState step_state() const;
  void write_output(const Clock& clock, bool even_if_not_due);
  [[noreturn]] void give_up(const Clock& clock, const NewtonReport& newton);
  void end_stage();

  const Input& input;
  const Stage* stage = nullptr;
  unsigned int stage_number = 0; ///< from 0
  double finished_time = 0.;     ///< of the stages before: s, a static one counts 1
  RunLog log;

  BackgroundMesh<dim> mesh;
  ParticleSet<dim> particles;
  Materials materials;
  RigidSystems bodies;
  Contact<dim> contact;
  OutputWriter<dim> writer;
  CheckpointSchedule checkpoints;
  std::optional<ClockState> resumed; ///< where the stage goes on that a restart file was written in

  std::unique_ptr<TrialStep<dim>> problem; ///< the current step; survives a cut
  StepLoad load;
  Prediction prediction;          ///< for the next step of this stage
  std::vector<Vector6> reactions; ///< of the last converged step, as the next
  std::vector<typename Contact<dim>::Touch> touches;
  bool has_warned_of_window = false;
  bool take_reference_gaps = false; ///< at the first step of a stage whose bodies are wished in place
  long long deleted = 0, dofs = 0;
  double basis_bytes = 0.;
  unsigned int step = 1; ///< global counter; the first converged step is number 2, as the file names have it
};

template <int dim>
Simulation<dim>::Simulation(const Input& input_, const RunOptions& options)
    : input(input_),
      log(input_, options),
      mesh(MPI_COMM_WORLD, make_grid_layout<dim>(input_)),
      particles(mesh),
      materials(upload_layers(input_.material_points.layers)),
      bodies(make_rigid_systems(input_.systems, dim)),
      contact(input_.contact, MPI_COMM_WORLD),
      writer(input_.output, options.output_directory, input_.material_points.layers.size(), MPI_COMM_WORLD),
      checkpoints(input_.output, options.output_directory)
{
  for (const std::string& doubt : find_doubts(input, bodies))
    log.report().warn(doubt);
  if (options.restart)
    resume();
  else
    generate(options);
}

template <int dim> void Simulation<dim>::generate(const RunOptions& options)
{
  const std::string copy = (std::filesystem::path(options.output_directory) / "input.json").string();
  fail_together(copy, MPI_COMM_WORLD,
                [&]
                {
                  if (rank_of(MPI_COMM_WORLD) == 0)
                    write_text_file(copy, input.effective_json);
                });
  const auto scope = log.timings().measure("generation");
  generate_particles(particles, mesh, input.material_points, magnitude(input.gravity));
  particles.balance_load(mesh, particle_cost);
  particles.load();
}

template <int dim> void Simulation<dim>::resume()
{
  RunProgress progress;
  read_checkpoint<dim>({mesh, particles, bodies, contact, prediction, progress}, input.effective_json,
                       checkpoints.path(), particle_cost);
  enter_stage(progress.stage);
  log.resume(stage->stepping, progress.summary, stage_number);
  writer.resume_after(progress.step);
  step = progress.step;
  deleted = progress.deleted;
  has_warned_of_window = progress.has_warned_of_window;
  resumed = progress.clock;
  log.report().line(fmt::format("going on after step {} from {}", step, checkpoints.path()));
}

template <int dim> void Simulation<dim>::write_restart_file(const Clock& clock)
{
  const auto scope = log.timings().measure("restart files");
  if (rank_of(MPI_COMM_WORLD) == 0)
  {
    std::error_code ignored; // the writer reports what cannot be written
    std::filesystem::create_directories(std::filesystem::path(checkpoints.path()).parent_path(), ignored);
  }
  RunProgress progress{
      stage_number,         clock.state(),       step, log.steps_in_stage(), deleted, // the writer adds those lost
      has_warned_of_window, log.text_of_stages()};
  write_checkpoint<dim>({mesh, particles, bodies, contact, prediction, progress}, input.effective_json,
                        checkpoints.path());
}

template <int dim> bool Simulation<dim>::run()
{
  for (unsigned int number = stage_number; number < input.stages.size(); ++number)
  {
    if (!resumed)
      begin_stage(number);
    if (!run_stage())
    {
      log.finish("ended by SIGTERM");
      return false;
    }
    end_stage();
  }
  log.finish("finished");
  return true;
}

/// What a stage that goes on does as well as one that begins.
template <int dim> void Simulation<dim>::enter_stage(const unsigned int number)
{
  stage_number = number;
  stage = &input.stages[number];
  finished_time = 0.;
  for (unsigned int i = 0; i < number; ++i)
    finished_time += requested_steps(input.stages[i].stepping) * step_length(input.stages[i].stepping);
  writer.begin_stage(count_steps(stage->stepping));
  apply_conditions(bodies, input.systems, stage->point_conditions, dim);
}

template <int dim> void Simulation<dim>::begin_stage(const unsigned int number)
{
  enter_stage(number);
  prediction.clear();
  for (RigidPoint& point : bodies.points)
    point.last_increment.setZero();
  if (stage->rigid_bodies && stage->surface_placement)
    place_on_soil<dim>(bodies, particles, MPI_COMM_WORLD);
  log.begin_stage(stage->stepping, bodies);
  move_window_to(place_window<dim>(stage->track, extent_of<dim>(bodies), mesh.layout()));
  if (!stage->rigid_bodies || !stage->wished_in_place)
    return;
  adapt(); // the finer the cells, the smaller the steps of the hole
  const long long removed = remove_buried_particles(particles, bodies);
  deleted += removed;
  log.report().line(fmt::format("{} material points inside buried bodies removed", removed));
  take_reference_gaps = true;
}

/// False where the run was told to end.
template <int dim> bool Simulation<dim>::run_stage()
{
  Clock clock(requested_steps(stage->stepping), input.solver.minimum_step_fraction);
  if (resumed)
    clock.resume(*resumed);
  resumed.reset();
  while (!clock.at_end())
  {
    const NewtonReport newton = attempt_step(clock);
    if (newton.converged)
    {
      commit_trial();
      clock.advance();
      ++step;
    }
    log.count(newton, clock, step);
    if (newton.converged)
    {
      log.progress(newton, clock, step_state());
      write_output(clock, false);
      const bool is_due = checkpoints.due();
      if (is_due || (clock.at_end() && stage_number + 1 < input.stages.size())) // the next stage may fail at once
        write_restart_file(clock);
      if (checkpoints.told_to_end())
        return false;
    }
    else if (!clock.cut())
      give_up(clock, newton);
  }
  return true;
}

/// Gives up where the equations cannot even be set up: a smaller step would meet the same.
template <int dim> NewtonReport Simulation<dim>::attempt_step(const Clock& clock)
{
  try
  {
    if (!problem)
      prepare_step();
    return find_equilibrium(clock);
  }
  catch (const SolverError& error)
  {
    NewtonReport nothing;
    nothing.failure = error.what();
    give_up(clock, nothing);
  }
}

/// What a cut step does not repeat.
template <int dim> void Simulation<dim>::prepare_step()
{
  follow_bodies_with_window();
  remove_hopeless();
  adapt();
  const StepScene<dim> scene{input, *stage, mesh, particles, materials, bodies, contact, log.timings()};
  if (stage->stepping.type == StageType::explicit_)
    problem = std::make_unique<ExplicitStep<dim>>(scene);
  else
    problem = std::make_unique<StepProblem<dim>>(scene);
  if (take_reference_gaps)
    contact.take_reference_gaps(bodies);
  take_reference_gaps = false;
}

template <int dim> void Simulation<dim>::follow_bodies_with_window()
{
  const Extent<dim> extent = extent_of<dim>(bodies);
  move_window_to(advance_window<dim>(mesh.leaves().window, stage->track, extent, mesh.layout()));
  if (!has_warned_of_window && reach_beyond<dim>(mesh.leaves().window, extent, mesh.layout()))
  {
    log.report().warn(fmt::format("step {}: a body reaches beyond a plane of the window, which may not follow it that "
                                  "way, into soil that is not active; set \"advance\" to \"both\"",
                                  step));
    has_warned_of_window = true;
  }
}

template <int dim> void Simulation<dim>::move_window_to(const Window<dim>& window)
{
  if (window == mesh.leaves().window)
    return;
  const auto scope = log.timings().measure("window");
  deleted += move_window<dim>(mesh, particles, window, stage->track);
  const LeafTable<dim> before = mesh.leaves();
  if (!balance_where_it_pays(mesh, particles, particle_cost))
    return;
  particles.load();
  contact.follow_particles(particles.ids());
  prediction = transfer_prediction<dim>(prediction, before, mesh.leaves());
}

template <int dim> void Simulation<dim>::remove_hopeless()
{
  const auto scope = log.timings().measure("clean");
  const HopelessParticles removed = remove_hopeless_particles(particles, mesh);
  if (removed.distorted + removed.isolated == 0)
    return;
  deleted += removed.distorted + removed.isolated;
  particles.load();
  log.report().line(fmt::format("step {}: {} distorted and {} isolated material points removed", step,
                                removed.distorted, removed.isolated));
}

template <int dim> void Simulation<dim>::adapt()
{
  if (stage->adaptivity.type != AdaptivityType::rigid_body_surface || !stage->rigid_bodies)
    return;
  const auto scope = log.timings().measure("adapt");
  const unsigned int points_per_axis = input.material_points.points_per_axis;
  const LeafTable<dim> before = mesh.leaves();
  const AdaptationHooks hooks{[&] { contact.inherit(split_particles(particles, mesh, points_per_axis)); },
                              [&] { contact.follow_particles(particles.ids()); }};
  if (!adapt_mesh<dim>(mesh, particles, {bodies, stage->adaptivity, points_per_axis, particle_cost}, hooks))
    return;
  prediction = transfer_prediction<dim>(prediction, before, mesh.leaves());
  if (!stage->adaptivity.merge)
    return;
  const MergeResult merged = merge_particles<dim>(particles, mesh, points_per_axis, [](const auto&) { return false; });
  if (merged.removed > 0)
  {
    particles.load();
    contact.follow_particles(particles.ids());
  }
}

template <int dim> StepState Simulation<dim>::step_state() const
{
  StepState state;
  state.step = step;
  state.particles = particles.n_global();
  state.deleted = deleted + particles.n_lost();
  state.dofs = dofs;
  state.penetration = stage->rigid_bodies ? contact.deepest_penetration() : 0.;
  return state;
}

template <int dim> void Simulation<dim>::write_output(const Clock& clock, const bool even_if_not_due)
{
  const auto scope = log.timings().measure("output");
  const double time = clock.steps_done() * step_length(stage->stepping);
  writer.write_if_due({particles, mesh, bodies, reactions, touches, stage_number + 1, step, time, finished_time + time},
                      log.steps_in_stage(), clock.at_end() || even_if_not_due);
}

template <int dim> NewtonReport Simulation<dim>::find_equilibrium(const Clock& clock)
{
  load.gravity_factor = stage->stepping.load == GravityLoad::ramp ? clock.steps_after() / clock.requested_steps() : 1.;
  load.step_fraction = clock.step_fraction();
  load.newmark = {stage->stepping.beta, stage->stepping.gamma,
                  stage->stepping.type == StageType::dynamic ? clock.step_fraction() * stage->stepping.dt : 0.};
  load.begins_stage = log.steps_in_stage() == 0;
  load.starts_at_rest =
      load.begins_stage && (stage_number == 0 || input.stages[stage_number - 1].stepping.type == StageType::static_);
  load.body_increments.clear();
  for (const RigidPoint& point : bodies.points)
    load.body_increments.push_back(point.prescribed_increment(clock.step_fraction()));
  return problem->solve(load, prediction);
}

template <int dim> void Simulation<dim>::commit_trial()
{
  const ParticleIncrements increments = problem->particle_increments();
  reactions = problem->reactions();
  touches = contact.touches();
  problem->move_bodies(bodies);

  const auto scope = log.timings().measure("commit");
  if (stage->rigid_bodies)
  {
    particles.set_contact_gaps(contact.smallest_gaps(bodies));
    contact.commit();
  }
  dofs = problem->n_dofs();
  basis_bytes = problem->basis_bytes();
  prediction = problem->predict_next();
  problem.reset();
  particles.commit(increments, input.material_points.domain_update);
  particles.load();
  contact.follow_particles(particles.ids());
}

template <int dim> void Simulation<dim>::give_up(const Clock& clock, const NewtonReport& newton)
{
  if (log.steps_in_stage() > 0)
  {
    write_output(clock, true);
    write_restart_file(clock);
  }
  end_stage();
  log.finish("failed: " + newton.failure);
  const std::string place =
      fmt::format("stage {}, step {} of {}", stage_number + 1, clock.steps_done() + 1., clock.requested_steps());
  if (newton.residuals.empty())
    throw SolverError(fmt::format("{}: {}", place, newton.failure));
  throw SolverError(
      fmt::format(
          "{}: {} even with a step cut to {:.3g} of the requested one.\n"
          "Residual over the soil's weight: {}\n"
          "Smaller load steps, a finer mesh at the body, a little cohesion or a larger \"ghost factor\" may help.",
          place, newton.failure, clock.step_fraction(), format_residuals(newton)),
      newton.residuals);
}

template <int dim> void Simulation<dim>::end_stage()
{
  problem.reset();
  long long cells = 0;
  for (const auto& cell : mesh.triangulation().active_cell_iterators())
    cells += cell->is_locally_owned() && mesh.in_window(cell) && particles.handler().n_particles_in_cell(cell) > 0;
  log.end_stage(step_state(), sum_over_ranks(cells, MPI_COMM_WORLD), particles.bytes(), basis_bytes);
}
} // namespace

bool run_simulation(const Input& input, const RunOptions& options)
{
  if (const std::string path = restart_path(input.output, options.output_directory);
      options.restart && !std::filesystem::exists(path))
    throw FileError(path, "is not there, so nothing can go on; run without --restart, with \"checkpoint every\" for a "
                          "restart file, or name the folder of the first run with --output");
  return input.dimension == 2 ? Simulation<2>(input, options).run() : Simulation<3>(input, options).run();
}
} // namespace kedge
