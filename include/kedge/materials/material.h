// A material on the device, and the update of a material point's stress.
#pragma once

#include <kedge/materials/laws.h>
#include <kedge/materials/parameters.h>
#include <kedge/materials/spatial_tangent.h>
#include <vector>

namespace kedge
{
/// What the kernels need of a material: plain data, copied to the device. Young's modulus is not among them, for it may
/// differ from point to point. The constants of other laws than its own stay unset.
struct Material
{
  unsigned int law = law_index<Elastic>;
  unsigned int n_state = 0;   ///< state variables in use: 0 where the law forgets, as hardening by 0 does
  double lame_ratio = unset;  ///< first Lame constant / Young's modulus
  double shear_ratio = unset; ///< shear modulus / Young's modulus
  Laws::Storage laws;

  KEDGE_FUNCTION HenckyElasticity elasticity(const double young) const
  {
    return {lame_ratio * young, shear_ratio * young};
  }
};

/// Computes the constants once, on the host.
Material make_material(const MaterialParameters& parameters);

/// The materials of the layers, on the device.
using Materials = View<Material*>;
Materials upload_materials(const std::vector<MaterialParameters>& parameters);

/// The state variables that a material uses: none where its law forgets.
std::vector<StateVariable> state_variables_of(const MaterialParameters& parameters);

/// Fills the Laws::max_state state variables of a new material point; those not in use are 0.
void initialise_state(const Material& material, const Generation& at, double* state);

/// Young's modulus (Pa) of a point under the initial vertical stress (Pa, compression positive): E, or with "E
/// overburden" E (sigma_v / reference stress)^exponent. sigma_v counts as at least 1e-4 of the reference stress (10 Pa
/// for 100 kPa, under a millimetre of soil), so that a point at the very surface keeps some stiffness.
double effective_young(const MaterialParameters& parameters, double vertical_stress);

/// Return mapping in principal logarithmic strains. `trial_strain` in any order. Writes the material's n_state state
/// variables to `next_state`, which may be the array that the point's state is in.
/// Residuals and line searches need no tangent.
template <bool with_tangent = true>
KEDGE_FUNCTION Response respond(const Eigen::Vector3d& trial_strain, const MaterialPoint& point,
                                const Material& material, double* next_state)
{
  return Laws::respond<with_tangent>(material.law, material.laws, trial_strain, point, material.elasticity(point.young),
                                     next_state);
}

/// A material point's trial state at the end of the step.
struct StressUpdate
{
  SymmetricTensor stress;         ///< Kirchhoff, Pa
  SymmetricTensor elastic_strain; ///< logarithmic
  double plastic_increment;       ///< equivalent plastic strain of the step
  Status status;
};

namespace internal
{
KEDGE_FUNCTION bool all_positive(const Eigen::Vector3d& values)
{
  return values[0] > 0. && values[1] > 0. && values[2] > 0.;
}

template <bool with_tangent>
KEDGE_FUNCTION StressUpdate update_stress(const PrincipalFrame& trial, const MaterialPoint& point,
                                          const Material& material, double* next_state, PrincipalTangent* tangent,
                                          const double elastic_share = 0.)
{
  if (!all_positive(trial.values))
  {
    if constexpr (with_tangent)
      *tangent = {};
    return {SymmetricTensor::Zero(), SymmetricTensor::Zero(), 0., Status::inverted};
  }
  const Eigen::Vector3d strain = principal_strain(trial.values);
  Response response = respond<with_tangent>(strain, point, material, next_state);
  if constexpr (with_tangent)
  {
    if (response.status != Status::elastic)
      response.residual_stiffness = std::fmax(response.residual_stiffness, elastic_share);
    *tangent = principal_tangent(response, material.elasticity(point.young), strain, trial.values);
  }
  return {from_principal(response.stress, trial.directions), from_principal(response.elastic_strain, trial.directions),
          response.plastic_increment, response.status};
}
} // namespace internal

/// Principal frame of the trial dF b dF^T, with values of zero where det dF <= 0 or is not a number. `b` is the
/// committed elastic left Cauchy-Green tensor exp(2 eps_e), computed once per step by left_cauchy_green().
KEDGE_FUNCTION PrincipalFrame trial_frame(const Eigen::Matrix3d& increment, const SymmetricTensor& b)
{
  PrincipalFrame frame = principal_frame(push_forward(increment, b));
  if (!(determinant(increment) > 0.))
    frame.values.setZero();
  return frame;
}

/// The state after a trial increment, whose elastic left Cauchy-Green tensor has the principal frame `trial`.
/// `next_state` receives the state variables, as for respond(). Where a principal value is not positive the status is
/// `inverted`, the rest zero and `next_state` as it was.
KEDGE_FUNCTION StressUpdate update_stress(const PrincipalFrame& trial, const MaterialPoint& point,
                                          const Material& material, double* next_state)
{
  return internal::update_stress<false>(trial, point, material, next_state, nullptr);
}

/// The same with the consistent tangent in that frame, to which a yielding point adds at least `elastic_share` of its
/// elastic moduli.
KEDGE_FUNCTION StressUpdate update_stress(const PrincipalFrame& trial, const MaterialPoint& point,
                                          const Material& material, double* next_state, PrincipalTangent& tangent,
                                          const double elastic_share = 0.)
{
  return internal::update_stress<true>(trial, point, material, next_state, &tangent, elastic_share);
}

/// The same after an increment of the deformation gradient, for a single point.
KEDGE_FUNCTION StressUpdate update_stress(const Eigen::Matrix3d& increment, const SymmetricTensor& b,
                                          const MaterialPoint& point, const Material& material, double* next_state)
{
  return update_stress(trial_frame(increment, b), point, material, next_state);
}

KEDGE_FUNCTION StressUpdate update_stress(const Eigen::Matrix3d& increment, const SymmetricTensor& b,
                                          const MaterialPoint& point, const Material& material, double* next_state,
                                          SpatialTangent& tangent, const double elastic_share = 0.)
{
  const PrincipalFrame frame = trial_frame(increment, b);
  PrincipalTangent principal;
  const StressUpdate update = update_stress(frame, point, material, next_state, principal, elastic_share);
  tangent = turn(principal, frame.directions);
  return update;
}
} // namespace kedge
