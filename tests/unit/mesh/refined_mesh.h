// Grids for the tests, refined at random but the same on any number of ranks.
#pragma once

#include <cmath>
#include <cstdint>
#include <kedge/base/communication.h>
#include <kedge/mesh/background_mesh.h>
#include <random>
#include <string>
#include <type_traits>

namespace kedge::test
{
/// Names of typed tests: "2d", "3d".
struct DimensionName
{
  template <typename Dimension> static std::string GetName(int) { return std::to_string(Dimension::value) + "d"; }
};

/// A number in [0, 1) that depends only on the arguments, so all ranks get the same.
inline double noise(std::uint64_t seed, const std::uint64_t salt)
{
  seed += 0x9e3779b97f4a7c15u * (salt + 1);
  seed = (seed ^ (seed >> 30)) * 0xbf58476d1ce4e5b9u;
  seed = (seed ^ (seed >> 27)) * 0x94d049bb133111ebu;
  return std::ldexp(static_cast<double>((seed ^ (seed >> 31)) >> 11), -53);
}

/// The same for a point; its coordinates are rounded to a millionth.
template <typename Point> double noise_at(const Point& x, const unsigned int dim, const std::uint64_t salt)
{
  std::uint64_t seed = 0;
  for (unsigned int d = 0; d < dim; ++d)
    seed = 1000003u * seed + static_cast<std::uint64_t>(std::llround(1e6 * x[d]));
  return noise(seed, salt);
}

/// Brick of `cells` base cells; the soil fills it up to the given share of its height.
template <int dim>
GridLayout<dim> make_brick(const std::array<unsigned int, dim>& cells, const double size, const double filled = 1.)
{
  GridLayout<dim> layout;
  layout.base_size = layout.finest_size = size;
  layout.base_cells = cells;
  for (unsigned int d = 0; d < dim; ++d)
    layout.soil_extent[d] = layout.extent(d) * (d == dim - 1 ? filled : 1.);
  return layout;
}

/// Marks about a third of the cells for refinement and refines them, 2:1. The leaf table is not updated.
template <int dim> void refine_some_cells(BackgroundMesh<dim>& mesh, const std::uint64_t salt)
{
  auto& forest = mesh.triangulation();
  for (const auto& cell : forest.active_cell_iterators())
    if (cell->is_locally_owned() && noise_at(cell->center(), dim, salt) < 0.3)
      cell->set_refine_flag();
  forest.prepare_coarsening_and_refinement();
  forest.execute_coarsening_and_refinement();
}

/// A brick of 3 trees in the first direction and 2 in the others, each 0.3 m large, of 2^base_level base cells along
/// each axis that are refined twice at random.
template <int dim> struct RefinedMesh
{
  explicit RefinedMesh(const MPI_Comm communicator = MPI_COMM_WORLD, const unsigned int base_level = 0)
      : mesh(communicator, layout(base_level))
  {
    for (unsigned int round = 0; round < 2; ++round)
      refine_some_cells(mesh, round);
    mesh.repartition();
    mesh.update();
  }

  static GridLayout<dim> layout(const unsigned int base_level = 0)
  {
    std::array<unsigned int, dim> cells;
    cells.fill(2u << base_level);
    cells[0] = 3u << base_level;
    return make_brick<dim>(cells, std::ldexp(0.3, -static_cast<int>(base_level)));
  }

  BackgroundMesh<dim> mesh;
};

/// Uniform random numbers that differ from rank to rank.
class RankRandom
{
public:
  explicit RankRandom(const unsigned int seed) : generator(1000 * seed + rank_of(MPI_COMM_WORLD)) {}
  double operator()(const double low, const double high)
  {
    return std::uniform_real_distribution<double>(low, high)(generator);
  }

private:
  std::mt19937 generator;
};
} // namespace kedge::test
