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

KEDGE_FUNCTION double determinant(const Eigen::Matrix3d& f)
{
  return f(0, 0) * (f(1, 1) * f(2, 2) - f(1, 2) * f(2, 1)) - f(0, 1) * (f(1, 0) * f(2, 2) - f(1, 2) * f(2, 0)) +
         f(0, 2) * (f(1, 0) * f(2, 1) - f(1, 1) * f(2, 0));
}

namespace internal
{
/// dF b dF^T.
KEDGE_FUNCTION SymmetricTensor push_forward(const Eigen::Matrix3d& f, const SymmetricTensor& b)
{
  double fb[3][3];
  for (int i = 0; i < 3; ++i)
  {
    fb[i][0] = f(i, 0) * b[0] + f(i, 1) * b[3] + f(i, 2) * b[5];
    fb[i][1] = f(i, 0) * b[3] + f(i, 1) * b[1] + f(i, 2) * b[4];
    fb[i][2] = f(i, 0) * b[5] + f(i, 1) * b[4] + f(i, 2) * b[2];
  }
  const auto entry = [&](const int i, const int j)
  { return fb[i][0] * f(j, 0) + fb[i][1] * f(j, 1) + fb[i][2] * f(j, 2); };
  SymmetricTensor pushed;
  pushed << entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(1, 2), entry(0, 2);
  return pushed;
}

/// `pushed` is the trial b, `frame` its principal frame, `trial_strain` the principal logarithmic strain.
template <bool with_tangent>
KEDGE_FUNCTION StressUpdate update_stress_in(const PrincipalFrame& frame, const Eigen::Vector3d& trial_strain,
                                             const SymmetricTensor& pushed, const MaterialPoint& point,
                                             const Material& material, double* next_state, PrincipalTangent* tangent,
                                             SymmetricTensor* next_b, const double elastic_share)
{
  Response response = respond<with_tangent>(trial_strain, point, material, next_state);
  if constexpr (with_tangent)
  {
    if (response.status != Status::elastic)
      response.residual_stiffness = std::fmax(response.residual_stiffness, elastic_share);
    *tangent = principal_tangent(response, material.elasticity(point.young), trial_strain, frame.values);
  }
  if (next_b != nullptr)
  {
    const Eigen::Vector3d& e = response.elastic_strain;
    *next_b = response.status == Status::elastic
                  ? pushed
                  : from_principal(Eigen::Vector3d(std::exp(2. * e[0]), std::exp(2. * e[1]), std::exp(2. * e[2])),
                                   frame.directions);
  }
  return {from_principal(response.stress, frame.directions), from_principal(response.elastic_strain, frame.directions),
          response.plastic_increment, response.status};
}

KEDGE_FUNCTION bool all_positive(const Eigen::Vector3d& values)
{
  return values[0] > 0. && values[1] > 0. && values[2] > 0.;
}

template <bool with_tangent>
KEDGE_FUNCTION StressUpdate update_stress(const PrincipalFrame& trial, const MaterialPoint& point,
                                          const Material& material, double* next_state, PrincipalTangent* tangent,
                                          const double elastic_share = 0.)
{
  if (all_positive(trial.values))
    return update_stress_in<with_tangent>(trial, principal_strain(trial.values), SymmetricTensor::Zero(), point,
                                          material, next_state, tangent, nullptr, elastic_share);
  if constexpr (with_tangent)
    *tangent = {};
  return {SymmetricTensor::Zero(), SymmetricTensor::Zero(), 0., Status::inverted};
}
} // namespace internal

/// Principal frame of the trial dF b dF^T, with values of zero where det dF <= 0 or is not a number. `b` is the
/// committed elastic left Cauchy-Green tensor exp(2 eps_e), computed once per step by left_cauchy_green().
KEDGE_FUNCTION PrincipalFrame trial_frame(const Eigen::Matrix3d& increment, const SymmetricTensor& b)
{
  PrincipalFrame frame = principal_frame(internal::push_forward(increment, b));
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

/// The same without a tangent for a path of many increments, where the trial b, its principal frame and its principal
/// logarithmic strain are known: `b` becomes the one that the path goes on from, and stays as it is where it is
/// inverted.
KEDGE_FUNCTION StressUpdate advance_stress(const PrincipalFrame& frame, const Eigen::Vector3d& trial_strain,
                                           SymmetricTensor& b, const MaterialPoint& point, const Material& material,
                                           double* next_state)
{
  if (!internal::all_positive(frame.values))
    return {SymmetricTensor::Zero(), SymmetricTensor::Zero(), 0., Status::inverted};
  return internal::update_stress_in<false>(frame, trial_strain, b, point, material, next_state, nullptr, &b, 0.);
}
} // namespace kedge
