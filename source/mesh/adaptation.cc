#include <algorithm>
#include <cmath>
#include <deal.II/grid/grid_tools.h>
#include <kedge/base/communication.h>
#include <kedge/mesh/adaptation.h>

namespace kedge
{
namespace
{
constexpr double slack = 1.01;  // sizes with a smaller ratio belong to one level
constexpr double across = 1e-3; // distance from a leaf, as a share of its size, at which to look for neighbours

template <int dim> using Leaf = typename LeafTable<dim>::Leaf;

template <int dim> typename BackgroundMesh<dim>::Cell cell_of(BackgroundMesh<dim>& mesh, const Leaf<dim>& leaf)
{
  return {&mesh.triangulation(), leaf.tree_level, leaf.tree_index};
}

bool any_rank(const bool mine, const MPI_Comm communicator) { return max_over_ranks(mine, communicator) > 0.; }

/// Gives ghost leaves the value of their owner.
template <int dim> void update_ghosts(const BackgroundMesh<dim>& mesh, std::vector<double>& of_leaf)
{
  if (size_of(mesh.communicator()) > 1)
    dealii::GridTools::exchange_cell_data_to_ghosts<double, dealii::Triangulation<dim>>(
        mesh.triangulation(), [&](const auto& cell) { return of_leaf[mesh.leaf_number(cell)]; },
        [&](const auto& cell, const double value) { of_leaf[mesh.leaf_number(cell)] = value; });
}

/// Lower corner of the leaf's parent.
template <int dim> std::array<double, dim> parent_corner(const Leaf<dim>& leaf)
{
  std::array<double, dim> corner;
  for (unsigned int d = 0; d < dim; ++d)
    corner[d] = 2. * leaf.size * std::floor(0.5 * leaf.lower[d] / leaf.size + 0.25);
  return corner;
}

/// Whether the leaf is the first child of its parent and the next leaves are the other children, as their order
/// implies.
template <int dim> bool begins_family(const std::vector<Leaf<dim>>& leaves, const std::size_t first)
{
  constexpr unsigned int n = LeafTable<dim>::n_vertices;
  if (first + n > leaves.size())
    return false;
  const std::array<double, dim> corner = parent_corner<dim>(leaves[first]);
  for (unsigned int child = 0; child < n; ++child)
  {
    const Leaf<dim>& leaf = leaves[first + child];
    if (leaf.tree_level != leaves[first].tree_level)
      return false;
    for (unsigned int d = 0; d < dim; ++d)
      if (std::abs(leaf.lower[d] - corner[d] - ((child >> d) & 1u ? leaf.size : 0.)) > across * leaf.size)
        return false;
  }
  return true;
}

/// Whether a finer leaf touches the family that begins with this leaf, even if only at a corner.
template <int dim> bool touches_finer_leaf(const LeafTable<dim>& table, const Leaf<dim>& first)
{
  std::vector<unsigned int> touching;
  find_touching<dim>(table, first.lower, 2. * first.size, touching);
  return std::any_of(touching.begin(), touching.end(),
                     [&](const unsigned int leaf) { return table.leaves[leaf].tree_level > first.tree_level; });
}
} // namespace

template <int dim>
void find_touching(const LeafTable<dim>& table, const std::array<double, dim>& corner, const double edge,
                   std::vector<unsigned int>& found)
{
  std::array<double, dim> lower, upper;
  for (unsigned int d = 0; d < dim; ++d)
  {
    lower[d] = corner[d] - across * edge;
    upper[d] = corner[d] + (1. + across) * edge;
  }
  table.find_leaves(lower, upper, found);
}

template <int dim>
bool flag_refinement(BackgroundMesh<dim>& mesh, const WantedSize<dim>& wanted, const double finest,
                     const FindSoil& find_soil)
{
  const MPI_Comm communicator = mesh.communicator();
  const auto& leaves = mesh.leaves().leaves;
  std::vector<unsigned char> too_large(leaves.size(), false); // of ghosts too: soil reaches across
  bool any = false;
  for (std::size_t i = 0; i < leaves.size(); ++i)
  {
    too_large[i] = leaves[i].size > slack * finest && leaves[i].size > slack * wanted(leaves[i].lower, leaves[i].size);
    any = any || too_large[i];
  }
  if (!any_rank(any, communicator))
    return false;
  const std::vector<unsigned char> holds_soil = find_soil(too_large);
  bool flagged = false;
  for (std::size_t i = 0; i < leaves.size(); ++i)
    if (leaves[i].owned && too_large[i] && holds_soil[i])
    {
      cell_of<dim>(mesh, leaves[i])->set_refine_flag();
      flagged = true;
    }
  return any_rank(flagged, communicator);
}

template <int dim>
Coarsening flag_coarsening(BackgroundMesh<dim>& mesh, const WantedSize<dim>& wanted, const std::vector<double>& largest)
{
  constexpr unsigned int n = LeafTable<dim>::n_vertices;
  const MPI_Comm communicator = mesh.communicator();
  const auto& leaves = mesh.leaves().leaves;
  const int base_level = mesh.layout().base_level();
  const auto allows = [&](const std::vector<double>& limit, const std::size_t i)
  { return leaves[i].tree_level > base_level && 2. * leaves[i].size <= slack * limit[i]; };

  // Most calls end here, before the ranks exchange anything.
  bool any = false;
  for (std::size_t i = 0; i < leaves.size(); ++i)
    any = any || (leaves[i].owned && allows(largest, i));
  if (!any_rank(any, communicator))
    return Coarsening::none;

  std::vector<double> limit = largest;
  update_ghosts<dim>(mesh, limit);
  // Flag a family if all children allow it and are owned here.
  bool flagged = false, split = false;
  for (std::size_t first = 0; first < leaves.size(); ++first)
  {
    if (!begins_family<dim>(leaves, first))
      continue;
    unsigned int n_owned = 0, n_allowing = 0;
    for (std::size_t i = first; i < first + n; ++i)
    {
      n_owned += leaves[i].owned;
      n_allowing += allows(limit, i);
    }
    const double parent = 2. * leaves[first].size;
    if (n_owned == 0 || n_allowing < n || touches_finer_leaf<dim>(mesh.leaves(), leaves[first]) ||
        parent > slack * wanted(leaves[first].lower, parent))
      continue;
    if (n_owned < n)
    {
      split = true;
      continue;
    }
    flagged = true;
    for (std::size_t i = first; i < first + n; ++i)
      cell_of<dim>(mesh, leaves[i])->set_coarsen_flag();
  }
  if (any_rank(flagged, communicator))
    return Coarsening::flagged;
  return any_rank(split, communicator) ? Coarsening::split_families : Coarsening::none;
}

template void find_touching<2>(const LeafTable<2>&, const std::array<double, 2>&, double, std::vector<unsigned int>&);
template void find_touching<3>(const LeafTable<3>&, const std::array<double, 3>&, double, std::vector<unsigned int>&);
template bool flag_refinement<2>(BackgroundMesh<2>&, const WantedSize<2>&, double, const FindSoil&);
template bool flag_refinement<3>(BackgroundMesh<3>&, const WantedSize<3>&, double, const FindSoil&);
template Coarsening flag_coarsening<2>(BackgroundMesh<2>&, const WantedSize<2>&, const std::vector<double>&);
template Coarsening flag_coarsening<3>(BackgroundMesh<3>&, const WantedSize<3>&, const std::vector<double>&);
} // namespace kedge
