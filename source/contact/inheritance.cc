#include <algorithm>
#include <kedge/contact/contact.h>
#include <set>

namespace kedge
{
namespace
{
/// Multilinear share of a parent's corner at the corner of its child in an octant.
template <int dim>
double share_of_corner(const unsigned int parent_corner, const unsigned int octant, const unsigned int child_corner)
{
  double share = 1.;
  for (unsigned int d = 0; d < dim; ++d)
  {
    const double along = 0.5 * (((octant >> d) & 1u) + ((child_corner >> d) & 1u));
    share *= (parent_corner >> d) & 1u ? along : 1. - along;
  }
  return share;
}
} // namespace

template <int dim> void Contact<dim>::inherit(const std::vector<Split<dim>>& splits)
{
  constexpr unsigned int n = 1u << dim;
  constexpr double area_share = 2. / n;
  for (const Split<dim>& split : splits)
  {
    const auto first = history.lower_bound({split.parent, 0, 0}), last = history.lower_bound({split.parent + 1, 0, 0});
    const std::map<Key, History> of_parent(first, last);
    history.erase(first, last);
    std::set<std::uint32_t> surfaces;
    for (const auto& entry : of_parent)
      surfaces.insert(entry.first.surface);
    for (const std::uint32_t surface : surfaces)
      for (unsigned int octant = 0; octant < n; ++octant)
        for (std::uint32_t corner = 0; corner < n; ++corner)
        {
          History inherited;
          double known = 0., bonded = 0.;
          unsigned int n_contributing = 0;
          for (std::uint32_t from = 0; from < n; ++from)
          {
            const auto entry = of_parent.find({split.parent, from, surface});
            if (entry == of_parent.end())
              continue;
            const double share = share_of_corner<dim>(from, octant, corner);
            known += share;
            bonded += entry->second.bonded ? share : 0.;
            n_contributing += share > 0.;
            inherited.tangential += area_share * share * entry->second.tangential;
            inherited.multiplier += area_share * share * entry->second.multiplier;
            inherited.reference_gap += share * entry->second.reference_gap;
          }
          if (known == 0.)
            continue;
          inherited.reference_gap /= known;
          // what lies off the bonded corners' common edge or face, as the parent's centre always does, is not bonded
          inherited.bonded = bonded == 1. && n_contributing < n;
          if (!inherited.bonded) // what only presses does so no sooner than at the surface
            inherited.reference_gap = std::min(0., inherited.reference_gap);
          history[{split.children[octant], corner, surface}] = inherited;
        }
  }
}

template void Contact<2>::inherit(const std::vector<Split<2>>&);
template void Contact<3>::inherit(const std::vector<Split<3>>&);
} // namespace kedge
