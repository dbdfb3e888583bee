// What becomes of the history of a particle that splits.
#include <algorithm>
#include <cmath>
#include <kedge/base/communication.h>
#include <kedge/base/world_axes.h>
#include <kedge/contact/contact.h>
#include <limits>

namespace kedge
{
namespace
{
/// Gaps that differ by less are equal, in sizes of the particle.
constexpr double same_gap = 1e-6;

/// Places of the corners of a particle's children: 0, 1 or 2 halves of its edge along each axis.
template <int dim> constexpr unsigned int n_places = dim == 3 ? 27 : 9;

/// Number of the place where a child's corner lies. Along axes that are not cut a child is as long as its parent.
template <int dim> unsigned int place_of(const Split<dim>& split, const unsigned int octant, const unsigned int corner)
{
  unsigned int place = 0;
  for (unsigned int d = dim; d-- > 0;)
    place =
        3 * place + (split.is_cut_along(d) ? ((octant >> d) & 1u) + ((corner >> d) & 1u) : 2 * ((corner >> d) & 1u));
  return place;
}

/// Number of the place of the parent's own corner.
template <int dim> unsigned int place_of(const unsigned int corner)
{
  unsigned int place = 0;
  for (unsigned int d = dim; d-- > 0;)
    place = 3 * place + 2 * ((corner >> d) & 1u);
  return place;
}

/// Where a place is from the lower corner of the parent, in halves of its edges.
template <int dim> std::array<unsigned int, dim> halves(unsigned int place)
{
  std::array<unsigned int, dim> result;
  for (unsigned int& half : result)
  {
    half = place % 3;
    place /= 3;
  }
  return result;
}

/// Multilinear function of a parent's corner at a place.
template <int dim> double share_of_corner(const unsigned int parent_corner, const unsigned int place)
{
  const std::array<unsigned int, dim> at = halves<dim>(place);
  double share = 1.;
  for (unsigned int d = 0; d < dim; ++d)
    share *= (parent_corner >> d) & 1u ? 0.5 * at[d] : 1. - 0.5 * at[d];
  return share;
}

/// known: what the surface is to the split's centre or another point of it.
template <int dim>
std::array<double, n_places<dim>> gaps_at_places(const Split<dim>& split, const Surface& surface, const Pose& pose,
                                                 KnownDistance known)
{
  constexpr double anywhere = std::numeric_limits<double>::infinity();
  std::array<double, n_places<dim>> gaps;
  for (unsigned int place = 0; place < gaps.size(); ++place)
  {
    const std::array<unsigned int, dim> at = halves<dim>(place);
    std::array<double, dim> x = split.centre;
    for (unsigned int d = 0; d < dim; ++d)
      x[d] += (at[d] - 1.) * split.half_width[d];
    gaps[place] = surface.closest_point_within(pose.to_body(to_world<dim>(x)), anywhere, known)->gap;
  }
  return gaps;
}

/// Adds a multiple of what a corner remembers.
void add(ReferenceMemory& sum, const double factor, const ReferenceMemory& memory)
{
  sum.farthest_off += factor * memory.farthest_off;
  sum.farthest_in += factor * memory.farthest_in;
  sum.opening += factor * memory.opening;
  sum.approach.now += factor * memory.approach.now;
  sum.approach.most += factor * memory.approach.most;
  sum.approach.least += factor * memory.approach.least;
  sum.approach.beside_edges += factor * memory.approach.beside_edges;
}
/// What a parent's corners know of a surface: null where nothing.
template <int dim> using KnownCorners = std::array<const ContactHistory*, 1u << dim>;

/// What children's corners begin with at the places where they may lie.
template <int dim> struct Places
{
  std::array<bool, n_places<dim>> bonded{}, presses{};
  std::array<std::optional<ContactHistory>, n_places<dim>> state; ///< all but forces; empty: of nothing
};

/// gap: at the places. farthest: gap up to which corners may press.
template <int dim>
Places<dim> find_places(const KnownCorners<dim>& parent, const std::array<double, n_places<dim>>& gap,
                        const double farthest)
{
  constexpr unsigned int n = 1u << dim;
  Places<dim> places;
  for (unsigned int place = 0; place < n_places<dim>; ++place)
  {
    double known_share = 0., bonded_share = 0., reference_gap = 0.;
    ReferenceMemory memory;
    unsigned int n_contributing = 0;
    for (std::uint32_t from = 0; from < n; ++from)
    {
      const double share = share_of_corner<dim>(from, place);
      if (parent[from] == nullptr || share == 0.)
        continue;
      ++n_contributing;
      known_share += share;
      bonded_share += parent[from]->bonded ? share : 0.;
      reference_gap += share * parent[from]->reference_gap;
      add(memory, share, parent[from]->memory);
    }
    // what lies off the bonded corners' common edge or face, as the parent's centre always does, is not bonded
    const bool is_bonded = bonded_share == 1. && n_contributing < n;
    const bool presses = gap[place] <= farthest && known_share > 0.;
    places.bonded[place] = is_bonded;
    places.presses[place] = presses;
    if (known_share == 0. && !(gap[place] < 0.))
      continue;
    ContactHistory& state = places.state[place].emplace();
    state.bonded = is_bonded;
    if (is_bonded || presses)
    {
      state.reference_gap = reference_gap / known_share;
      add(state.memory, 1. / known_share, memory);
    }
    else // pushes no sooner than at the surface, nor at once
      state.reference_gap = std::min(0., gap[place]);
  }
  return places;
}

/// Calls visit(octant, corner, place) for all corners of all children.
template <int dim, typename Visit> void for_each_corner(const Split<dim>& split, const Visit& visit)
{
  constexpr unsigned int n = 1u << dim;
  for (unsigned int octant = 0; octant < n; ++octant)
    for (std::uint32_t corner = 0; corner < n && split.has_child(octant); ++corner)
      visit(octant, corner, place_of<dim>(split, octant, corner));
}
} // namespace

template <int dim> void Contact<dim>::inherit(const std::vector<Split<dim>>& splits, const RigidSystems& bodies)
{
  // nobody has looked for contact yet: soil in which a body begins is pressed out of it
  if (!has_searched && sum_over_ranks(static_cast<long long>(history.size()), communicator) == 0)
    return;
  for (const Split<dim>& split : splits)
  {
    const auto first = history.lower_bound({split.parent, 0, 0}), last = history.lower_bound({split.parent + 1, 0, 0});
    const std::map<ContactKey, ContactHistory> of_parent(first, last);
    history.erase(first, last);
    double radius = 0.; // of the ball that holds all corners
    for (const double half : split.half_width)
      radius = std::hypot(radius, half);
    for (std::uint32_t surface = 0; surface < bodies.surfaces.size(); ++surface)
    {
      const WeldedSurface& welded = bodies.surfaces[surface];
      const Eigen::Vector3d centre = bodies.points[welded.point].pose.to_body(to_world<dim>(split.centre));
      const bool is_known = std::any_of(of_parent.begin(), of_parent.end(),
                                        [&](const auto& entry) { return entry.first.surface == surface; });
      // What nobody knows of yet begins where a corner lies inside. A body that holds all of it is to replace it, or
      // has come over it between two steps: neither is contact that goes on.
      KnownDistance known;
      const auto closest = welded.surface.closest_point_within(centre, radius, known);
      if (is_known || (closest && closest->gap > -radius))
        inherit(split, surface, of_parent, bodies, known);
    }
  }
}

template <int dim>
void Contact<dim>::inherit(const Split<dim>& split, const std::uint32_t surface,
                           const std::map<ContactKey, ContactHistory>& of_parent, const RigidSystems& bodies,
                           const KnownDistance& known)
{
  constexpr unsigned int n = 1u << dim;
  const WeldedSurface& welded = bodies.surfaces[surface];
  const std::array<double, n_places<dim>> gap =
      gaps_at_places<dim>(split, welded.surface, bodies.points[welded.point].pose, known);
  KnownCorners<dim> parent;
  double farthest = -std::numeric_limits<double>::infinity(); // gap of the parent's corners that press
  for (std::uint32_t from = 0; from < n; ++from)
  {
    const auto entry = of_parent.find({split.parent, from, surface});
    parent[from] = entry == of_parent.end() ? nullptr : &entry->second;
    if (parent[from] != nullptr && parent[from]->pressure > 0.)
      farthest = std::max(farthest, gap[place_of<dim>(from)]);
  }
  farthest += same_gap * split.half_width[0];

  const Places<dim> places = find_places<dim>(parent, gap, farthest);
  const auto carries = [&](const std::uint32_t from, const unsigned int place)
  { return parent[from] != nullptr && (parent[from]->bonded ? places.bonded[place] : places.presses[place]); };
  std::array<double, n> sum{}; // what each of the parent's corners hands to all corners of the children
  for_each_corner(split,
                  [&](unsigned int, std::uint32_t, const unsigned int place)
                  {
                    for (std::uint32_t from = 0; from < n; ++from)
                      if (carries(from, place))
                        sum[from] += share_of_corner<dim>(from, place);
                  });
  for_each_corner(split,
                  [&](const unsigned int octant, const std::uint32_t corner, const unsigned int place)
                  {
                    if (!places.state[place])
                      return;
                    ContactHistory inherited = *places.state[place];
                    for (std::uint32_t from = 0; from < n; ++from)
                      if (carries(from, place) && sum[from] > 0.)
                      {
                        const double share = share_of_corner<dim>(from, place) / sum[from];
                        inherited.pressure += share * parent[from]->pressure;
                        inherited.multiplier += share * parent[from]->multiplier;
                        inherited.tangential += share * parent[from]->tangential;
                      }
                    if (inherited.pressure != 0.) // of corners that press and others that have opened
                      inherited.memory.opening = 0.;
                    history[{split.children[octant], corner, surface}] = inherited;
                  });
}

template void Contact<2>::inherit(const std::vector<Split<2>>&, const RigidSystems&);
template void Contact<3>::inherit(const std::vector<Split<3>>&, const RigidSystems&);
} // namespace kedge
