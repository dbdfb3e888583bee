// Restart files: everything that survives a step, in one HDF5 file.
#pragma once

#include <kedge/soil/soil.h>
#include <kedge/solvers/newton_history.h>
#include <kedge/time/clock.h>
#include <string>

namespace kedge
{
/// Progress of a run.
struct RunProgress
{
  unsigned int stage = 0; ///< from 0
  ClockState clock;       ///< of this stage
  unsigned int step = 1;  ///< global counter
  unsigned int steps_in_stage = 0;
  NewtonHistory newton; ///< of the steps so far
  bool has_warned_of_window = false;
  std::string summary;      ///< report about the stages so far, in a form that the driver chooses
  std::string program = {}; ///< that wrote the file: its version and commit
};

/// Writes the state between two steps and a copy of its input (JSON); replaces the file as a whole. The file that it
/// replaces is called `kept` then, unless that is empty. The soil's state:
/// forest, partition, window, all particles, committed contacts, prediction, count of deleted particles. The bodies'
/// state: pose, velocity and acceleration; the rest is in the input. Throws FileError on all ranks. Collective.
template <int dim>
void write_checkpoint(const Soil<dim>& soil, const RigidSystems& bodies, const RunProgress& progress,
                      const std::string& input, const std::string& path, const std::string& kept = "");

/// The step after which a file was written. Throws FileError if the file is damaged. Of this process alone.
unsigned int step_of_checkpoint(const std::string& path);

/// Reads a state. `soil` must have base cells only and no particles, and the bodies must stand where the input places
/// them. If as many ranks read as wrote, each gets its own cells back and every number is the same to the last bit;
/// otherwise the cells are distributed by their work. Nodes and cells may get other numbers than before, so later sums
/// may differ in their last digits.
///
/// Throws FileError on all ranks if the file is damaged or has another version, and InputError if it belongs to another
/// input or to other surfaces. Only "output", "solver", "GPU", "comment" and "$schema" may differ and the names of STL
/// files, and the last stage may end later if its steps stay the same. Collective.
template <int dim>
RunProgress read_checkpoint(Soil<dim>& soil, RigidSystems& bodies, const std::string& input, const std::string& path);
} // namespace kedge
