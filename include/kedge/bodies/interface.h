// What the input says about the interface between the soil and the surface of a body.
#pragma once

#include <optional>

namespace kedge::schema
{
template <typename T> class Section;
}

namespace kedge
{
/// How much shear an interface carries at a pressure p, with friction coefficient mu and adhesion a.
enum class TangentialLimit
{
  friction, ///< mu p
  smaller,  ///< the smaller of mu p and a
  sum       ///< a + mu p
};

/// Values of one surface, or those of "contact", which hold for every surface that gives no value of its own.
struct InterfaceParameters
{
  std::optional<double> friction_coefficient;
  std::optional<double> adhesion; ///< Pa
  std::optional<TangentialLimit> tangential_limit;
  std::optional<bool> bonded; ///< whether a point that has touched the surface stays on it, also in tension

  /// These values; a missing one is taken from `general`.
  InterfaceParameters or_else(const InterfaceParameters& general) const;
  /// The limit in use. Without adhesion it is friction alone.
  TangentialLimit limit() const;
};

/// Keys of an interface. The friction coefficient is `required` in "contact", optional beside a surface.
schema::Section<InterfaceParameters> interface_section(bool required);
} // namespace kedge
