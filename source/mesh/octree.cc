#include <algorithm>
#include <cmath>
#include <kedge/base/communication.h>
#include <kedge/mesh/octree.h>
#include <set>

namespace kedge
{
namespace
{
template <int dim> using Key = std::pair<unsigned int, std::array<std::int64_t, dim>>;

template <int dim> Key<dim> key_of(const LeafPlace<dim>& place) { return {place.level, place.index}; }
} // namespace

template <int dim>
std::vector<typename BackgroundMesh<dim>::Cell> cells_in_forest_order(const BackgroundMesh<dim>& mesh)
{
  using Cell = typename BackgroundMesh<dim>::Cell;
  const auto& forest = mesh.triangulation();
  std::vector<std::pair<ForestPlace, Cell>> order;
  for (const auto& cell : forest.active_cell_iterators())
    if (cell->is_locally_owned())
      order.emplace_back(place_in_forest(cell->id()), cell);
  std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Cell> cells;
  for (const auto& entry : order)
    cells.push_back(entry.second);
  return cells;
}

template <int dim>
LeafPlace<dim> place_of(const typename BackgroundMesh<dim>::Cell& cell, const BackgroundMesh<dim>& mesh)
{
  LeafPlace<dim> place;
  place.level = cell->level() - mesh.layout().base_level();
  const double size = std::ldexp(mesh.layout().base_size, -static_cast<int>(place.level));
  for (unsigned int d = 0; d < dim; ++d)
    place.index[d] = std::llround(cell->vertex(0)[d] / size);
  return place;
}

template <int dim> void refine_to(BackgroundMesh<dim>& mesh, const std::vector<LeafPlace<dim>>& leaves)
{
  std::set<Key<dim>> divided; // all ancestors of the leaves
  for (LeafPlace<dim> place : leaves)
    while (place.level > 0)
    {
      --place.level;
      for (std::int64_t& i : place.index)
        i /= 2;
      if (!divided.insert(key_of(place)).second)
        break; // its ancestors are known, too
    }

  auto& forest = mesh.triangulation();
  for (bool any = true; any;)
  {
    bool mine = false;
    for (const auto& cell : forest.active_cell_iterators())
      if (cell->is_locally_owned() && divided.count(key_of(place_of<dim>(cell, mesh))) > 0)
      {
        cell->set_refine_flag();
        mine = true;
      }
    any = max_over_ranks(mine, forest.get_communicator()) > 0.;
    if (any)
      forest.execute_coarsening_and_refinement();
  }
}

template <int dim> void repartition_to(BackgroundMesh<dim>& mesh, const std::vector<std::int64_t>& counts)
{
  // p4est cuts the sum of the weights into equal parts. The weights of each rank's cells get the same sum here: the
  // first cell makes up for missing ones.
  const std::int64_t largest = *std::max_element(counts.begin(), counts.end());
  const auto cells = cells_in_forest_order(mesh);
  const std::int64_t first = sum_over_lower_ranks(cells.size(), mesh.triangulation().get_communicator());
  std::vector<double> work(mesh.triangulation().n_active_cells(), 1.);
  std::int64_t begin = 0;
  for (const std::int64_t count : counts)
  {
    const std::int64_t here = begin - first;
    if (count > 0 && here >= 0 && here < static_cast<std::int64_t>(cells.size()))
      work[cells[here]->active_cell_index()] = largest - count + 1;
    begin += count;
  }
  mesh.repartition(work);
}

#define KEDGE_INSTANTIATE(dim)                                                                                         \
  template std::vector<BackgroundMesh<dim>::Cell> cells_in_forest_order<dim>(const BackgroundMesh<dim>&);              \
  template LeafPlace<dim> place_of<dim>(const BackgroundMesh<dim>::Cell&, const BackgroundMesh<dim>&);                 \
  template void refine_to<dim>(BackgroundMesh<dim>&, const std::vector<LeafPlace<dim>>&);                              \
  template void repartition_to<dim>(BackgroundMesh<dim>&, const std::vector<std::int64_t>&);
KEDGE_INSTANTIATE(2)
KEDGE_INSTANTIATE(3)
} // namespace kedge
