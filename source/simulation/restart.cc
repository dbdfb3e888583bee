#include "time_loop.h"
#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <kedge/base/communication.h>
#include <kedge/base/exceptions.h>
#include <kedge/base/failure.h>
#include <kedge/output/checkpoint.h>
#include <kedge/output/text_file.h>
#include <kedge/simulation/version.h>
#include <nlohmann/json.hpp>

// What a run writes, and how it goes on from that.

namespace kedge
{
namespace
{
/// The effective input with absolute names of STL files, so that it runs from any folder.
std::string input_for_any_folder(const Input& input)
{
  nlohmann::json json = nlohmann::json::parse(input.effective_json);
  for (std::size_t s = 0; s < input.systems.size(); ++s)
    for (std::size_t i = 0; i < input.systems[s].surfaces.size(); ++i)
      if (const std::string& stl = input.systems[s].surfaces[i].stl; !stl.empty())
        json["rigid bodies"][s]["stl files"][i]["stl"] = std::filesystem::absolute(stl).lexically_normal().string();
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

std::string name_of_program() { return fmt::format("Kedge {} (commit {})", version(), commit()); }

std::string copy_of_input(const RunOptions& options)
{
  return (std::filesystem::path(options.output_directory) / "input.json").string();
}
} // namespace

void refuse_to_replace_input(const Input& input, const RunOptions& options)
{
  const std::string copy = copy_of_input(options);
  std::error_code error;
  if (!std::filesystem::equivalent(copy, options.input_file, error) || error)
    return;
  if (nlohmann::json::parse(read_text_file(copy), nullptr, false) != nlohmann::json::parse(input_for_any_folder(input)))
    throw InputError("--output", fmt::format("{} is your input file, and the run would replace it by its effective "
                                             "input; choose another folder with --output, or rename the file",
                                             copy));
}

template <int dim> void Simulation<dim>::copy_input()
{
  const std::string copy = copy_of_input(options);
  const auto write = [&]
  {
    if (rank_of(MPI_COMM_WORLD) == 0)
      replace_text_file(copy, input_for_any_folder(input));
  };
  const std::string problem = try_to_write("copy of the input", [&] { agree(MPI_COMM_WORLD, write); });
  if (!problem.empty())
    log.report().warn(problem);
}

template <int dim> void Simulation<dim>::resume()
{
  for (const std::string& problem : start.problems)
    log.report().warn(problem);
  const RunProgress progress = read_checkpoint<dim>(soil, bodies, input.effective_json, start.path);
  if (progress.program != name_of_program())
    log.report().warn(fmt::format("{} comes from {}; this is {}, so results may differ from those of one run",
                                  start.path, progress.program, name_of_program()));
  const unsigned int n_begun = progress.stage + (progress.steps_in_stage > 0 ? 1 : 0);
  if (std::any_of(input.stages.begin(), input.stages.begin() + n_begun, [](const Stage& s) { return s.rigid_bodies; }))
    soil.contact().remember_search();
  enter_stage(progress.stage);
  log.resume(stage->stepping, progress.summary, stage_number);
  writer.keep_until(progress.step);
  pass_on(writer.take_warnings());
  copy_input();
  step_number = progress.step;
  newton = progress.newton;
  has_warned_of_window = progress.has_warned_of_window;
  resumed = progress.clock;
  log.report().line(fmt::format("going on after step {} from {}", step_number, start.path));
}

/// `steps_before`: progress of the stage before the step that has led here.
template <int dim>
void Simulation<dim>::write_output(const Clock& clock, const double steps_before, const bool even_if_not_due)
{
  const auto scope = log.timings().measure("output");
  const double steps = clock.at_end() ? requested_steps(stage->stepping) : clock.steps_done(); // not rounded to ticks
  const double time = steps * step_length(stage->stepping);
  writer.write_if_due({soil.particles(), soil.mesh(), bodies, reactions, touches, stage_number + 1, step_number, time,
                       finished_time + time},
                      {steps_before, clock.steps_done()}, clock.at_end() || even_if_not_due);
  pass_on(writer.take_warnings());
}

template <int dim> void Simulation<dim>::finish_output()
{
  writer.finish();
  std::vector<std::string> warnings = writer.take_warnings();
  missed_restart_files.sum_up(warnings);
  pass_on(warnings);
}

/// What the disk has no room for.
template <int dim> void Simulation<dim>::pass_on(const std::vector<std::string>& warnings)
{
  for (const std::string& warning : warnings)
    log.report().warn(warning);
}

/// Writes a restart file where one is due. False where the run was told to end.
template <int dim> bool Simulation<dim>::save_if_due(const Clock& clock)
{
  const bool is_last = stage_number + 1 == input.stages.size();
  bool is_due = checkpoints.due();
  if (checkpoints.told_to_end())
  {
    write_restart_file(clock, checkpoints.files().latest);
    return false;
  }
  // The next stage may fail at once; a run that is at its end may go on with a later one.
  is_due = is_due || (clock.at_end() && (!is_last || checkpoints.is_on()));
  if (!is_due)
    return true;
  const auto write = [&] { write_restart_file(clock, checkpoints.files().latest); };
  write_or_warn("restart file", [&] { missed_restart_files.attempt(write); });
  std::vector<std::string> warnings;
  missed_restart_files.end_moment(step_number, warnings);
  pass_on(warnings);
  return true;
}

template <int dim> void Simulation<dim>::write_restart_file(const Clock& clock, const std::string& path)
{
  const auto scope = log.timings().measure("restart files");
  checkpoints.make_folder();
  const RunProgress progress{stage_number, clock.state(),        step_number,          log.steps_in_stage(),
                             newton,       has_warned_of_window, log.text_of_stages(), name_of_program()};
  const RestartFiles& files = checkpoints.files();
  const bool is_latest = path == files.latest;
  write_checkpoint<dim>(soil, bodies, progress, input.effective_json, path, is_latest ? files.before : "");
  if (is_latest && rank_of(MPI_COMM_WORLD) == 0) // the run has come farther than where it failed once
    std::remove(files.failed.c_str());
}

/// A file that the run can do without.
template <int dim> void Simulation<dim>::write_or_warn(const std::string& place, const std::function<void()>& write)
{
  try
  {
    write();
  }
  catch (const FileError& error)
  {
    rethrow_if_alone(place);
    log.report().warn(error.what());
  }
}

/// The state may be what fails: its file takes the place of no other one.
template <int dim> void Simulation<dim>::save_failed_state(const Clock& clock)
{
  const RestartFiles& files = checkpoints.files();
  const bool has_others = max_over_ranks(any_restart_file(files), MPI_COMM_WORLD) > 0.;
  write_restart_file(clock, has_others ? files.failed : files.latest);
}

template void Simulation<2>::copy_input();
template void Simulation<2>::resume();
template void Simulation<2>::write_output(const Clock&, double, bool);
template void Simulation<2>::finish_output();
template void Simulation<2>::pass_on(const std::vector<std::string>&);
template bool Simulation<2>::save_if_due(const Clock&);
template void Simulation<2>::write_or_warn(const std::string&, const std::function<void()>&);
template void Simulation<2>::save_failed_state(const Clock&);
template void Simulation<3>::copy_input();
template void Simulation<3>::resume();
template void Simulation<3>::write_output(const Clock&, double, bool);
template void Simulation<3>::finish_output();
template void Simulation<3>::pass_on(const std::vector<std::string>&);
template bool Simulation<3>::save_if_due(const Clock&);
template void Simulation<3>::write_or_warn(const std::string&, const std::function<void()>&);
template void Simulation<3>::save_failed_state(const Clock&);
} // namespace kedge
