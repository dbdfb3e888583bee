#include "time_loop.h"
#include <filesystem>
#include <fmt/format.h>
#include <kedge/base/communication.h>
#include <kedge/base/exceptions.h>
#include <kedge/base/failure.h>
#include <kedge/output/checkpoint.h>
#include <kedge/simulation/version.h>
#include <nlohmann/json.hpp>

// How a run is saved and goes on.

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
} // namespace

template <int dim> void Simulation<dim>::copy_input() const
{
  const std::string copy = (std::filesystem::path(options.output_directory) / "input.json").string();
  agree(MPI_COMM_WORLD,
        [&]
        {
          if (rank_of(MPI_COMM_WORLD) == 0)
            replace_text_file(copy, input_for_any_folder(input));
        });
}

template <int dim> void Simulation<dim>::resume()
{
  for (const std::string& problem : start.problems)
    log.report().warn(problem);
  const RunProgress progress = read_checkpoint<dim>(soil, bodies, input.effective_json, start.path);
  if (progress.program != name_of_program())
    log.report().warn(fmt::format("{} comes from {}; this is {}, so results may differ from those of one run",
                                  start.path, progress.program, name_of_program()));
  enter_stage(progress.stage);
  log.resume(stage->stepping, progress.summary, stage_number);
  writer.keep_until(progress.step);
  copy_input();
  step_number = progress.step;
  overshoots = progress.overshoots;
  has_warned_of_window = progress.has_warned_of_window;
  resumed = progress.clock;
  log.report().line(fmt::format("going on after step {} from {}", step_number, start.path));
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
  if (is_due)
    write_or_warn("restart file", [&] { write_restart_file(clock, checkpoints.files().latest); });
  return true;
}

template <int dim> void Simulation<dim>::write_restart_file(const Clock& clock, const std::string& path)
{
  const auto scope = log.timings().measure("restart files");
  checkpoints.make_folder();
  const RunProgress progress{stage_number, clock.state(),        step_number,          log.steps_in_stage(),
                             overshoots,   has_warned_of_window, log.text_of_stages(), name_of_program()};
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

template void Simulation<2>::copy_input() const;
template void Simulation<2>::resume();
template bool Simulation<2>::save_if_due(const Clock&);
template void Simulation<2>::write_or_warn(const std::string&, const std::function<void()>&);
template void Simulation<2>::save_failed_state(const Clock&);
template void Simulation<3>::copy_input() const;
template void Simulation<3>::resume();
template bool Simulation<3>::save_if_due(const Clock&);
template void Simulation<3>::write_or_warn(const std::string&, const std::function<void()>&);
template void Simulation<3>::save_failed_state(const Clock&);
} // namespace kedge
