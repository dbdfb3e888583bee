#include <algorithm>
#include <cmath>
#include <kedge/base/communication.h>
#include <kedge/basis/gimp.h>
#include <kedge/basis/leaf_contents.h>
#include <map>

namespace kedge
{
namespace
{
constexpr double across = 1e-3; // distance from a leaf, as a share of its size, at which to look for its neighbour

/// A leaf inside the soil, where all neighbours hold soil too, counts as full from this filling on: the particles of
/// soil that flows are spread unevenly.
constexpr double full_inside = 0.49, filled_neighbour = 0.24;
/// At the ends of the soil it begins to count as full at this filling, and does so wholly only where it is: the surface
/// of soil that is pressed lies in the leaf.
constexpr double nearly_full = 0.89;

/// Name of a leaf that is the same on every rank: its lower corner in units of the finest cells that a forest can have.
template <int dim> using LeafKey = std::array<long long, dim>;

template <int dim> LeafKey<dim> leaf_key(const LeafTable<dim>& table, const unsigned int leaf)
{
  constexpr double finest = 1u << 30;
  LeafKey<dim> key;
  for (unsigned int d = 0; d < dim; ++d)
    key[d] = std::llround(finest * table.leaves[leaf].lower[d] / table.base_size);
  return key;
}

template <int dim> struct Parcel
{
  LeafKey<dim> key;
  LeafContent content;
};

/// Sends contents between the owners of leaves and the ranks that have them as ghosts.
template <int dim> class LeafExchange
{
public:
  LeafExchange(const LeafTable<dim>& table_, const MPI_Comm communicator_) : table(table_), communicator(communicator_)
  {
    ghosts.resize(size_of(communicator));
    for (unsigned int i = 0; i < table.leaves.size(); ++i)
      if (table.leaves[i].owned)
        owned.emplace(leaf_key(table, i), i);
      else
        ghosts[table.leaves[i].owner].push_back(i);
  }

  /// Adds what this rank found in ghost leaves to their owners' contents.
  void add_to_owners(std::vector<LeafContent>& contents) const
  {
    std::vector<std::vector<Parcel<dim>>> send(ghosts.size());
    for (std::size_t r = 0; r < ghosts.size(); ++r)
      for (const unsigned int leaf : ghosts[r])
        if (contents[leaf].volume > 0.)
          send[r].push_back({leaf_key(table, leaf), contents[leaf]});
    for (const auto& parcels : exchange_between_ranks(send, communicator))
      for (const Parcel<dim>& parcel : parcels)
        contents[owned.at(parcel.key)].add(parcel.content);
  }

  /// Replaces the contents of ghost leaves by those that their owners have.
  void update_ghosts(std::vector<LeafContent>& contents) const
  {
    std::vector<std::vector<LeafKey<dim>>> keys(ghosts.size());
    for (std::size_t r = 0; r < ghosts.size(); ++r)
      for (const unsigned int leaf : ghosts[r])
        keys[r].push_back(leaf_key(table, leaf));
    const auto asked = exchange_between_ranks(keys, communicator);
    std::vector<std::vector<LeafContent>> answer(ghosts.size());
    for (std::size_t r = 0; r < ghosts.size(); ++r)
      for (const LeafKey<dim>& key : asked[r])
        answer[r].push_back(contents[owned.at(key)]);
    const auto received = exchange_between_ranks(answer, communicator);
    for (std::size_t r = 0; r < ghosts.size(); ++r)
      for (std::size_t i = 0; i < ghosts[r].size(); ++i)
        contents[ghosts[r][i]] = received[r][i];
  }

private:
  const LeafTable<dim>& table;
  MPI_Comm communicator;
  std::vector<std::vector<unsigned int>> ghosts;
  std::map<LeafKey<dim>, unsigned int> owned;
};

template <int dim> double leaf_volume(const LeafTable<dim>& table, const unsigned int leaf)
{
  return std::pow(table.leaves[leaf].size, dim);
}

template <int dim>
bool is_boundary(const LeafTable<dim>& table, const std::vector<LeafContent>& contents, const unsigned int leaf,
                 const double poor_factor)
{
  if (contents[leaf].volume < poor_factor * leaf_volume(table, leaf))
    return true;
  for (unsigned int axis = 0; axis < dim; ++axis)
    for (const bool upper : {false, true})
      for (const unsigned int neighbour : find_neighbours(table, leaf, axis, upper))
        if (!is_populated(contents[neighbour]))
          return true;
  return false;
}

template <int dim>
double share_full(const LeafTable<dim>& table, const std::vector<LeafContent>& contents, const unsigned int leaf)
{
  const double filling = contents[leaf].volume / leaf_volume(table, leaf);
  if (filling >= 1. || filling < full_inside)
    return filling >= 1.;
  for (unsigned int axis = 0; axis < dim; ++axis)
    for (const bool upper : {false, true})
      for (const unsigned int neighbour : find_neighbours(table, leaf, axis, upper))
        if (contents[neighbour].volume < filled_neighbour * leaf_volume(table, neighbour))
          return std::max(0., (filling - nearly_full) / (1. - nearly_full));
  return 1.;
}
} // namespace

void LeafContent::add(const LeafContent& other)
{
  volume += other.volume;
  initial_volume += other.initial_volume;
  stiffness += other.stiffness;
  mass += other.mass;
  for (unsigned int i = 0; i < 3; ++i)
  {
    moment[i] += other.moment[i];
    mixed_moment[i] += other.mixed_moment[i];
  }
}

/// Leaves across a face (axis, upper or lower side): one, or 2^(dim-1) finer ones; none outside the window.
template <int dim>
std::vector<unsigned int> find_neighbours(const LeafTable<dim>& table, const unsigned int leaf, const unsigned int axis,
                                          const bool upper)
{
  const auto& cell = table.leaves[leaf];
  std::vector<unsigned int> neighbours;
  for (unsigned int quadrant = 0; quadrant < (1u << (dim - 1)); ++quadrant)
  {
    std::array<double, dim> x;
    for (unsigned int d = 0, bit = 0; d < dim; ++d)
      x[d] = cell.lower[d] +
             cell.size * (d == axis ? (upper ? 1. + across : -across) : ((quadrant >> bit++) & 1u ? 0.75 : 0.25));
    if (const int found = table.find_leaf(x); found >= 0 && table.in_window(table.leaves[found]))
      if (std::find(neighbours.begin(), neighbours.end(), unsigned(found)) == neighbours.end())
        neighbours.push_back(found);
  }
  return neighbours;
}

template <int dim>
std::vector<LeafContent> find_leaf_contents(const LeafTable<dim>& table, const SoilBoxes<dim>& soil,
                                            const double poor_factor, const MPI_Comm communicator)
{
  std::vector<LeafContent> contents(table.leaves.size());
  for (std::size_t p = 0; p < soil.half_width.size(); ++p)
  {
    double volume = 1.;
    for (const double half : soil.half_width[p])
      volume *= 2. * half;
    for (std::size_t i = soil.parts.begin[p]; i < soil.parts.begin[p + 1]; ++i)
    {
      const double fraction = soil.parts.fraction[i];
      LeafContent& content = contents[soil.parts.leaf[i]];
      content.volume += fraction * volume;
      content.initial_volume += fraction * soil.initial_volume[p];
      content.stiffness += fraction * volume * soil.young[p];
      content.mass += fraction * soil.mass[p];
      const auto& leaf = table.leaves[soil.parts.leaf[i]];
      const std::array<double, dim>& middle = soil.parts.middle[i];
      std::array<double, 3> x{};
      for (unsigned int d = 0; d < dim; ++d)
        x[d] = (middle[d] - leaf.lower[d]) / leaf.size - 0.5;
      for (unsigned int d = 0; d < 3; ++d)
      {
        content.moment[d] += fraction * volume * x[d];
        content.mixed_moment[d] += fraction * volume * x[(d + 1) % 3] * x[(d + 2) % 3];
      }
    }
  }
  // Boundaries depend on the neighbours, so ghosts must be complete first; then they need the result.
  const LeafExchange<dim> exchange(table, communicator);
  exchange.add_to_owners(contents);
  exchange.update_ghosts(contents);
  for (unsigned int leaf = 0; leaf < table.leaves.size(); ++leaf)
    if (table.leaves[leaf].owned && is_populated(contents[leaf]))
    {
      contents[leaf].boundary = is_boundary(table, contents, leaf, poor_factor);
      contents[leaf].full = share_full(table, contents, leaf);
    }
  exchange.update_ghosts(contents);
  return contents;
}

template std::vector<LeafContent> find_leaf_contents<2>(const LeafTable<2>&, const SoilBoxes<2>&, double, MPI_Comm);
template std::vector<LeafContent> find_leaf_contents<3>(const LeafTable<3>&, const SoilBoxes<3>&, double, MPI_Comm);
template std::vector<unsigned int> find_neighbours<2>(const LeafTable<2>&, unsigned int, unsigned int, bool);
template std::vector<unsigned int> find_neighbours<3>(const LeafTable<3>&, unsigned int, unsigned int, bool);
} // namespace kedge
