// What becomes of the pairs between evaluations, and what the last one says of all of them.
#include <cmath>
#include <kedge/contact_forces/evaluation.h>

namespace kedge
{
namespace
{
using Policy = Kokkos::RangePolicy<ExecutionSpace>;

/// The largest value(pair), at least 0, of the pairs that act.
template <typename Value> struct LargestOfActing
{
  ContactArrays contact;
  Value value;

  KEDGE_FUNCTION void operator()(const std::size_t k, double& largest) const
  {
    const unsigned int i = contact.points.acting(k);
    for (unsigned int pair = contact.pair_begin(i); pair < contact.pair_begin(i + 1); ++pair)
      if (contact.pairs(pair).active)
      {
        const double found = value(contact.pairs(pair));
        largest = found > largest ? found : largest;
      }
  }
};

template <typename Value> double largest_of_acting(const char* name, const ContactArrays& contact, const Value& value)
{
  double largest = 0.;
  Kokkos::parallel_reduce(name, Policy(0, contact.points.n_acting), LargestOfActing<Value>{contact, value},
                          Kokkos::Max<double>(largest));
  return std::fmax(0., largest);
}

/// Distance from touching over the size of the particle.
struct Excess
{
  KEDGE_FUNCTION double operator()(const ContactPair& pair) const
  {
    return pair.committed.bonded ? 0. : std::fabs(pair.gap - pair.reference_gap) / pair.size;
  }
};

struct Depth
{
  KEDGE_FUNCTION double operator()(const ContactPair& pair) const { return pair.reference_gap - pair.gap; }
};

/// In sizes of the particle.
struct Compression
{
  KEDGE_FUNCTION double operator()(const ContactPair& pair) const
  {
    return pair.committed.bonded ? 0. : (pair.reference_gap - pair.gap) / pair.size;
  }
};
} // namespace

void reset_multipliers(const ContactArrays& contact, const std::size_t n_pairs)
{
  const View<ContactPair*> pairs = contact.pairs;
  const View<ContactRest*> rests = contact.rests;
  Kokkos::parallel_for(
      "reset multipliers", Policy(0, n_pairs), KOKKOS_LAMBDA(const std::size_t k) {
        rests(k).followed = false;
        pairs(k).augmented = pairs(k).committed;
        pairs(k).slip_begin.setZero();
        pairs(k).carry_begin.setZero();
        pairs(k).approach_begin = pairs(k).committed.memory.approach;
        pairs(k).on_patch = pairs(k).knows_bend = false;
      });
}

void augment(const ContactArrays& contact, const std::size_t n_pairs, const double factor)
{
  const View<ContactPair*> pairs = contact.pairs;
  Kokkos::parallel_for(
      "augment", Policy(0, n_pairs), KOKKOS_LAMBDA(const std::size_t k) {
        ContactPair& pair = pairs(k);
        if (pair.committed.bonded) // springs alone: around edges the nodes cannot keep the gaps of all bonded corners
          return;
        const double before = pair.augmented.multiplier;
        const double after = before + factor * (pair.proposed.multiplier - before);
        pair.augmented = pair.proposed;
        pair.augmented.multiplier = after > 0. ? after : 0.;
        pair.on_patch = pair.on_patch || pair.active;
      });
}

void follow_path(const ContactArrays& contact, const std::size_t n_pairs)
{
  const View<ContactPair*> pairs = contact.pairs;
  const View<ContactRest*> rests = contact.rests;
  Kokkos::parallel_for(
      "follow path", Policy(0, n_pairs), KOKKOS_LAMBDA(const std::size_t k) {
        if (rests(k).asleep && rests(k).followed)
          return;
        rests(k).followed = true;
        ContactPair& pair = pairs(k);
        pair.augmented.tangential = pair.proposed.tangential; // none where nothing touches
        pair.slip_begin = pair.slip;
        if (pair.committed.bonded || pair.committed.reference_gap == 0.)
          return; // nothing fades
        pair.carry_begin = pair.carried - pair.start;
        pair.approach_begin = pair.approach;
      });
}

double largest_excess(const ContactArrays& contact) { return largest_of_acting("excess", contact, Excess()); }

double largest_compression(const ContactArrays& contact)
{
  return largest_of_acting("compression", contact, Compression());
}

double deepest_penetration(const ContactArrays& contact) { return largest_of_acting("depth", contact, Depth()); }

long long count_active(const ContactArrays& contact)
{
  const ContactArrays all = contact;
  long long n = 0;
  Kokkos::parallel_reduce(
      "active pairs", Policy(0, contact.points.n_acting),
      KOKKOS_LAMBDA(const std::size_t k, long long& count) {
        const unsigned int i = all.points.acting(k);
        for (unsigned int pair = all.pair_begin(i); pair < all.pair_begin(i + 1); ++pair)
          count += all.pairs(pair).active ? 1 : 0;
      },
      n);
  return n;
}

View<double*> point_stiffness(const ContactArrays& contact)
{
  const ContactArrays all = contact;
  const View<double*> result("point stiffness", contact.points.n());
  Kokkos::parallel_for(
      "point stiffness", Policy(0, contact.points.n()), KOKKOS_LAMBDA(const std::size_t i) {
        for (unsigned int pair = all.pair_begin(i); pair < all.pair_begin(i + 1); ++pair)
          result(i) += stiffest(all.pairs(pair).stiffness);
      });
  return result;
}
} // namespace kedge
