// Contents of a restart file, for its writer and its reader.
#pragma once

#include <fmt/format.h>
#include <kedge/output/checkpoint.h>

namespace kedge::checkpoint
{
/// Grows with every change of the contents.
constexpr int format_version = 10;

/// Widths of the tables' rows.
template <int dim> constexpr unsigned int particle_width = dim + field::count; // position, fields
template <int dim> constexpr unsigned int leaf_width = dim + 2;                // level, index, number of particles
template <int dim> constexpr unsigned int node_width = 2 * dim;                // position, increment
constexpr unsigned int body_width =
    3 + 4 + 6 + 6 + 6; // position, rotation (x y z w), increment, velocity, acceleration
constexpr unsigned int contact_key_width = 3, contact_width = 14;
constexpr unsigned int surface_width = 3; // vertices, triangles, CRC-32

/// The fields of a particle, as the text "particle fields" lists them. A file with other fields cannot be read.
inline std::string field_names()
{
  std::string names;
  for_each_field(
      [&](const FieldDeclaration& field, unsigned int)
      { names += fmt::format("{}{} ({})", names.empty() ? "" : ", ", field.name, n_components(field.kind)); });
  return names;
}

/// What tells surfaces apart that have the same name in the input: a row for each, in the body's frame.
std::vector<std::int64_t> describe_surfaces(const RigidSystems& bodies);

/// Value of the text "version".
inline std::string version_text(const unsigned int dim)
{
  return fmt::format("Kedge restart file {}, {}-D", format_version, dim);
}
} // namespace kedge::checkpoint
