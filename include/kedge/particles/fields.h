// The names of what a material point carries; the only place that knows their offsets.
#pragma once

namespace kedge
{
/// Offsets into the properties of a particle in deal.II's ParticleHandler. Vectors have three entries and tensors are
/// three-dimensional also in plane strain, where the axes are x, z and the direction out of the plane. Symmetric
/// tensors are stored as xx yy zz xy yz xz, general ones row by row.
namespace field
{
enum Offset : unsigned int
{
  initial_position = 0,     ///< 3, m
  half_width = 3,           ///< 3, m
  initial_half_width = 6,   ///< 3, m
  deformation_gradient = 9, ///< 9
  elastic_strain = 18,      ///< 6, logarithmic
  stress = 24,              ///< 6, Kirchhoff, Pa
  velocity = 30,            ///< 3, m/s
  acceleration = 33,        ///< 3, m/s2
  initial_volume = 36,      ///< m3 (2-D: per metre)
  mass = 37,                ///< kg
  young = 38,               ///< Pa
  plastic_strain = 39,      ///< accumulated equivalent
  layer = 40,               ///< from 0, from the surface down
  contact_gap = 41,         ///< smallest signed gap of its corners to a body, m; NaN: not near one
  count = 42
};
} // namespace field
} // namespace kedge
