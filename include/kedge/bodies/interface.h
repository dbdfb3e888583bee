// What the input says of the interface between the soil and the surface of a body.
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

/// Values of one surface, or of "contact" for all surfaces; a surface takes from there what it does not give itself.
struct InterfaceParameters
{
  std::optional<double> friction_coefficient;
  std::optional<double> adhesion; ///< Pa
  std::optional<TangentialLimit> tangential_limit;
  std::optional<bool> bonded; ///< whether a point that has touched stays, also in tension

  /// These values, and those of `general` where there is none.
  InterfaceParameters or_else(const InterfaceParameters& general) const;
  /// The form in use: friction alone without adhesion.
  TangentialLimit limit() const;
};

/// Keys of an interface. The friction coefficient is `required` in "contact", optional beside a surface.
schema::Section<InterfaceParameters> interface_section(bool required);
} // namespace kedge
