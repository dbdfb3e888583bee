// Hencky's elasticity without a yield surface.
#pragma once

#include <kedge/materials/law.h>
#include <kedge/materials/response.h>

namespace kedge
{
struct Elastic
{
  static constexpr const char* name = "elastic";
  static constexpr std::array<const LawKey*, 0> keys = {};
  static constexpr std::array<StateVariable, 0> state_variables = {};

  static Elastic make(const LawConstants&) { return {}; }
  static void check(const LawConstants&, const Refuse&) {}

  template <bool with_tangent>
  KEDGE_FUNCTION Response respond(const Eigen::Vector3d& trial_strain, const MaterialPoint&,
                                  const HenckyElasticity& elasticity, double*) const
  {
    return elastic_response<with_tangent>(trial_strain, elasticity);
  }
};
} // namespace kedge
