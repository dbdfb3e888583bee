// Restart files: everything that survives a step, in one HDF5 file.
#pragma once

#include <kedge/contact/contact.h>
#include <kedge/particles/particle_set.h>
#include <kedge/time/clock.h>
#include <string>
#include <vector>

namespace kedge
{
/// How far a run is.
struct RunProgress
{
  unsigned int stage = 0; ///< from 0
  ClockState clock;       ///< of this stage
  unsigned int step = 1;  ///< global counter
  unsigned int steps_in_stage = 0;
  long long deleted = 0; ///< particles, since the run began; those that the particle set lost count as well
  bool has_warned_of_window = false;
  std::string summary; ///< what was reported of the stages so far, as the driver likes
};

/// The parts of a run that a restart file holds, between two steps.
template <int dim> struct RunState
{
  BackgroundMesh<dim>& mesh;       ///< forest, partition and window
  ParticleSet<dim>& particles;     ///< waiting ones too
  RigidSystems& bodies;            ///< pose, velocity and acceleration of the points; the rest is in the input
  Contact<dim>& contact;           ///< committed history
  std::vector<double>& prediction; ///< dim per node of the leaf table (m); empty: none
  RunProgress& progress;
};

/// Writes the state with a copy of the input (JSON) that it belongs to; replaces the file as a whole. Throws FileError
/// on all ranks. Collective.
template <int dim> void write_checkpoint(const RunState<dim>& state, const std::string& input, const std::string& path);

/// Fills the state: a mesh of base cells alone, a particle set without particles, bodies as the input places them. On
/// as many ranks as wrote the file, each gets back its own cells and every number is the same to the last bit; on
/// others the cells are spread by their work, `particle_cost` as for ParticleSet::balance_load. Nodes and cells may be
/// numbered otherwise than before, so that sums may differ in their last digits. The particles are loaded.
///
/// Throws FileError on all ranks where the file cannot be read in full or is of another version, and InputError where
/// it belongs to another input: only "output", "solver", "GPU" and "comment" may differ. Collective.
template <int dim>
void read_checkpoint(const RunState<dim>& state, const std::string& input, const std::string& path,
                     double particle_cost);
} // namespace kedge
