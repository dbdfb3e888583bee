// Layout of the background grid: size and number of base cells, and the end of the soil.
#pragma once

#include <array>
#include <vector>

namespace kedge
{
/// Brick of base cells with its lower corner at the origin. Lengths in m.
template <int dim> struct GridLayout
{
  double base_size = 0.;                      ///< edge of a base cell
  double finest_size = 0.;                    ///< smallest size that any stage requests; base_size / 2^k
  std::array<unsigned int, dim> base_cells{}; ///< number of base cells per axis
  std::array<double, dim> soil_extent{};      ///< upper corner of the soil block; 0 beside the last: as the grid

  double extent(const unsigned int axis) const { return base_size * base_cells[axis]; }
  /// How often a tree of the forest is halved to give base cells. Every rank keeps all trees, so they are as large as
  /// the numbers of base cells allow: 2^n divides all of them.
  unsigned int base_level() const;
};

/// Largest size not above `size` that is `finest` times a power of two (both in m).
double round_down_to_level(double size, double finest);

/// Rounds the sizes of a scene to a grid. `sizes` are all requested cell sizes: the smallest one is exact, and `base`
/// is rounded down to a power of two times the smallest. The footprint (dim - 1 lengths) is rounded up to whole base
/// cells, the top of the soil up to a whole row of particles. The grid ends where the soil does and
/// is twice as high, unless `extent` gives its upper corner, which is rounded up to whole base cells; 0: as without.
template <int dim>
GridLayout<dim> make_grid_layout(double base, const std::vector<double>& sizes,
                                 const std::array<double, dim - 1>& footprint, double soil_thickness,
                                 unsigned int particles_per_axis, const std::array<double, dim>& extent = {});
} // namespace kedge
