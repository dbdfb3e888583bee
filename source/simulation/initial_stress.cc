#include "initial_stress.h"
#include <cmath>
#include <fmt/format.h>
#include <kedge/materials/material.h>
#include <kedge/particles/generation.h>

namespace kedge
{
namespace
{
/// Part of a stress that a law may take away unnoticed: the ratios of limit states are given with few digits.
constexpr double rounding = 0.01;

constexpr int halvings = 20;

/// A row of material points under its overburden.
struct RowAtRest
{
  const MaterialParameters& parameters;
  const Material& material;
  double vertical_stress, depth, cell_size; ///< Pa, m

  /// Part of the initial stress that the law takes away.
  double taken_away(const double K0) const
  {
    const double young = effective_young(parameters, vertical_stress), poisson = parameters.poisson;
    double state[Laws::max_state] = {};
    initialise_state(material, {depth, vertical_stress}, state);
    const Eigen::Vector3d stress = -vertical_stress * Eigen::Vector3d(K0, 1., K0);
    const Eigen::Vector3d strain = ((1. + poisson) * stress - poisson * stress.sum() * Eigen::Vector3d::Ones()) / young;
    const Response response = respond<false>(strain, {young, cell_size, state}, material, state);
    return (response.stress - stress).norm() / stress.norm();
  }

  /// The ratio nearest to a refused one of which nothing is taken; all laws bear 1 under pressure.
  double nearest_to(double refused) const
  {
    double borne = 1.;
    for (int i = 0; i < halvings; ++i)
    {
      const double middle = 0.5 * (borne + refused);
      (taken_away(middle) < 1e-9 ? borne : refused) = middle;
    }
    return borne;
  }
};
} // namespace

template <int dim>
std::vector<std::string> find_unborne_stress(const MaterialPointParameters& soil, const GridLayout<dim>& grid,
                                             const double gravity)
{
  std::vector<std::string> warnings;
  if (!soil.K0)
    return warnings;
  const double K0 = *soil.K0, height = grid.soil_extent[dim - 1];
  const std::vector<ParticleRow> rows = make_rows(grid.base_size / soil.points_per_axis, height, soil.layers, gravity);
  for (unsigned int layer = 0; layer < soil.layers.size(); ++layer)
  {
    const MaterialParameters& parameters = soil.layers[layer].material;
    const Material material = make_material(parameters);
    double first_depth = -1., borne = K0; // by all its rows
    for (auto row = rows.rbegin(); row != rows.rend(); ++row)
    {
      const RowAtRest at{parameters, material, row->vertical_stress, height - 0.5 * (row->bottom + row->top),
                         grid.base_size};
      if (row->layer != layer || !(row->vertical_stress > 0.) || at.taken_away(K0) <= rounding)
        continue;
      first_depth = first_depth < 0. ? at.depth : first_depth;
      const double nearest = at.nearest_to(K0);
      borne = std::abs(nearest - K0) > std::abs(borne - K0) ? nearest : borne;
    }
    if (first_depth >= 0.)
      warnings.push_back(fmt::format("layer {} does not bear the initial stress with \"K0\" = {:.4g} from a depth of "
                                     "{:.3g} m on: the first step takes it to the yield surface, and the soil moves; "
                                     "all of the layer bears {:.3g}",
                                     layer + 1, K0, first_depth, borne));
  }
  return warnings;
}

template std::vector<std::string> find_unborne_stress<2>(const MaterialPointParameters&, const GridLayout<2>&, double);
template std::vector<std::string> find_unborne_stress<3>(const MaterialPointParameters&, const GridLayout<3>&, double);
} // namespace kedge
