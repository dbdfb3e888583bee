#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <kedge/base/communication.h>
#include <kedge/base/exceptions.h>
#include <kedge/base/failure.h>
#include <kedge/output/earlier_files.h>
#include <kedge/output/snapshots.h>
#include <kedge/output/text_file.h>

namespace kedge
{
namespace
{
constexpr int ranks_per_file = 16; // fewer files than ranks, and no file that a rank has no room for

std::string file_name(const std::string& series, unsigned int step, const std::string& ending)
{
  return fmt::format("{}_{:05}{}", series, step, ending);
}
} // namespace

template <int dim>
OutputWriter<dim>::OutputWriter(const OutputParameters& parameters_, const std::string& run_directory,
                                const std::vector<std::vector<StateVariable>>& states, MPI_Comm communicator_)
    : parameters(parameters_),
      run_folder(run_directory),
      n_layers(states.size()),
      communicator(communicator_),
      vtk_folder((std::filesystem::path(run_directory) / parameters.vtk.directory).string()),
      csv_folder((std::filesystem::path(run_directory) / parameters.csv.directory).string()),
      vtk_schedule(parameters.vtk.percent),
      csv_schedule(parameters.csv.percent),
      vtk_body_fields(select_body_fields(parameters.vtk.body_fields)),
      history((std::filesystem::path(csv_folder) / "rigid_body.csv").string(),
              select_body_fields(parameters.csv.body_fields))
{
  for (const std::vector<StateVariable>& of_law : states)
  {
    vtk_particle_fields.push_back(select_particle_fields<dim>(parameters.vtk.particle_fields, of_law));
    csv_particle_fields.push_back(select_particle_fields<dim>(parameters.csv.particle_fields, of_law));
  }
}

template <int dim> void OutputWriter<dim>::keep_until(const unsigned int step)
{
  agree(communicator,
        [&]
        {
          if (rank_of(communicator) != 0)
            return;
          create_folder(run_folder);
          if (parameters.vtk.on)
            create_folder(vtk_folder);
          if (parameters.csv.on)
            create_folder(csv_folder);
        });
  if (step > 0)
    resumed = vtk_step = csv_step = step;
  const auto keep = [&]
  {
    if (rank_of(communicator) != 0)
      return;
    if (step > 0 && parameters.csv.on)
      history.resume_after(step);
    remove_moments_after(step, vtk_folder, csv_folder);
  };
  const std::string problem = try_to_write("output", [&] { agree(communicator, keep); });
  if (!problem.empty())
    warnings.push_back(problem + "; it will be with the next files: free some room");
}

template <int dim> void OutputWriter<dim>::begin_stage(unsigned int n_steps)
{
  vtk_schedule.begin_stage(n_steps);
  csv_schedule.begin_stage(n_steps);
}

template <int dim>
void OutputWriter<dim>::write_if_due(const Snapshot<dim>& state, const StepSpan& step, bool last_of_stage)
{
  if (rows_wait)
    write_rows([&] { history.write(); });
  const bool vtk = parameters.vtk.on && vtk_step != state.step && vtk_schedule.due(step, last_of_stage);
  const bool csv = parameters.csv.on && csv_step != state.step && csv_schedule.due(step, last_of_stage);
  if (!vtk && !csv)
    return;
  if (vtk)
    vtk_step = state.step;
  if (csv)
    csv_step = state.step;
  const Layers layers = particles_by_layer<dim>(state.mesh, state.particles, n_layers);

  if (csv)
    write_tables(state, layers);
  if (vtk)
    write_snapshot(state, layers);
}

template <int dim> void OutputWriter<dim>::finish()
{
  if (rows_wait)
    write_rows([&] { history.write(); });
  if (rows_wait)
    warnings.push_back(fmt::format("the last {} rows of rigid_body.csv could not be written", history.count_waiting()));
  for (auto& [series, entries] : series_lists) // on the root
    if (!entries.is_written())
      try
      {
        entries.write();
      }
      catch (const DiskError& error)
      {
        warnings.push_back(fmt::format("{}; the list lacks files that are there", error.what()));
      }
  missed_vtk.sum_up(warnings);
  missed_csv.sum_up(warnings);
}

template <int dim> void OutputWriter<dim>::write_tables(const Snapshot<dim>& state, const Layers& layers)
{
  const bool any_column =
      !parameters.csv.body_fields.empty() || !state.bodies.tracked.empty() || !state.bodies.joints.empty();
  if (any_column && !state.bodies.empty())
    write_rows([&] { history.append(state.bodies, state.reactions, state.time, state.stage, state.step); });
  if (parameters.csv.particle_fields.empty())
    return;
  for (unsigned int layer = 0; layer < n_layers; ++layer)
  {
    const std::vector<ParticleField>& fields = csv_particle_fields[layer];
    const std::string path = csv_folder + "/" + file_name(fmt::format("mps_{}", layer + 1), state.step, ".csv");
    const ParticleTable table = tabulate(layers[layer], fields);
    missed_csv.attempt([&] { write_particle_csv(table, fields, state.time, path, communicator); });
  }
  missed_csv.end_moment(state.step, warnings);
}

/// Of the bodies' table. Rows that do not fit wait for the next step.
template <int dim> void OutputWriter<dim>::write_rows(const std::function<void()>& of_root)
{
  const bool waited = rows_wait;
  const auto work = [&]
  {
    if (rank_of(communicator) == 0)
      of_root();
  };
  const std::string problem = try_to_write("output", [&] { agree(communicator, work); });
  rows_wait = !problem.empty();
  if (const std::string earlier = history.take_earlier_table(); !earlier.empty())
    warnings.push_back("rigid_body.csv has other columns from here on; the rows before are in " + earlier);
  if (rows_wait && !waited)
    warnings.push_back(problem + "; its rows wait in memory and follow when there is room: free some");
  if (!rows_wait && waited)
  {
    const unsigned int n_lost = history.take_lost();
    const std::string lost = n_lost == 0 ? "" : fmt::format("; {} more are lost, for too many had to wait", n_lost);
    warnings.push_back("the rows of rigid_body.csv that had to wait are written" + lost);
  }
}

template <int dim> void OutputWriter<dim>::write_snapshot(const Snapshot<dim>& state, const Layers& layers)
{
  for (unsigned int layer = 0; layer < n_layers; ++layer)
    write_piece(fmt::format("mps_{}", layer + 1), particle_boxes<dim>(layers[layer], vtk_particle_fields[layer]),
                state);
  write_piece("mesh", soil_cells(state.mesh, state.particles), state);
  std::vector<ContactForce> contact;
  for (const auto& touch : state.touches)
    contact.push_back({touch.position, touch.force, touch.surface});
  const UnstructuredGrid surfaces = body_surfaces<dim>(state.bodies, contact, communicator);
  if (!state.bodies.empty())
    write_on_root("body", rigid_points(state.bodies, state.reactions, vtk_body_fields), state);
  if (!state.bodies.surfaces.empty())
    write_on_root("surface", surfaces, state);
  if (!state.bodies.tracked.empty())
    write_on_root("tracked", tracked_nodes(state.bodies), state);
  missed_vtk.end_moment(state.step, warnings);
}

template <int dim>
void OutputWriter<dim>::write_piece(const std::string& series, UnstructuredGrid grid, const Snapshot<dim>& state)
{
  const int n_ranks = size_of(communicator), rank = rank_of(communicator);
  if (n_ranks == 1)
    return write_on_root(series, grid, state);
  const int piece = rank / ranks_per_file;
  MPI_Comm writers = MPI_COMM_NULL;
  MPI_Comm_split(communicator, piece, rank, &writers);
  grid = gather_grid(std::move(grid), writers);
  MPI_Comm_free(&writers);
  const bool writes = rank % ranks_per_file == 0;
  std::vector<std::string> pieces;
  for (int first = 0; first < n_ranks; first += ranks_per_file)
    pieces.push_back(file_name(series, state.step, fmt::format("_{}.vtu", first / ranks_per_file)));
  const std::string mine = vtk_folder + "/" + pieces[piece];
  const auto write_all = [&]
  {
    agree(communicator,
          [&]
          {
            if (writes)
              write_vtu(grid, mine, state.total_time);
          });
    agree(communicator,
          [&]
          {
            if (rank != 0)
              return;
            const std::string joined = file_name(series, state.step, ".pvtu");
            write_pvtu(grid, pieces, vtk_folder + "/" + joined);
            list(series, joined, state.total_time);
          });
  };
  missed_vtk.attempt(
      [&]
      {
        try
        {
          write_all();
        }
        catch (const DiskError&) // one piece is no use without the others
        {
          if (writes)
            std::remove(mine.c_str());
          throw;
        }
      });
}

template <int dim>
void OutputWriter<dim>::write_on_root(const std::string& series, const UnstructuredGrid& grid,
                                      const Snapshot<dim>& state)
{
  const std::string file = file_name(series, state.step, ".vtu");
  const auto write = [&]
  {
    if (rank_of(communicator) != 0)
      return;
    write_vtu(grid, vtk_folder + "/" + file, state.total_time);
    list(series, file, state.total_time);
  };
  missed_vtk.attempt([&] { agree(communicator, write); });
}

/// A list that does not fit is written with its next entry. On the root.
template <int dim> void OutputWriter<dim>::list(const std::string& series, const std::string& file, double time)
{
  const auto [entry, is_new] = series_lists.try_emplace(series, vtk_folder + "/" + series + ".pvd");
  if (is_new && resumed)
    entry->second.resume_after(*resumed);
  const bool was_written = entry->second.is_written();
  try
  {
    entry->second.add(time, file);
  }
  catch (const DiskError& error)
  {
    if (was_written)
      warnings.push_back(fmt::format("{}; the list is written again with the next file: free some room", error.what()));
  }
}

template class OutputWriter<2>;
template class OutputWriter<3>;
} // namespace kedge
