// The files of a run, written for one moment at a time when they are due.
#pragma once

#include <kedge/contact/contact.h>
#include <kedge/output/grids.h>
#include <kedge/output/history.h>
#include <kedge/output/missed_files.h>
#include <kedge/output/parameters.h>
#include <kedge/output/schedule.h>
#include <map>
#include <optional>
#include <utility>

namespace kedge
{
/// Everything a snapshot shows of one moment.
template <int dim> struct Snapshot
{
  const ParticleSet<dim>& particles;
  const BackgroundMesh<dim>& mesh;
  const RigidSystems& bodies;
  const std::vector<Vector6>& reactions; ///< of the conditions on each rigid point, N and N m; empty: all zero
  const std::vector<typename Contact<dim>::Touch>& touches; ///< of this rank
  unsigned int stage;                                       ///< from 1
  unsigned int step;       ///< number in the files' names: 2 after the first converged step
  double time, total_time; ///< since the stage began (static: load fraction), since the run began
};

/// Writes the particles, bodies and cells of a run when they are due. What the disk has no room for is a warning; rows
/// of the bodies' table and entries of the lists follow when there is room. All functions are collective; any other
/// FileError of one rank is thrown on all.
template <int dim> class OutputWriter
{
public:
  /// `states`: by layer, the state variables that its law uses.
  OutputWriter(const OutputParameters& parameters, const std::string& run_directory,
               const std::vector<std::vector<StateVariable>>& states, MPI_Comm communicator);

  /// Creates the folders, first of all. Keeps what an earlier run has left in the folders up to and including `step`,
  /// so that a run goes on from there; 0: nothing. Removes the rest.
  void keep_until(unsigned int step);
  /// Of so many requested steps.
  void begin_stage(unsigned int n_steps);
  /// Writes nothing twice: neither a step that this run has written nor, after a restart, one of the earlier run.
  void write_if_due(const Snapshot<dim>& state, const StepSpan& step, bool last_of_stage);
  /// At the end of a run: tries once more to write what waits, and sums up what is missing.
  void finish();
  /// Those since this was asked last, on rank 0.
  std::vector<std::string> take_warnings() { return std::exchange(warnings, {}); }

private:
  using Layers = std::vector<std::vector<ParticleView>>;

  void write_snapshot(const Snapshot<dim>& state, const Layers& layers);
  void write_tables(const Snapshot<dim>& state, const Layers& layers);
  void write_rows(const std::function<void()>& of_root);
  void write_piece(const std::string& series, UnstructuredGrid grid, const Snapshot<dim>& state);
  void write_on_root(const std::string& series, const UnstructuredGrid& grid, const Snapshot<dim>& state);
  void list(const std::string& series, const std::string& file, double time);

  OutputParameters parameters;
  std::string run_folder;
  unsigned int n_layers;
  MPI_Comm communicator;
  std::string vtk_folder, csv_folder;
  OutputSchedule vtk_schedule, csv_schedule;
  std::vector<std::vector<ParticleField>> vtk_particle_fields, csv_particle_fields; ///< by layer
  std::vector<BodyField> vtk_body_fields;
  BodyHistory history;
  std::map<std::string, PvdSeries> series_lists; ///< by the start of the files' names
  MissedFiles missed_vtk{"VTK files"}, missed_csv{"tables of material points"};
  bool rows_wait = false; ///< of the history
  std::vector<std::string> warnings;
  std::optional<unsigned int> resumed;            ///< last step of the earlier run that counts
  std::optional<unsigned int> vtk_step, csv_step; ///< step that was written last
};
} // namespace kedge
