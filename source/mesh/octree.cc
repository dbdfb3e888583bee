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

/// The leaves of all ranks that lie in this rank's cells. Collective.
template <int dim>
std::vector<LeafPlace<dim>> send_to_owners(const std::vector<LeafPlace<dim>>& leaves, const BackgroundMesh<dim>& mesh)
{
  const MPI_Comm communicator = mesh.communicator();
  std::vector<std::vector<LeafPlace<dim>>> to_owner(size_of(communicator));
  for (const LeafPlace<dim>& place : leaves)
  {
    const double size = std::ldexp(mesh.layout().base_size, -static_cast<int>(place.level));
    std::array<double, dim> centre;
    for (unsigned int d = 0; d < dim; ++d)
      centre[d] = (static_cast<double>(place.index[d]) + 0.5) * size;
    if (const int owner = mesh.leaves().find_owner(centre); owner >= 0)
      to_owner[owner].push_back(place);
  }
  std::vector<LeafPlace<dim>> mine;
  for (const auto& part : exchange_between_ranks(to_owner, communicator))
    mine.insert(mine.end(), part.begin(), part.end());
  return mine;
}

/// All ancestors of the leaves.
template <int dim> std::set<Key<dim>> find_divided(const std::vector<LeafPlace<dim>>& leaves)
{
  std::set<Key<dim>> divided;
  for (LeafPlace<dim> place : leaves)
    while (place.level > 0)
    {
      --place.level;
      for (std::int64_t& i : place.index)
        i /= 2;
      if (!divided.insert(key_of(place)).second)
        break; // its ancestors are known, too
    }
  return divided;
}
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
  auto& forest = mesh.triangulation();
  for (bool any = true; any;)
  {
    const std::set<Key<dim>> divided = find_divided(send_to_owners(leaves, mesh));
    bool mine = false;
    for (const auto& cell : forest.active_cell_iterators())
      if (cell->is_locally_owned() && divided.count(key_of(place_of<dim>(cell, mesh))) > 0)
      {
        cell->set_refine_flag();
        mine = true;
      }
    any = max_over_ranks(mine, mesh.communicator()) > 0.;
    if (!any)
      return;
    forest.execute_coarsening_and_refinement();
    forest.repartition();
    mesh.update();
  }
}

template <int dim> void repartition_to(BackgroundMesh<dim>& mesh, const std::vector<std::int64_t>& counts)
{
  // p4est cuts the sum of the weights into equal parts. The weights of each rank's cells get the same sum here: the
  // first cell makes up for missing ones.
  const std::int64_t largest = *std::max_element(counts.begin(), counts.end());
  const auto cells = cells_in_forest_order(mesh);
  const std::int64_t first = sum_over_lower_ranks(cells.size(), mesh.communicator());
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
