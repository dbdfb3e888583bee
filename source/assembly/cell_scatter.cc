#include <kedge/assembly/cell_scatter.h>
#include <kedge/assembly/kernels.h>

namespace kedge
{
namespace
{
/// By cell: whether it has several particles, or one.
struct HasParticles
{
  CellGroups cells;
  bool several;

  KEDGE_FUNCTION bool operator()(const unsigned int c) const
  {
    return (cells.particle_begin(c + 1) - cells.particle_begin(c) > 1) == several;
  }
};

struct ListCells
{
  HasParticles takes;
  View<unsigned int*> list; ///< empty: they are only counted

  KEDGE_FUNCTION void operator()(const unsigned int c, unsigned int& count, const bool is_final) const
  {
    if (!takes(c))
      return;
    if (is_final && list.extent(0) > 0)
      list(count) = c;
    ++count;
  }
};

View<unsigned int*> list_cells(const HasParticles& takes)
{
  const Kokkos::RangePolicy<ExecutionSpace> policy(0, takes.cells.n_cells());
  unsigned int count = 0;
  Kokkos::parallel_scan("count cells", policy, ListCells{takes, {}}, count);
  const View<unsigned int*> list("cells", count);
  if (count > 0)
    Kokkos::parallel_scan("list cells", policy, ListCells{takes, list}, count);
  return list;
}

struct SumPlaces
{
  CellGroups cells;
  View<unsigned int*> sharing;
  View<std::size_t*> begin;

  KEDGE_FUNCTION void operator()(const unsigned int i, std::size_t& sum, const bool is_final) const
  {
    const unsigned int c = sharing(i);
    sum += std::size_t(cells.node_begin(c + 1) - cells.node_begin(c)) *
           (cells.particle_begin(c + 1) - cells.particle_begin(c));
    if (is_final)
      begin(i + 1) = sum;
  }
};

struct FindPlaces
{
  StencilSet stencils;
  CellGroups cells;
  View<unsigned int*> sharing;
  View<std::size_t*> begin;
  View<unsigned char*> place;

  KEDGE_FUNCTION void operator()(const unsigned int i) const
  {
    const unsigned int c = sharing(i), first = cells.particle_begin(c), n = cells.particle_begin(c + 1) - first;
    const unsigned int n_nodes = cells.node_begin(c + 1) - cells.node_begin(c);
    for (unsigned int p = 0; p < n; ++p)
    {
      const ParticleNodes at = nodes_of(stencils, first + p);
      for (unsigned int v = 0, known = 0; v < n_nodes; ++v) // both lists ascend
      {
        const bool sees = known < at.n && at.node[known] == cells.nodes(cells.node_begin(c) + v);
        place(begin(i) + std::size_t(v) * n + p) = sees ? known : CellScatter::nothing;
        known += sees;
      }
    }
  }
};
} // namespace

CellScatter make_cell_scatter(const StencilSet& stencils, const CellGroups& cells)
{
  CellScatter scatter;
  scatter.sharing = list_cells({cells, true});
  scatter.alone = list_cells({cells, false});
  const std::size_t n = scatter.sharing.extent(0);
  scatter.begin = View<std::size_t*>("places begin", n + 1);
  std::size_t n_places = 0;
  Kokkos::parallel_scan("sum places", Kokkos::RangePolicy<ExecutionSpace>(0, n),
                        SumPlaces{cells, scatter.sharing, scatter.begin}, n_places);
  scatter.place =
      View<unsigned char*>(Kokkos::view_alloc(std::string("places"), Kokkos::WithoutInitializing), n_places);
  scatter.change = View<double* [2]>("changes", stencils.n_particles);
  Kokkos::parallel_for("find places", Kokkos::RangePolicy<ExecutionSpace>(0, n),
                       FindPlaces{stencils, cells, scatter.sharing, scatter.begin, scatter.place});
  return scatter;
}
} // namespace kedge
