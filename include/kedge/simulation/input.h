// The whole input of a run, parsed and checked.
#pragma once

#include <array>
#include <kedge/contact/parameters.h>
#include <kedge/output/parameters.h>
#include <kedge/particles/parameters.h>
#include <kedge/solvers/parameters.h>
#include <kedge/steps/stage.h>
#include <string>
#include <vector>

namespace kedge
{
struct Input
{
  bool gpu = false;
  unsigned int dimension = 3;
  Basis basis = Basis::gimp;
  std::array<double, 3> gravity{};     ///< m/s2; in 2-D [x, z]
  std::array<double, 3> grid_extent{}; ///< upper corner of the grid, m; in 2-D [x, z]; zeros: as the soil needs it
  ExpressionText body_force;           ///< m/s2, on the soil; empty: none
  MaterialPointParameters material_points;
  std::vector<SystemParameters> systems;
  ContactParameters contact;
  std::vector<Stage> stages;
  SolverParameters solver;
  OutputParameters output;
  std::string effective_json; ///< the input after --set, as text, for the copy in the output folder
};

/// Reads and checks an input file. `overrides` are "path=value" as given to --set: dotted keys, array positions from 0
/// ("analysis.1.load steps=40"), values in JSON or a bare word.
/// Throws InputError with the JSON path and the remedy.
Input read_input(const std::string& file, const std::vector<std::string>& overrides = {});

/// The same for text that is not in a file; STL paths are relative to `folder`, messages call the text `source`.
Input parse_input(const std::string& text, const std::string& folder, const std::string& source = "input",
                  const std::vector<std::string>& overrides = {});

/// The published JSON Schema (draft 2020-12) of the input file, as indented text.
std::string input_schema();

/// The reference of all keys in Markdown: doc/parameters.md.
std::string input_manual();

/// Throws InputError naming the first key that asks for something this version cannot do yet.
void refuse_unavailable_features(const Input& input);
} // namespace kedge
