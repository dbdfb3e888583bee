// What the input says of the soil and of its material points.
#pragma once

#include <array>
#include <kedge/materials/parameters.h>
#include <kedge/parameters/expression.h>
#include <optional>
#include <vector>

namespace kedge::schema
{
template <typename T> class Section;
}

namespace kedge
{
/// How a material point's domain follows the deformation: constant, or l_i = l0_i U_ii, or step by step with the flow.
enum class DomainUpdate
{
  automatic, ///< flow with F-bar, none without
  none,
  stretch,
  flow
};

/// One soil layer, as wide as the block.
struct Layer
{
  double thickness; ///< m
  MaterialParameters material;
};

struct MaterialPointParameters
{
  double extra_capacity = 1.;                ///< of no effect
  double element_size = 0.;                  ///< base cell size, m
  unsigned int points_per_axis = 2;          ///< "number of material points per element 1"
  std::array<double, 2> plan_extent{{0, 0}}; ///< block from 0 to here in x and y (2-D: x only), m
  std::vector<Layer> layers;                 ///< from the surface down
  DomainUpdate domain_update = DomainUpdate::automatic;
  bool f_bar = false;              ///< "F-bar": volume changes averaged over cells
  std::optional<double> K0;        ///< "initial stress": horizontal over vertical stress
  ExpressionText initial_velocity; ///< m/s; empty: at rest
};

/// Keys of "material points", which hold "initial stress" too; "domain update" stands at the top level.
schema::Section<MaterialPointParameters> material_points_section();
} // namespace kedge
