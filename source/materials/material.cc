#include <algorithm>
#include <cmath>
#include <kedge/materials/material.h>

namespace kedge
{
static_assert(std::is_trivially_copyable_v<Material>, "materials are copied to the device byte by byte");

Material make_material(const MaterialParameters& parameters)
{
  const double nu = parameters.poisson;
  Material material;
  material.law = parameters.law;
  material.lame_ratio = nu / ((1. + nu) * (1. - 2. * nu));
  material.shear_ratio = 0.5 / (1. + nu);
  Laws::visit(parameters.law,
              [&](const auto tag)
              {
                using Law = typename decltype(tag)::type;
                Law& law = material.laws.template get<Law>();
                law = Law::make(parameters.constants);
                if constexpr (Law::state_variables.size() > 0)
                  material.n_state = law.remembers() ? Law::state_variables.size() : 0;
              });
  return material;
}

Materials upload_materials(const std::vector<MaterialParameters>& parameters)
{
  std::vector<Material> materials;
  for (const MaterialParameters& entry : parameters)
    materials.push_back(make_material(entry));
  return upload(materials, "materials");
}

std::vector<StateVariable> state_variables_of(const MaterialParameters& parameters)
{
  std::vector<StateVariable> variables;
  if (make_material(parameters).n_state > 0)
    Laws::visit(parameters.law,
                [&](const auto tag)
                {
                  using Law = typename decltype(tag)::type;
                  variables.assign(Law::state_variables.begin(), Law::state_variables.end());
                });
  return variables;
}

void initialise_state(const Material& material, const Generation& at, double* state)
{
  std::fill_n(state, Laws::max_state, 0.);
  if (material.n_state == 0)
    return;
  Laws::visit(material.law,
              [&](const auto tag)
              {
                using Law = typename decltype(tag)::type;
                if constexpr (Law::state_variables.size() > 0)
                  material.laws.template get<Law>().initialise(at, state);
              });
}

double effective_young(const MaterialParameters& parameters, const double vertical_stress)
{
  if (!parameters.overburden)
    return parameters.young;
  const double ratio = std::max(vertical_stress / parameters.overburden->reference_stress, 1e-4);
  return parameters.young * std::pow(ratio, parameters.overburden->exponent);
}
} // namespace kedge
