// What a material point carries: each field is declared once, and storage, copies, restart files, tables and the names
// in the input follow from its line.
#pragma once

#include <array>
#include <kedge/materials/laws.h>
#include <limits>
#include <stdexcept>
#include <string_view>

namespace kedge
{
/// Shape of a field. Vectors have three entries and tensors are three-dimensional also in plane strain, whose axes are
/// stored as base/world_axes.h says. Symmetric tensors are stored as xx yy zz xy yz xz, general ones row by row.
enum class FieldKind
{
  scalar,
  vector,
  symmetric,
  general,
  law_state ///< the state variables of the layer's law, as many as any law has
};

/// What becomes of a field where particles are split or merged. Sums and means are over the members of a group.
enum class FieldRule
{
  same,              ///< children copy it; of a group the member with the smallest number gives it
  share,             ///< children share it; the group has the sum
  mean_by_mass,      ///< children copy it
  mean_by_volume,    ///< children copy it; over the initial volume
  mean_by_stiffness, ///< children copy it; over initial volume times Young's modulus
  place,             ///< children lie where their octants were; mean by mass
  width              ///< children have half of it; the group's bounding box
};

/// A line of the table. particles/arrays.h says which fields the kernels see.
struct FieldDeclaration
{
  std::string_view name; ///< in input, output and restart files
  FieldKind kind;
  FieldRule rule;
  std::string_view unit;
  double initial;  ///< not a number: may be missing
  bool is_written; ///< can be asked for by its name in the output; else it only lives and is restarted
  std::string_view sentence;
};

constexpr double missing = std::numeric_limits<double>::quiet_NaN();

inline constexpr FieldDeclaration particle_fields[] = {
    {"initial position", FieldKind::vector, FieldRule::place, "m", 0., true, "centre at the start of the run"},
    {"velocity", FieldKind::vector, FieldRule::mean_by_mass, "m/s", 0., true, "zero in static stages"},
    {"acceleration", FieldKind::vector, FieldRule::mean_by_mass, "m/s2", 0., true,
     "zero in static stages, in explicit ones the mean of the last basis step"},
    {"lp", FieldKind::vector, FieldRule::width, "m", 0., true, "half-widths of the domain"},
    {"initial lp", FieldKind::vector, FieldRule::width, "m", 0., false, "half-widths of the domain without stretch"},
    {"deformation gradient", FieldKind::general, FieldRule::mean_by_volume, "-", 0., true,
     "since the start of the run, row by row"},
    {"kirchhoff stress", FieldKind::symmetric, FieldRule::mean_by_volume, "Pa", 0., false, "tension positive"},
    {"strain", FieldKind::symmetric, FieldRule::mean_by_stiffness, "-", 0., true,
     "elastic logarithmic strain, tensor shears"},
    {"initial volume", FieldKind::scalar, FieldRule::share, "m3", 0., true, "in 2-D per metre"},
    {"plastic strain", FieldKind::scalar, FieldRule::mean_by_volume, "-", 0., true,
     "accumulated equivalent plastic strain"},
    {"young modulus", FieldKind::scalar, FieldRule::mean_by_volume, "Pa", 0., true, "Young's modulus"},
    {"contact gap", FieldKind::scalar, FieldRule::same, "m", missing, true,
     "smallest signed distance of a corner to a body, negative inside; nan or inf where no body is near"},
    {"law state", FieldKind::law_state, FieldRule::mean_by_volume, "-", 0., true,
     "state variables of the layer's law, in the order of its list"},
    {"mass", FieldKind::scalar, FieldRule::share, "kg", 0., false, "in 2-D per metre"},
    {"layer", FieldKind::scalar, FieldRule::same, "-", 0., false, "from 0, from the surface down"}};

constexpr unsigned int n_components(const FieldKind kind)
{
  switch (kind)
  {
    case FieldKind::scalar:
      return 1;
    case FieldKind::vector:
      return 3;
    case FieldKind::symmetric:
      return 6;
    case FieldKind::general:
      return 9;
    case FieldKind::law_state:
      return Laws::max_state;
  }
  return 0; // not reached
}

/// Position of a field in the table. A name that is not in it does not compile where the position is a constant.
constexpr unsigned int index_of(const std::string_view name)
{
  unsigned int index = 0;
  for (const FieldDeclaration& field : particle_fields)
  {
    if (field.name == name)
      return index;
    ++index;
  }
  throw std::logic_error("no field of material points has this name");
}

/// Offset of a field into the properties of a particle in deal.II's ParticleHandler.
constexpr unsigned int offset_of(const std::string_view name)
{
  unsigned int offset = 0;
  for (unsigned int i = 0; i < index_of(name); ++i)
    offset += n_components(particle_fields[i].kind);
  return offset;
}

/// The offsets that the code uses by name.
namespace field
{
constexpr unsigned int initial_position = offset_of("initial position"), velocity = offset_of("velocity"),
                       acceleration = offset_of("acceleration"), half_width = offset_of("lp"),
                       initial_half_width = offset_of("initial lp"),
                       deformation_gradient = offset_of("deformation gradient"), stress = offset_of("kirchhoff stress"),
                       elastic_strain = offset_of("strain"), initial_volume = offset_of("initial volume"),
                       plastic_strain = offset_of("plastic strain"), young = offset_of("young modulus"),
                       contact_gap = offset_of("contact gap"), law_state = offset_of("law state"),
                       mass = offset_of("mass"), layer = offset_of("layer");

/// Number of properties of a particle.
constexpr unsigned int count = []
{
  unsigned int n = 0;
  for (const FieldDeclaration& field : particle_fields)
    n += n_components(field.kind);
  return n;
}();
} // namespace field

/// Calls visit(declaration, offset) for every field, in the order of the table.
template <typename Visit> void for_each_field(const Visit& visit)
{
  unsigned int offset = 0;
  for (const FieldDeclaration& field : particle_fields)
  {
    visit(field, offset);
    offset += n_components(field.kind);
  }
}
} // namespace kedge
