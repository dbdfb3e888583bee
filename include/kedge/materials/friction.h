// Keys, checks and functions of angles that the frictional laws share.
#pragma once

#include <cmath>
#include <kedge/materials/law.h>

namespace kedge
{
namespace law_keys
{
inline constexpr LawKey friction_angle = required_key("friction angle", "degrees", ranges::angle, "Friction angle");
inline constexpr LawKey dilation_angle =
    required_key("dilation angle", "degrees", ranges::angle, "Dilation angle, at most the friction angle");
inline constexpr LawKey cohesion = required_key("cohesion", "Pa", ranges::not_negative, "Cohesion");
} // namespace law_keys

inline double sine_of_degrees(const double angle) { return std::sin(angle * 3.14159265358979324 / 180.); }
inline double cosine_of_degrees(const double angle) { return std::cos(angle * 3.14159265358979324 / 180.); }
inline double tangent_of_degrees(const double angle) { return std::tan(angle * 3.14159265358979324 / 180.); }

/// The dilation angle must not exceed the friction angle.
inline void check_dilation(const LawConstants& constants, const Refuse& refuse)
{
  const double friction = constants[law_keys::friction_angle], dilation = constants[law_keys::dilation_angle];
  if (dilation > friction)
    refuse(law_keys::dilation_angle,
           "expected at most the friction angle, " + shown_number(friction) + " degrees, found " +
               shown_number(dilation),
           "lower it: a soil that dilates by more than it rubs would create energy");
}

/// The friction angle and the cohesion must not both be 0.
inline void check_strength(const LawConstants& constants, const Refuse& refuse)
{
  if (constants[law_keys::friction_angle] == 0. && constants[law_keys::cohesion] == 0.)
    refuse(law_keys::cohesion, "the friction angle and the cohesion are both 0, so the soil has no strength",
           "give at least one of them above 0");
}
} // namespace kedge
