// Restart files: everything that survives a step, in one HDF5 file.
#pragma once

#include <kedge/soil/soil.h>
#include <kedge/time/clock.h>
#include <string>

namespace kedge
{
/// How far a run is.
struct RunProgress
{
  unsigned int stage = 0; ///< from 0
  ClockState clock;       ///< of this stage
  unsigned int step = 1;  ///< global counter
  unsigned int steps_in_stage = 0;
  bool has_warned_of_window = false;
  std::string summary; ///< what was reported of the stages so far, as the driver likes
};

/// Writes the state between two steps with a copy of the input (JSON) that it belongs to; replaces the file as a whole.
/// Of the soil: forest, partition, window, all particles, committed contacts, prediction, count of deleted particles.
/// Of the bodies: pose, velocity and acceleration; the rest is in the input. Throws FileError on all ranks. Collective.
template <int dim>
void write_checkpoint(const Soil<dim>& soil, const RigidSystems& bodies, const RunProgress& progress,
                      const std::string& input, const std::string& path);

/// Fills a soil of base cells alone, without particles, and bodies as the input places them. On as many ranks as wrote
/// the file, each gets back its own cells and every number is the same to the last bit; on others the cells are spread
/// by their work. Nodes and cells may be numbered otherwise than before, so that sums may differ in their last digits.
///
/// Throws FileError on all ranks where the file cannot be read in full or is of another version, and InputError where
/// it belongs to another input: only "output", "solver", "GPU" and "comment" may differ. Collective.
template <int dim>
RunProgress read_checkpoint(Soil<dim>& soil, RigidSystems& bodies, const std::string& input, const std::string& path);
} // namespace kedge
