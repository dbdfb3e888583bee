#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <kedge/base/communication.h>
#include <kedge/base/exceptions.h>
#include <kedge/base/failure.h>
#include <kedge/base/kokkos.h>
#include <kedge/simulation/run_log.h>
#include <kedge/simulation/version.h>

namespace kedge
{
std::string format_residuals(const NewtonReport& newton)
{
  std::string text;
  for (const double residual : newton.residuals)
    text += fmt::format("{}{:.2e}", text.empty() ? "" : " ", residual);
  return text;
}

RunLog::RunLog(const Input& input_, const RunOptions& options_)
    : input(input_),
      options(options_),
      terminal(rank_of(MPI_COMM_WORLD) == 0, options_.quiet),
      clock_of_phases(planned_fault(std::getenv("KEDGE_FAULT"), rank_of(MPI_COMM_WORLD)))
{
  summary.version = version();
  summary.commit = commit();
  summary.input_file = options.input_file;
  summary.back_end = back_end();
  summary.gpu_requested = input.gpu;
  summary.ranks = size_of(MPI_COMM_WORLD);
  summary.libraries = library_versions();
  if (input.gpu && device_is_host)
    terminal.warn("\"GPU\" is \"on\", but this build has no GPU back end: running on the CPU");
  if (!input.gpu && !device_is_host)
    terminal.warn("\"GPU\" is \"off\", but this build has no other back end: running on the GPU");
}

void RunLog::begin_stage(const SteppingParameters& stepping, const RigidSystems& bodies)
{
  StageSummary stage;
  told_time_step = warned_of_time_step = warned_of_springs = false;
  step_length = kedge::step_length(stepping);
  stage.type = name_of(stepping.type);
  for (const RigidPoint& point : bodies.points)
    stage.start_positions.push_back({{point.pose.position[0], point.pose.position[1], point.pose.position[2]}});
  summary.stages.push_back(stage);
  write("running");
}

std::string RunLog::text_of_stages()
{
  take_times();
  return stages_as_text(summary);
}

void RunLog::resume(const SteppingParameters& stepping, const std::string& text, const unsigned int stage_number)
{
  step_length = kedge::step_length(stepping);
  read_stages(text, summary);
  earlier.total_seconds = summary.total_seconds;
  earlier.seconds = summary.seconds;
  summary.stages.resize(stage_number + 1);
  write("running");
}

/// Below this share of the soil's own time step a warning says that contact makes it short.
static constexpr double much_shorter = 0.1;

void RunLog::tell_time_step(const SteppingParameters& stepping, const StableStep& stable)
{
  const double critical = stable.all;
  const std::size_t stage = summary.stages.size();
  if (!told_time_step)
    terminal.line(fmt::format("stage {}: critical time step {:.3g} s, {} {:.3g} s", stage, critical,
                              stepping.dt > 0. ? "given" : "taken",
                              stepping.dt > 0. ? stepping.dt : stepping.cfl * critical));
  if (stepping.dt > critical && !warned_of_time_step)
  {
    terminal.warn(fmt::format("stage {}: \"dt\", {:.3g} s, is longer than the critical time step, {:.3g} s, and time "
                              "steps are made no longer than that",
                              stage, stepping.dt, critical));
    warned_of_time_step = true;
  }
  if (critical < much_shorter * stable.soil && !warned_of_springs)
  {
    terminal.warn(fmt::format("stage {}: contact springs allow time steps of {:.3g} s, the soil alone of {:.3g} s; a "
                              "smaller \"normal penalty factor\" or more mass of free bodies makes them longer",
                              stage, critical, stable.soil));
    warned_of_springs = true;
  }
  told_time_step = true;
}

void RunLog::tell_removed(const HopelessParticles& removed, const unsigned int step)
{
  if (removed.distorted + removed.isolated > 0)
    tell_gone(fmt::format("step {}: {} distorted and {} isolated material points removed, {:.3g} kg", step,
                          removed.distorted, removed.isolated, removed.mass),
              "\"removed mass\" in summary.json tells how much it is in each stage", removed.mass,
              has_warned_of_removed);
}

void RunLog::tell_lost(const LostParticles& lost, const unsigned int step)
{
  const long long number = lost.number - told_lost.number;
  const double mass = lost.mass - told_lost.mass;
  if (number > 0)
    tell_gone(fmt::format("step {}: {} material points have left the grid, {:.3g} kg", step, number, mass),
              "they are gone, which a larger domain would prevent", mass, has_warned_of_lost);
  told_lost = lost;
}

void RunLog::tell_gone(const std::string& sentence, const std::string& advice, const double mass, bool& has_warned)
{
  summary.stages.back().removed_mass += mass;
  if (has_warned)
    terminal.line(sentence);
  else
    terminal.warn(sentence + "; " + advice);
  has_warned = true;
}

void RunLog::count(const NewtonReport& newton, const Clock& clock, const unsigned int step)
{
  StageSummary& counts = summary.stages.back();
  counts.steps += newton.converged;
  counts.cuts = clock.cuts(); // of the whole stage, also where a run goes on
  (counts.type == name_of(StageType::explicit_) ? counts.time_steps : counts.newton_iterations) += newton.iterations;
  counts.krylov_iterations += newton.krylov_iterations;
  if (options.verbose)
    terminal.line(fmt::format("step {} {}: {} Krylov iterations, residuals {}", step,
                              newton.converged ? "converged" : newton.failure, newton.krylov_iterations,
                              format_residuals(newton)));
}

void RunLog::warn_of_cut_domains(const long long here, const unsigned int step)
{
  if (has_warned_of_cut_domains)
    return;
  const long long n_cut = sum_over_ranks(here, MPI_COMM_WORLD);
  has_warned_of_cut_domains = n_cut > 0;
  if (n_cut > 0)
    terminal.warn(fmt::format("step {}: the domains of {} material points reach farther than the neighbours of their "
                              "cells and are cut there; more material points per element keep them narrower",
                              step, n_cut));
}

void RunLog::warn_of_no_soil(const long long points, const unsigned int step)
{
  if (points == 0 && !has_warned_of_no_soil)
    terminal.warn(fmt::format("step {}: no material points are left, so bodies move without soil from here on", step));
  has_warned_of_no_soil = has_warned_of_no_soil || points == 0;
}

void RunLog::warn_of_passage(const RigidSystems& bodies, const unsigned int step)
{
  if (!passage)
    passage.emplace(bodies, input.dimension);
  if (has_warned_of_passage)
    return;
  const auto through = passage->find(bodies);
  has_warned_of_passage = through.has_value();
  if (through)
    terminal.warn(fmt::format("step {}: surfaces {} and {} pass through each other, for bodies touch soil only; where "
                              "they would meet, join them or hold them apart",
                              step, through->first + 1, through->second + 1));
}

void RunLog::progress(const NewtonReport& newton, const Clock& clock, const double share, const StepSummary& state)
{
  StageSummary& stage = summary.stages.back();
  stage.penetration = std::max(stage.penetration, state.penetration);
  warn_of_soft_contact(state);
  ProgressLine shown;
  shown.stage = summary.stages.size();
  shown.n_stages = input.stages.size();
  shown.time = clock.steps_done() * step_length;
  shown.end = clock.requested_steps() * step_length;
  shown.step = state.step;
  shown.increment = share * step_length;
  shown.iterations = newton.iterations;
  shown.is_explicit = stage.type == name_of(StageType::explicit_);
  shown.krylov_iterations = newton.krylov_iterations;
  shown.cuts = clock.cuts();
  shown.deleted = state.deleted;
  shown.particles = state.particles;
  terminal.progress(shown);
}

void RunLog::warn_of_soft_contact(const StepSummary& state)
{
  constexpr double too_far = 0.5;
  if (has_warned_of_soft_contact || state.compression <= too_far)
    return;
  has_warned_of_soft_contact = true;
  terminal.warn(
      fmt::format("step {}: soil has gone {:.2g} of a material point's size into a body, whose springs are too "
                  "soft for this load, so forces are too small; set a larger \"normal penalty factor\"",
                  state.step, state.compression));
}

void RunLog::end_stage(const StepSummary& state, const long long cells, const double mass, const double particle_bytes,
                       const double basis_bytes)
{
  terminal.end_progress();
  const MPI_Comm world = MPI_COMM_WORLD;
  StageSummary& stage = summary.stages.back();
  stage.particles = state.particles;
  stage.dofs = state.dofs;
  stage.cells = cells;
  stage.deleted = state.deleted;
  for (std::size_t i = 0; i + 1 < summary.stages.size(); ++i)
    stage.deleted -= summary.stages[i].deleted;
  stage.mass = sum_over_ranks(mass, world);
  const double n = std::max(1ll, state.particles);
  stage.particle_bytes = sum_over_ranks(particle_bytes, world) / n;
  stage.basis_bytes = sum_over_ranks(basis_bytes, world) / n;
}

void RunLog::finish(const std::string& status)
{
  terminal.end_progress();
  write(status);
  if (status == "finished")
    terminal.line(fmt::format("finished in {:.1f} s, results in {}", summary.total_seconds, options.output_directory));
}

void RunLog::fail(const Failure& failure)
{
  terminal.end_progress();
  const int rank = rank_of(MPI_COMM_WORLD);
  const bool is_alone = !failure.is_named || !fails_everywhere("run");
  const std::string whose = is_alone && summary.ranks > 1 ? fmt::format("rank {}: ", rank) : "";
  take_stock("failed: " + whose + failure.message);
  try
  {
    if (rank == 0)
      write_summary(summary, path());
    else if (is_alone)
      change_status(summary, path());
  }
  catch (const FileError& error) // of which the terminal hears below
  {
    terminal.warn(error.what());
  }
  if (is_alone)
    abort_all_ranks(failure);
}

std::string RunLog::path() const { return (std::filesystem::path(options.output_directory) / "summary.json").string(); }

void RunLog::take_times()
{
  summary.seconds = earlier.seconds;
  for (const auto& [phase, seconds] : clock_of_phases.seconds())
    summary.seconds[phase] += seconds;
  const std::chrono::duration<double> since = std::chrono::steady_clock::now() - start;
  summary.total_seconds = earlier.total_seconds + since.count();
}

void RunLog::take_stock(const std::string& status)
{
  summary.status = status;
  summary.warnings = terminal.warnings();
  summary.peak_memory = peak_memory();
  take_times();
}

void RunLog::write(const std::string& status)
{
  take_stock(status);
  summary.peak_memory = max_over_ranks(summary.peak_memory, MPI_COMM_WORLD);
  const auto write_on_root = [&]
  {
    if (rank_of(MPI_COMM_WORLD) == 0)
      write_summary(summary, path());
  };
  const std::string problem = try_to_write("summary", [&] { agree(MPI_COMM_WORLD, write_on_root); });
  if (!problem.empty())
    terminal.warn(fmt::format("{}; it should say: {}", problem, status));
}
} // namespace kedge
