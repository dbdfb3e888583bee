#include <kedge/replay/saved_step.h>

namespace kedge
{
namespace
{
/// `n` entries from `from`, which the device reads, behind what is in `to`.
template <typename T> void append(View<T*>& to, const T* from, const std::size_t n)
{
  const std::size_t before = to.extent(0);
  Kokkos::resize(to, before + n);
  using Foreign = Kokkos::View<const T*, MemorySpace, Kokkos::MemoryTraits<Kokkos::Unmanaged>>;
  Kokkos::deep_copy(Kokkos::subview(to, std::make_pair(before, before + n)), Foreign(from, n));
}

template <typename T> View<T*> first_of(const View<T*>& array, const std::size_t n)
{
  const View<T*> copy(Kokkos::view_alloc(array.label(), Kokkos::WithoutInitializing), n);
  Kokkos::deep_copy(copy, Kokkos::subview(array, std::make_pair(std::size_t(0), n)));
  return copy;
}
} // namespace

std::vector<RigidRate> SavedContact::rates() const
{
  std::vector<RigidRate> result;
  for (std::size_t i = 0; i < rate_point.size(); ++i)
    result.push_back({rate_point[i], Eigen::Map<const Vector6>(&rate_direction[6 * i])});
  return result;
}

SavedContact save_contact(const ContactArrays& contact, const SurfaceMotions& motions, const bool keeps_multipliers,
                          const std::vector<RigidRate>& rates)
{
  SavedContact saved;
  const std::size_t n_pairs = copy_to_host(contact.pair_begin)(contact.points.n());
  saved.arrays.points = contact.points;
  saved.arrays.pair_begin = contact.pair_begin;
  saved.arrays.pairs = first_of(contact.pairs, n_pairs);
  saved.arrays.rests = first_of(contact.rests, n_pairs);
  saved.motions = motions;
  const auto host = copy_to_host(motions);
  for (std::size_t s = 0; s < host.extent(0); ++s)
  {
    const TriangleTree& tree = host(s).tree;
    append(saved.nodes, tree.nodes, tree.n_nodes);
    append(saved.facets, tree.facets, tree.n_triangles);
    append(saved.parts, tree.parts, surface_tree::n_parts * tree.n_triangles);
    append(saved.grids, tree.grid.distance, tree.grid.n_cells());
  }
  saved.keeps_multipliers = keeps_multipliers ? 1 : 0;
  for (const RigidRate& rate : rates)
  {
    saved.rate_point.push_back(rate.point);
    saved.rate_direction.insert(saved.rate_direction.end(), rate.direction.data(), rate.direction.data() + 6);
  }
  return saved;
}

void point_into_trees(SavedContact& contact)
{
  const auto host = copy_to_host(contact.motions);
  std::size_t node = 0, triangle = 0, cell = 0;
  for (std::size_t s = 0; s < host.extent(0); ++s)
  {
    TriangleTree& tree = host(s).tree;
    const std::size_t n_cells = tree.grid.n_cells();
    tree.nodes = contact.nodes.data() + node;
    tree.facets = contact.facets.data() + triangle;
    tree.parts = contact.parts.data() + surface_tree::n_parts * triangle;
    tree.grid.distance = n_cells > 0 ? contact.grids.data() + cell : nullptr;
    node += tree.n_nodes;
    triangle += tree.n_triangles;
    cell += n_cells;
  }
  Kokkos::deep_copy(contact.motions, host);
}
} // namespace kedge
