#include <filesystem>
#include <fmt/format.h>
#include <kedge/base/communication.h>
#include <kedge/base/exceptions.h>
#include <kedge/base/failure.h>
#include <kedge/output/earlier_files.h>
#include <kedge/output/snapshots.h>

namespace kedge
{
namespace
{
constexpr int ranks_per_file = 16; // fewer files than ranks, and no file that a rank has no room for

void create_folder(const std::string& folder)
{
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    throw FileError(folder, "cannot be created: " + error.message());
}

std::string file_name(const std::string& series, unsigned int step, const std::string& ending)
{
  return fmt::format("{}_{:05}{}", series, step, ending);
}
} // namespace

template <int dim>
OutputWriter<dim>::OutputWriter(const OutputParameters& parameters_, const std::string& run_directory,
                                const std::vector<std::vector<StateVariable>>& states, MPI_Comm communicator_)
    : parameters(parameters_),
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
  agree(communicator,
        [&]
        {
          if (rank_of(communicator) != 0)
            return;
          create_folder(run_directory);
          if (parameters.vtk.on)
            create_folder(vtk_folder);
          if (parameters.csv.on)
            create_folder(csv_folder);
        });
}

template <int dim> void OutputWriter<dim>::keep_until(const unsigned int step)
{
  if (step > 0)
    resumed = vtk_step = csv_step = step;
  agree(communicator,
        [&]
        {
          if (rank_of(communicator) != 0)
            return;
          remove_moments_after(step, vtk_folder, csv_folder);
          if (step > 0 && parameters.csv.on)
            history.resume_after(step);
        });
}

template <int dim> void OutputWriter<dim>::begin_stage(unsigned int n_steps)
{
  vtk_schedule.begin_stage(n_steps);
  csv_schedule.begin_stage(n_steps);
}

template <int dim>
void OutputWriter<dim>::write_if_due(const Snapshot<dim>& state, unsigned int converged_steps_in_stage,
                                     bool last_of_stage)
{
  const bool vtk =
      parameters.vtk.on && vtk_step != state.step && vtk_schedule.due(converged_steps_in_stage, last_of_stage);
  const bool csv =
      parameters.csv.on && csv_step != state.step && csv_schedule.due(converged_steps_in_stage, last_of_stage);
  if (!vtk && !csv)
    return;
  if (vtk)
    vtk_step = state.step;
  if (csv)
    csv_step = state.step;
  const Layers layers = particles_by_layer(state.particles, n_layers);

  if (vtk)
    write_snapshot(state, layers);
  if (csv && !parameters.csv.particle_fields.empty())
    for (unsigned int layer = 0; layer < n_layers; ++layer)
    {
      const std::vector<ParticleField>& fields = csv_particle_fields[layer];
      const std::string name = file_name(fmt::format("mps_{}", layer + 1), state.step, ".csv");
      write_particle_csv(tabulate(layers[layer], fields), fields, state.time, csv_folder + "/" + name, communicator);
    }
  const bool any_column =
      !parameters.csv.body_fields.empty() || !state.bodies.tracked.empty() || !state.bodies.joints.empty();
  if (csv && any_column && !state.bodies.empty())
    agree(communicator,
          [&]
          {
            if (rank_of(communicator) == 0)
              history.append(state.bodies, state.reactions, state.time, state.stage, state.step);
          });
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
  agree(communicator,
        [&]
        {
          if (rank_of(communicator) != 0)
            return;
          if (!state.bodies.empty())
            write_on_root("body", rigid_points(state.bodies, state.reactions, vtk_body_fields), state);
          if (!state.bodies.surfaces.empty())
            write_on_root("surface", surfaces, state);
          if (!state.bodies.tracked.empty())
            write_on_root("tracked", tracked_nodes(state.bodies), state);
        });
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
  agree(communicator,
        [&]
        {
          if (rank % ranks_per_file != 0)
            return;
          std::vector<std::string> pieces;
          for (int first = 0; first < n_ranks; first += ranks_per_file)
            pieces.push_back(file_name(series, state.step, fmt::format("_{}.vtu", first / ranks_per_file)));
          write_vtu(grid, vtk_folder + "/" + pieces[piece], state.total_time);
          if (rank != 0)
            return;
          const std::string joined = file_name(series, state.step, ".pvtu");
          write_pvtu(grid, pieces, vtk_folder + "/" + joined);
          list(series, joined, state.total_time);
        });
}

template <int dim>
void OutputWriter<dim>::write_on_root(const std::string& series, const UnstructuredGrid& grid,
                                      const Snapshot<dim>& state)
{
  const std::string file = file_name(series, state.step, ".vtu");
  write_vtu(grid, vtk_folder + "/" + file, state.total_time);
  list(series, file, state.total_time);
}

template <int dim> void OutputWriter<dim>::list(const std::string& series, const std::string& file, double time)
{
  const auto [entry, is_new] = series_lists.try_emplace(series, vtk_folder + "/" + series + ".pvd");
  if (is_new && resumed)
    entry->second.resume_after(*resumed);
  entry->second.add(time, file);
}

template class OutputWriter<2>;
template class OutputWriter<3>;
} // namespace kedge
