// What the input says of contact between soil and bodies.
#pragma once

#include <kedge/bodies/interface.h>

namespace kedge
{
enum class ContactMethod
{
  penalty,
  augmented_lagrangian
};

/// Of runs whose bodies touch soil in an explicit stage and that do not say otherwise.
constexpr double explicit_normal_penalty_factor = 0.25;

struct ContactParameters
{
  InterfaceParameters interface; ///< of surfaces that do not say otherwise
  ContactMethod method = ContactMethod::penalty;
  double normal_penalty_factor = 5.;
  double tangential_penalty_factor = 2.5;
  double penetration_tolerance = 1e-3; ///< augmented Lagrangian: share of a material point's size
};

/// Keys of "contact".
schema::Section<ContactParameters> contact_section();
} // namespace kedge
