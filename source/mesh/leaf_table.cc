#include <algorithm>
#include <cmath>
#include <kedge/mesh/leaf_table.h>

namespace kedge
{
template <int dim> bool LeafTable<dim>::in_window(const Leaf& leaf) const
{
  for (unsigned int d = 0; d < dim; ++d)
    if (const double centre = leaf.lower[d] + 0.5 * leaf.size; centre < lower_end(d) || centre > upper_end(d))
      return false;
  return true;
}

template <int dim> bool LeafTable<dim>::in_grid(const std::array<double, dim>& x) const
{
  for (unsigned int d = 0; d < dim; ++d)
    if (x[d] < 0. || x[d] > base_size * base_cells[d])
      return false;
  return true;
}

template <int dim> int LeafTable<dim>::find_owner(const std::array<double, dim>& x) const
{
  return in_grid(x) ? partition.find_owner(x) : -1;
}

template <int dim> int LeafTable<dim>::find_leaf(const std::array<double, dim>& x) const
{
  if (!in_grid(x))
    return -1;
  std::array<double, dim> corner;
  std::int32_t entry = tree[partition.trees().find(x, corner)];
  for (double half = 0.5 * partition.trees().size; entry >= 0; half *= 0.5)
    entry = tree[entry + find_child<dim>(x, half, corner)];
  return entry == unknown ? -1 : -1 - entry;
}

namespace
{
template <int dim> struct BoxSearch
{
  const LeafTable<dim>& table;
  const std::array<double, dim>&lower, &upper;
  std::vector<unsigned int>& found;

  void descend(const std::int32_t entry, const std::array<double, dim>& corner, const double size) const
  {
    for (unsigned int d = 0; d < dim; ++d)
      if (corner[d] >= upper[d] || corner[d] + size <= lower[d])
        return;
    if (entry == LeafTable<dim>::unknown)
      return;
    if (entry < 0)
    {
      found.push_back(-1 - entry);
      return;
    }
    for (unsigned int child = 0; child < LeafTable<dim>::n_vertices; ++child)
    {
      std::array<double, dim> child_corner;
      for (unsigned int d = 0; d < dim; ++d)
        child_corner[d] = corner[d] + ((child >> d) & 1u ? 0.5 * size : 0.);
      descend(table.tree[entry + child], child_corner, 0.5 * size);
    }
  }
};
} // namespace

template <int dim>
void LeafTable<dim>::find_leaves(const std::array<double, dim>& lower, const std::array<double, dim>& upper,
                                 std::vector<unsigned int>& found) const
{
  const typename Partition<dim>::Trees& trees = partition.trees();
  std::array<unsigned int, 3> first{{0, 0, 0}}, last{{0, 0, 0}};
  for (unsigned int d = 0; d < dim; ++d)
  {
    const double end = static_cast<double>(trees.n[d]) - 1.;
    first[d] = static_cast<unsigned int>(std::clamp(std::floor(lower[d] / trees.size), 0., end));
    last[d] = static_cast<unsigned int>(std::clamp(std::floor(upper[d] / trees.size), 0., end));
  }
  const BoxSearch<dim> search{*this, lower, upper, found};
  std::array<unsigned int, 3> cell;
  for (cell[2] = first[2]; cell[2] <= last[2]; ++cell[2])
    for (cell[1] = first[1]; cell[1] <= last[1]; ++cell[1])
      for (cell[0] = first[0]; cell[0] <= last[0]; ++cell[0])
      {
        std::array<double, dim> corner;
        unsigned int entry = 0, stride = 1;
        for (unsigned int d = 0; d < dim; ++d)
        {
          corner[d] = trees.size * cell[d];
          entry += stride * cell[d];
          stride *= trees.n[d];
        }
        search.descend(tree[entry], corner, trees.size);
      }
}

template <int dim>
std::array<double, dim> LeafTable<dim>::within_neighbours(const unsigned int number, const std::array<double, dim>& x,
                                                          const std::array<double, dim>& half_width) const
{
  const Leaf& leaf = leaves[number];
  std::array<double, dim> inside; // from x to the nearer face along each axis
  bool far = false;
  for (unsigned int d = 0; d < dim; ++d)
  {
    inside[d] = std::clamp(std::min(x[d] - leaf.lower[d], leaf.lower[d] + leaf.size - x[d]), 0., leaf.size);
    far = far || half_width[d] > inside[d] + 0.5 * leaf.size;
  }
  if (!far) // 2:1: no neighbour is smaller
    return half_width;
  std::array<double, dim> lower, upper, result;
  for (unsigned int d = 0; d < dim; ++d)
  {
    lower[d] = leaf.lower[d] - 0.25 * leaf.size;
    upper[d] = leaf.lower[d] + 1.25 * leaf.size;
  }
  std::vector<unsigned int> around;
  find_leaves(lower, upper, around);
  double smallest = leaf.size;
  for (const unsigned int neighbour : around)
    smallest = std::min(smallest, leaves[neighbour].size);
  for (unsigned int d = 0; d < dim; ++d)
    result[d] = std::min(half_width[d], inside[d] + smallest);
  return result;
}

template struct LeafTable<2>;
template struct LeafTable<3>;
} // namespace kedge
