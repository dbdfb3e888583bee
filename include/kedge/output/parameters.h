// What the input says of output.
#pragma once

#include <string>
#include <vector>

namespace kedge
{
/// One family of files ("vtk" or "csv").
struct SeriesParameters
{
  bool on = false;
  std::string directory; ///< below the run's output folder
  double percent = 0.;   ///< of a stage's steps; 0: every step
  std::vector<std::string> particle_fields, body_fields; ///< names as in the input; already filled when "every field"
};

struct OutputParameters
{
  SeriesParameters vtk, csv;
  std::string checkpoint_every;     ///< empty: none
  std::string checkpoint_directory;
};
} // namespace kedge
