#include "size_limits.h"
#include "step_limit.h"
#include "time_loop.h"
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fmt/format.h>
#include <kedge/base/communication.h>
#include <kedge/base/exceptions.h>
#include <kedge/base/failure.h>
#include <kedge/output/checkpoint.h>
#include <kedge/output/folder_lock.h>
#include <kedge/simulation/layout.h>
#include <kedge/simulation/scene_warnings.h>
#include <kedge/simulation/step_load.h>
#include <kedge/soil/placement.h>
#include <kedge/steps/explicit_step.h>
#include <kedge/steps/implicit_step.h>

namespace kedge
{
template <int dim>
Simulation<dim>::Simulation(const Input& input_, const RunOptions& options_, FoundRestartFile start_)
    : input(input_),
      options(options_),
      start(std::move(start_)),
      log(input_, options),
      soil(make_grid_layout<dim>(input_), input_.material_points, input_.contact, MPI_COMM_WORLD),
      bodies(make_rigid_systems(input_.systems, dim)),
      writer(input_.output, options.output_directory, states_of(input_.material_points.layers), MPI_COMM_WORLD),
      checkpoints(input_.output, options.output_directory)
{
  if (!input.body_force.empty())
    body_force.emplace(input.body_force);
  for (const std::string& warning : find_warnings(input, bodies))
    log.report().warn(warning);
  if (options.dumps)
    saved_system = {options.dumps->path, options.dumps->iteration};
}

/// Nothing of an earlier run in the same folder stays.
template <int dim> void Simulation<dim>::generate()
{
  writer.keep_until(0);
  pass_on(writer.take_warnings());
  agree(MPI_COMM_WORLD, [&] { checkpoints.remove_files(); });
  copy_input();
  if (const BlockSize block = describe_block(input); block.is_rounded)
    log.report().line("soil: " + block.text);
  const auto scope = log.timings().measure("generation");
  soil.generate(std::abs(input.gravity[dim - 1]));
}

/// Errors end here while the run still stands: where one rank fails alone, nothing may be destroyed together any more.
template <int dim> ExitCode Simulation<dim>::run()
{
  try
  {
    if (start.path.empty())
      generate();
    else
      resume();
    return run_stages();
  }
  catch (...)
  {
    log.fail(current_failure());
    throw;
  }
}

template <int dim> ExitCode Simulation<dim>::run_stages()
{
  for (unsigned int number = stage_number; number < input.stages.size(); ++number)
  {
    if (!resumed)
      begin_stage(number);
    if (!run_stage())
    {
      if (saved_system.is_done)
      {
        log.finish("finished");
        log.report().line("the linear system is in " + saved_system.path);
        return success;
      }
      finish_output();
      const std::string ended = std::string("ended by ") + name_of_signal(checkpoints.told_to_end());
      log.finish(ended);
      log.report().line(ended + "; --restart goes on from " + checkpoints.files().latest);
      return checkpoints.told_to_end() == SIGINT ? interrupted : told_to_end;
    }
  }
  if (options.dumps)
    throw InputError("--step", fmt::format("the last step of the run is {}", step_number));
  finish_output();
  log.finish("finished");
  return success;
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
  forget_motion();
  if (stage->rigid_bodies && stage->surface_placement && !place_on_soil<dim>(bodies, soil))
    log.report().warn(fmt::format("stage {}: no soil lies below or above the bodies, so \"rigid body surface "
                                  "placement\" leaves them where they are",
                                  number + 1));
  log.begin_stage(stage->stepping, bodies);
  {
    const auto scope = log.timings().measure("window");
    soil.place_window(bodies, stage->track);
  }
  if (stage->rigid_bodies && stage->wished_in_place)
    bury_bodies();
}

/// The next step does not go on as the last one did.
template <int dim> void Simulation<dim>::forget_motion()
{
  newton = {};
  soil.forget_prediction();
  for (RigidPoint& point : bodies.points)
    point.last_increment.setZero();
}

/// Bodies that are wished in place begin in a hole of their shape.
template <int dim> void Simulation<dim>::bury_bodies()
{
  adapt(); // the finer the cells, the smaller the steps of the hole
  const long long removed = soil.remove_buried(bodies);
  log.report().line(fmt::format("{} material points inside buried bodies removed", removed));
  if (removed == 0)
    log.report().warn(
        fmt::format("stage {}: no material point has its centre in the bodies that are wished in place, so "
                    "their soil is still there; take cells as fine as they are thick",
                    stage_number + 1));
  replaces_soil = true;
}

/// The method, step by step: solve for the trial state, make it the committed one or try a smaller step. False where
/// the run was told to end or has written the system that it was made for.
template <int dim> bool Simulation<dim>::run_stage()
{
  Clock clock(requested_steps(stage->stepping), input.solver.minimum_step_fraction);
  if (resumed)
    clock.resume(*resumed);
  resumed.reset();
  while (!clock.at_end())
  {
    if (!step) // how far a body's corners go changes as it turns
      limit_steps(clock);
    log.timings().begin_step(step_number + 1);
    const NewtonReport report = attempt_step(clock);
    const double share = clock.step_fraction(), steps_before = clock.steps_done();
    if (has_dumped(report))
      return false;
    if (report.converged)
    {
      commit_step();
      clock.advance();
      ++step_number;
    }
    log.count(report, clock, step_number);
    if (report.converged)
    {
      log.progress(report, clock, share, summarise_step());
      write_output(clock, steps_before, false);
      if (clock.at_end())
        end_stage();
      if (!save_if_due(clock))
      {
        if (!clock.at_end())
          end_stage();
        return false;
      }
    }
    else if (!clock.cut() && !bring_into_balance(clock))
      give_up(clock, report);
  }
  return true;
}

template <int dim> bool Simulation<dim>::dumps_now() const
{
  return options.dumps && (options.dumps->step == 0 || options.dumps->step == step_number + 1);
}

/// Whether the step was the one whose system is to be written, and all is done.
template <int dim> bool Simulation<dim>::has_dumped(const NewtonReport& report) const
{
  if (!saved_system.is_done && report.converged && dumps_now())
    throw InputError("--iteration", fmt::format("step {} has {} linear systems", step_number + 1, report.iterations));
  return saved_system.is_done;
}

/// Steps in which bodies go too far for the cells at them give too much resistance, or the bodies go through the soil.
template <int dim> void Simulation<dim>::limit_steps(Clock& clock)
{
  const StepLimit limit = find_step_limit(*stage, bodies, soil.mesh().layout().base_size);
  if (clock.keep_below(limit.fraction))
    return;
  NewtonReport nothing;
  nothing.failure = refusal_of(limit, *stage, input.solver.minimum_step_fraction);
  give_up(clock, nothing);
}

/// Commits nothing; what was prepared survives a cut. Gives up where the equations cannot even be set up.
template <int dim> NewtonReport Simulation<dim>::attempt_step(const Clock& clock)
{
  try
  {
    if (!step)
      prepare_step();
    StepLoad load = load_at(clock);
    load.history = newton;
    const NewtonReport report = step->solve(load);
    newton = report.history;
    if (!report.converged)
      newton.at_rest = 0.;
    return report;
  }
  catch (const SolverError& error)
  {
    rethrow_if_alone("step");
    NewtonReport nothing;
    nothing.failure = error.what();
    give_up(clock, nothing);
  }
  catch (const InputError&) // a body force, say, that has no value any more
  {
    rethrow_if_alone("step");
    save_what_is_there(clock);
    end_stage();
    throw;
  }
}

/// Fits soil and mesh to where the bodies are, then sets up basis, numbering, contact pairs and matrix.
template <int dim> void Simulation<dim>::prepare_step()
{
  move_window();
  clean();
  adapt();
  log.warn_of_cut_domains(soil.particles().n_cut(), step_number);
  log.warn_of_no_soil(soil.particles().n_global(), step_number);
  if (stage->rigid_bodies)
    log.warn_of_passage(bodies, step_number);
  step = make_step();
  replaces_soil = false;
}

template <int dim> void Simulation<dim>::move_window()
{
  {
    const auto scope = log.timings().measure("window");
    soil.move_window(bodies, stage->track);
  }
  if (has_warned_of_window ||
      !reach_beyond<dim>(soil.mesh().leaves().window, extent_of<dim>(bodies), soil.mesh().layout()))
    return;
  log.report().warn(fmt::format("step {}: a body reaches beyond a plane of the window, which may not follow it in "
                                "that direction, into soil that is not active; set \"advance\" to \"both\"",
                                step_number));
  has_warned_of_window = true;
}

template <int dim> void Simulation<dim>::clean()
{
  const auto scope = log.timings().measure("clean");
  log.tell_removed(soil.clean(stage->stepping.type != StageType::static_), step_number);
}

template <int dim> void Simulation<dim>::adapt()
{
  const auto scope = log.timings().measure("adapt");
  if (stage->adaptivity.type == AdaptivityType::rigid_body_surface && stage->rigid_bodies)
    soil.adapt(bodies, stage->adaptivity);
  else
    soil.split(bodies); // the cells stay as the last stage has left them
}

template <int dim> std::unique_ptr<TrialStep<dim>> Simulation<dim>::make_step()
{
  const StepContext<dim> context{input.gravity, input.basis,
                                 input.solver,  *stage,
                                 soil,          bodies,
                                 log.timings(), body_force ? &*body_force : nullptr,
                                 replaces_soil, dumps_now() ? &saved_system : nullptr};
  if (stage->stepping.type == StageType::explicit_)
  {
    if (dumps_now())
      throw InputError("--step", fmt::format("step {} is explicit and solves no linear systems", step_number + 1));
    auto explicit_step = std::make_unique<ExplicitStep<dim>>(context);
    log.tell_time_step(stage->stepping, explicit_step->stable_step());
    return explicit_step;
  }
  return std::make_unique<ImplicitStep<dim>>(context);
}

template <int dim> StepLoad Simulation<dim>::load_at(const Clock& clock) const
{
  return kedge::load_at(clock, *stage, bodies, log.steps_in_stage() == 0);
}

/// Makes the trial state of soil and bodies the committed one.
template <int dim> void Simulation<dim>::commit_step()
{
  const SoilIncrements increments = step->soil_increments();
  reactions = step->reactions();
  touches = stage->rigid_bodies ? soil.contact().touches() : decltype(touches)();
  step->move_bodies(bodies);
  dofs = step->n_dofs();
  basis_bytes = step->basis_bytes();

  const auto scope = log.timings().measure("commit");
  step.reset(); // its memory is not needed any more
  soil.commit(increments, stage->rigid_bodies ? &bodies : nullptr);
  log.tell_lost(soil.particles().lost(), step_number);
}

template <int dim> StepSummary Simulation<dim>::summarise_step() const
{
  StepSummary summary;
  summary.step = step_number;
  summary.particles = soil.particles().n_global();
  summary.deleted = soil.n_deleted();
  summary.dofs = dofs;
  const bool touches = stage->rigid_bodies;
  summary.penetration = touches ? soil.contact().deepest_penetration() : 0.;
  summary.compression = touches ? soil.contact().largest_compression() : 0.;
  return summary;
}

template <int dim> void Simulation<dim>::end_stage()
{
  step.reset();
  const ParticleSet<dim>& particles = soil.particles();
  log.end_stage(summarise_step(), soil.count_cells(), particles.mass(), particles.bytes(), basis_bytes);
}

template class Simulation<2>;
template class Simulation<3>;

namespace
{
/// What a run goes on from; no path where it begins anew.
FoundRestartFile find_start(const Input& input, const RunOptions& options)
{
  const RestartFiles files(restart_folder(input.output, options.output_directory));
  const bool goes_on =
      options.restart == Restart::yes ||
      (options.restart == Restart::automatic && max_over_ranks(any_restart_file(files), MPI_COMM_WORLD) > 0.);
  return goes_on ? find_restart_file(files, MPI_COMM_WORLD) : FoundRestartFile();
}
} // namespace

ExitCode run_simulation(const Input& input, const RunOptions& options)
{
  refuse_excessive_size(input, memory_of_machines(MPI_COMM_WORLD), "the machines that the run has");
  const FoundRestartFile start = find_start(input, options); // before anything is written
  FolderLock lock;
  agree(MPI_COMM_WORLD,
        [&]
        {
          if (rank_of(MPI_COMM_WORLD) != 0)
            return;
          if (start.path.empty())
            refuse_to_replace_input(input, options);
          lock.hold(options.output_directory);
        });
  return input.dimension == 2 ? Simulation<2>(input, options, start).run() : Simulation<3>(input, options, start).run();
}
} // namespace kedge
