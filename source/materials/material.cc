#include <algorithm>
#include <cmath>
#include <kedge/materials/material.h>

namespace kedge
{
namespace
{
double sine_of_degrees(const double angle) { return std::sin(angle * 3.14159265358979324 / 180.); }
double cosine_of_degrees(const double angle) { return std::cos(angle * 3.14159265358979324 / 180.); }
double tangent_of_degrees(const double angle) { return std::tan(angle * 3.14159265358979324 / 180.); }

DruckerPrager make_drucker_prager(const MaterialParameters& p)
{
  const double sine = sine_of_degrees(p.friction_angle), dilatant_sine = sine_of_degrees(p.dilation_angle);
  return {2. * std::sqrt(2.) * sine / (3. - sine),
          2. * std::sqrt(6.) * cosine_of_degrees(p.friction_angle) / (3. - sine),
          2. * std::sqrt(2.) * dilatant_sine / (3. - dilatant_sine), p.cohesion};
}

WillamWarnke make_willam_warnke(const MaterialParameters& p)
{
  const double sine = sine_of_degrees(p.friction_angle);
  return {tangent_of_degrees(p.friction_angle), (3. - sine) / (3. + sine), tangent_of_degrees(p.dilation_angle),
          p.cohesion};
}

MohrCoulomb make_mohr_coulomb(const MaterialParameters& p)
{
  return {sine_of_degrees(p.friction_angle), cosine_of_degrees(p.friction_angle), sine_of_degrees(p.dilation_angle),
          p.cohesion};
}
} // namespace

Material make_material(const MaterialParameters& parameters)
{
  const double nu = parameters.poisson;
  Material material;
  material.type = parameters.type;
  material.lame_ratio = nu / ((1. + nu) * (1. - 2. * nu));
  material.shear_ratio = 0.5 / (1. + nu);
  switch (parameters.type)
  {
    case MaterialType::elastic:
      break;
    case MaterialType::von_mises:
      material.von_mises = {parameters.yield_stress};
      break;
    case MaterialType::drucker_prager:
      material.drucker_prager = make_drucker_prager(parameters);
      break;
    case MaterialType::willam_warnke:
      material.willam_warnke = make_willam_warnke(parameters);
      break;
    case MaterialType::mohr_coulomb:
      material.mohr_coulomb = make_mohr_coulomb(parameters);
      break;
  }
  return material;
}

Materials upload_materials(const std::vector<MaterialParameters>& parameters)
{
  const Materials materials("materials", parameters.size());
  const auto host = Kokkos::create_mirror_view(materials);
  for (std::size_t i = 0; i < parameters.size(); ++i)
    host(i) = make_material(parameters[i]);
  Kokkos::deep_copy(materials, host);
  return materials;
}

double effective_young(const MaterialParameters& parameters, const double vertical_stress)
{
  if (!parameters.overburden)
    return parameters.young;
  const double ratio = std::max(vertical_stress / parameters.overburden->reference_stress, 1e-4);
  return parameters.young * std::pow(ratio, parameters.overburden->exponent);
}
} // namespace kedge
