#include <algorithm>
#include <cmath>
#include <kedge/base/communication.h>
#include <kedge/basis/ghost_faces.h>
#include <kedge/basis/gimp.h>
#include <map>

namespace kedge
{
namespace
{
constexpr double across = 1e-3; // distance from a leaf, as a share of its size, at which to look for its neighbour

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
      {
        LeafContent& content = contents[owned.at(parcel.key)];
        content.volume += parcel.content.volume;
        content.initial_volume += parcel.content.initial_volume;
        content.stiffness += parcel.content.stiffness;
        content.mass += parcel.content.mass;
      }
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

/// Adds J of the face between a leaf and its neighbour. The face is that of the leaf, which must not be the larger one.
template <int dim>
void add_face(const LeafTable<dim>& table, const unsigned int leaf, const unsigned int neighbour,
              const unsigned int axis, const bool upper, HostGhostFaces& faces)
{
  const auto& cell = table.leaves[leaf];
  const double h = cell.size, area = std::pow(h, dim - 1);
  // Jump of the normal derivative at the Gauss points of the face, for every node of both leaves.
  const unsigned int n_points = 1u << (dim - 1);
  std::vector<unsigned int> nodes;
  std::vector<std::vector<double>> jumps(n_points); // by quadrature point and node
  std::vector<NodeShare<dim>> shares;
  for (unsigned int q = 0; q < n_points; ++q)
  {
    std::array<double, dim> x;
    for (unsigned int d = 0, bit = 0; d < dim; ++d)
      x[d] =
          cell.lower[d] + h * (d == axis ? (upper ? 1. : 0.) : 0.5 + ((q >> bit++) & 1u ? 0.5 : -0.5) / std::sqrt(3.));
    shares.clear();
    add_leaf_shape<dim>(table, leaf, x, -1., shares);
    add_leaf_shape<dim>(table, neighbour, x, 1., shares);
    if (q == 0)
      for (const NodeShare<dim>& share : shares)
        nodes.push_back(share.node);
    for (const NodeShare<dim>& share : shares) // the leaves' nodes have the same order at every point
      jumps[q].push_back(share.gradient[axis]);
  }
  for (unsigned int a = 0; a < nodes.size(); ++a)
    for (unsigned int b = 0; b < nodes.size(); ++b)
    {
      double sum = 0.;
      for (unsigned int q = 0; q < n_points; ++q)
        sum += jumps[q][a] * jumps[q][b];
      faces.value.push_back(h * h * h / 3. * area / n_points * sum);
    }
  faces.nodes.insert(faces.nodes.end(), nodes.begin(), nodes.end());
  faces.node_begin.push_back(faces.nodes.size());
  faces.value_begin.push_back(faces.value.size());
}
} // namespace

template <int dim>
std::vector<LeafContent> find_leaf_contents(const LeafTable<dim>& table, const SoilBoxes<dim>& soil,
                                            const double poor_factor, const MPI_Comm communicator)
{
  std::vector<LeafContent> contents(table.leaves.size());
  BoxAverage<dim> box(table);
  for (std::size_t p = 0; p < soil.centre.size(); ++p)
  {
    double volume = 1.;
    for (const double half : soil.half_width[p])
      volume *= 2. * half;
    for (const Overlap& overlap : box.find_overlaps(soil.centre[p], soil.half_width[p]))
    {
      LeafContent& content = contents[overlap.leaf];
      content.volume += overlap.fraction * volume;
      content.initial_volume += overlap.fraction * soil.initial_volume[p];
      content.stiffness += overlap.fraction * volume * soil.young[p];
      content.mass += overlap.fraction * soil.mass[p];
    }
  }
  // Boundaries depend on the neighbours, so ghosts must be complete first; then they need the result.
  const LeafExchange<dim> exchange(table, communicator);
  exchange.add_to_owners(contents);
  exchange.update_ghosts(contents);
  for (unsigned int leaf = 0; leaf < table.leaves.size(); ++leaf)
    if (table.leaves[leaf].owned && is_populated(contents[leaf]))
      contents[leaf].boundary = is_boundary(table, contents, leaf, poor_factor);
  exchange.update_ghosts(contents);
  return contents;
}

template <int dim>
HostGhostFaces find_ghost_faces(const LeafTable<dim>& table, const std::vector<LeafContent>& contents,
                                const GhostFactors& factors)
{
  HostGhostFaces faces;
  for (unsigned int leaf = 0; leaf < table.leaves.size(); ++leaf)
  {
    if (!table.leaves[leaf].owned || !is_populated(contents[leaf]))
      continue;
    for (unsigned int axis = 0; axis < dim; ++axis)
      for (const bool upper : {false, true})
      {
        const std::vector<unsigned int> neighbours = find_neighbours(table, leaf, axis, upper);
        if (neighbours.size() != 1) // none, or finer ones, which own their faces
          continue;
        // The smaller leaf owns the face; of equal leaves it is the lower one.
        const unsigned int other = neighbours[0];
        const double size = table.leaves[leaf].size, other_size = table.leaves[other].size;
        const bool mine = other_size > 1.5 * size || (other_size > 0.75 * size && upper);
        if (!mine || !is_populated(contents[other]) || contents[leaf].boundary + contents[other].boundary == 0.)
          continue;
        add_face(table, leaf, other, axis, upper, faces);
        const LeafContent &here = contents[leaf], &there = contents[other];
        faces.stiffness.push_back(0.5 * factors.stiffness *
                                  (here.stiffness / here.volume + there.stiffness / there.volume));
        faces.mass.push_back(0.5 * factors.mass * (here.mass / here.volume + there.mass / there.volume));
      }
  }
  return faces;
}

GhostFaces upload_ghost_faces(HostGhostFaces&& host, const std::vector<unsigned int>& number)
{
  for (unsigned int& node : host.nodes)
    node = number[node];
  return {upload(host.node_begin, "ghost node begin"),   upload(host.nodes, "ghost nodes"),
          upload(host.value_begin, "ghost value begin"), upload(host.value, "ghost values"),
          upload(host.stiffness, "ghost stiffness"),     upload(host.mass, "ghost mass")};
}

template std::vector<LeafContent> find_leaf_contents<2>(const LeafTable<2>&, const SoilBoxes<2>&, double, MPI_Comm);
template std::vector<LeafContent> find_leaf_contents<3>(const LeafTable<3>&, const SoilBoxes<3>&, double, MPI_Comm);
template HostGhostFaces find_ghost_faces<2>(const LeafTable<2>&, const std::vector<LeafContent>&, const GhostFactors&);
template HostGhostFaces find_ghost_faces<3>(const LeafTable<3>&, const std::vector<LeafContent>&, const GhostFactors&);
} // namespace kedge
