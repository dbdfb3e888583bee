#include "size_limits.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <kedge/base/communication.h>
#include <kedge/base/exceptions.h>
#include <kedge/simulation/layout.h>
#include <unistd.h>

namespace kedge
{
namespace
{
// Less than any stage takes: the fields of a material point and its place in the basis, a cell of the octree and its
// nodes. estimate.cc has what a stage takes in the mean.
constexpr double bytes_per_particle = 500., bytes_per_cell = 500.;

/// Deepest levels of p4est.
constexpr double deepest(const unsigned int dim) { return dim == 2 ? 29. : 18.; }

double count(const double length, const double unit) { return std::max(1., std::ceil(length / unit - 1e-9)); }

void refuse_deep_trees(const Input& input)
{
  for (std::size_t i = 0; i < input.stages.size(); ++i)
    for (const double size : finer_sizes(input.stages[i].adaptivity))
      if (const double levels = std::log2(input.material_points.element_size / size); levels > deepest(input.dimension))
        throw InputError(fmt::format("analysis[{}].adaptivity", i),
                         fmt::format("cells of {:g} m are {:.0f} levels below those of {:g} m; a tree holds {:.0f}",
                                     size, std::ceil(levels), input.material_points.element_size,
                                     deepest(input.dimension)),
                         "use larger cells there, or a smaller \"element size\" of the material points");
}
} // namespace

LeastSize least_size(const Input& input)
{
  const MaterialPointParameters& soil = input.material_points;
  const unsigned int vertical = input.dimension - 1;
  LeastSize size;
  size.cells = size.particles = 1.;
  for (unsigned int d = 0; d < input.dimension; ++d)
  {
    const double extent = d == vertical ? thickness_of(soil.layers) : soil.plan_extent[d];
    const double without_key = d == vertical ? 2. * extent : extent;
    size.particles *= count(extent, soil.element_size) * soil.points_per_axis;
    size.cells *=
        count(std::max(extent, input.grid_extent[d] > 0. ? input.grid_extent[d] : without_key), soil.element_size);
  }
  size.bytes = bytes_per_particle * size.particles + bytes_per_cell * size.cells;
  return size;
}

void refuse_excessive_size(const Input& input, const double memory, const std::string& place)
{
  refuse_deep_trees(input);
  const LeastSize size = least_size(input);
  if (!(size.bytes <= memory))
    throw InputError(
        "material points",
        fmt::format("{:.3g} cells of {:g} m in the grid and {:.3g} material points in the soil need at least "
                    "{:.3g} GB, more than the {:.3g} GB of {}",
                    size.cells, input.material_points.element_size, size.particles, 1e-9 * size.bytes, 1e-9 * memory,
                    place),
        "use a larger \"element size\", fewer \"number of material points per element 1\", less soil or a "
        "smaller \"domain.extent\"");
}

double memory_of_machine()
{
  return static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGE_SIZE));
}

double memory_of_machines(const MPI_Comm communicator)
{
  MPI_Comm machine = MPI_COMM_NULL;
  MPI_Comm_split_type(communicator, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  const bool is_first = rank_of(machine) == 0;
  MPI_Comm_free(&machine);
  return sum_over_ranks(is_first ? memory_of_machine() : 0., communicator);
}
} // namespace kedge
