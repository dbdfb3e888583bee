// What the input says about output.
#pragma once

#include <string>
#include <vector>

namespace kedge::schema
{
template <typename T> class Section;
}

namespace kedge
{
/// One family of files ("vtk" or "csv").
struct SeriesParameters
{
  bool on = false;
  std::string directory;                                 ///< below the run's output folder
  double percent = 0.;                                   ///< share of a stage's steps between two files; 0: every step
  std::vector<std::string> particle_fields, body_fields; ///< names as in the input; by default all
};

struct OutputParameters
{
  SeriesParameters vtk, csv;
  std::string checkpoint_every; ///< empty: none; "50": steps; "10 min", "30 s" or "2 h": wall time
  std::string checkpoint_directory = "checkpoints";
};

/// Names of the fields that can be written of material points and of rigid points.
const std::vector<std::string>& particle_field_names();
const std::vector<std::string>& body_field_names();

/// Keys of "output".
schema::Section<OutputParameters> output_section();
} // namespace kedge
