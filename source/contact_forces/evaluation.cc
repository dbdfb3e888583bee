// Forces of all pairs for given motions of soil and bodies.
#include "surface_part.h"
#include <cmath>
#include <kedge/base/world_axes.h>
#include <kedge/contact_forces/evaluation.h>

namespace kedge
{
namespace
{
using Policy = Kokkos::RangePolicy<ExecutionSpace>;

/// What a metre of a body's motion across its surface takes off the reference gap of a corner: over four times its size
/// it fades, slowly enough for the soil to give way.
constexpr double fading_per_distance = 0.25;

/// In sizes of the particle: over so much of a body's first motion what its burial has left fades more slowly, from not
/// at all on.
constexpr double fades_slowly = 0.1;

/// In sizes of the particle: so far off its reference a corner has left it.
constexpr double leaves_beyond = 0.1;

/// Pairs respond from this distance on, in sizes of the particle, so that they have a slip before they touch.
constexpr double wakes_before = 0.1;

/// What counts as round-off in a gap, in sizes of the particle. Corners found inside a body for the first time start
/// where their springs have no force: without this the number of ranks would choose which of them press in the first
/// tangent, and with it Newton's path.
constexpr double round_off = 1e-9;

/// A pair that has just responded falls asleep where it touches nothing and holds nothing that could press.
KEDGE_FUNCTION void put_to_rest(const ContactPair& pair, const SurfaceMotion& surface, ContactRest& rest)
{
  const bool remembers = pair.committed.bonded || pair.committed.multiplier != 0. ||
                         pair.committed.reference_gap != 0. || pair.augmented.multiplier != 0.;
  rest.asleep = !(pair.active || remembers || pair.gap < infinity);
  if (rest.asleep)
    rest.clearance = larger(rest.clearance, surface.tree.least_gap(surface.now.to_body(pair.position), pair.known) -
                                                pair.slip.norm() - wakes_before * pair.size);
}

/// How far a body has come farther than ever before: a reference above zero fades where it goes away, too.
KEDGE_FUNCTION double progress(const BodyApproach& approach, const double reference_gap)
{
  return reference_gap > 0. ? approach.most - approach.least : approach.most;
}

/// The progress over which references fade more slowly, m.
KEDGE_FUNCTION double slow_start(const ContactPair& pair)
{
  const ReferenceMemory& memory = pair.committed.memory;
  return memory.farthest_off > 0. || memory.farthest_in > 0. ? fades_slowly * pair.size : 0.;
}

/// What a body has taken off the reference gap in all, m.
KEDGE_FUNCTION double faded(const BodyApproach& approach, const double reference_gap, const double slow)
{
  const double across = progress(approach, reference_gap);
  return fading_per_distance * ((across < slow ? 0.5 * across * across / slow : across - 0.5 * slow) +
                                (reference_gap > 0. ? approach.beside_edges : 0.));
}

/// The same in this step.
KEDGE_FUNCTION double faded_by(const ContactPair& pair, const double reference_gap)
{
  const double slow = slow_start(pair);
  return faded(pair.approach, reference_gap, slow) - faded(pair.committed.memory.approach, reference_gap, slow);
}

/// Lets the true surface take the place of the reference as the body moves on; `carried` is where it takes the corner's
/// start, m. Motion along the surface does not strain the soil across it and leaves the reference as it is; but where
/// the surface ends, a corner off it would drag soil along. Soil is only pressed harder where the body comes towards
/// it: boxes draw their corners off the surface and back while soil yields and springs back, and a surface that came
/// after them one step late would drive a body that bounces. A body that goes to and fro where it has been takes
/// nothing off except beside edges, so that cycles close, and next to nothing at first, so that elastic soil answers
/// alike either way.
KEDGE_FUNCTION void fade(ContactPair& pair, const SurfaceMotion& surface)
{
  if (pair.facing.isZero(0.))
    look_around(pair, surface);
  pair.carried = surface.now.to_world(surface.before.to_body(pair.start));
  const double first = pair.committed.reference_gap, side = first < 0. ? 1. : -1.;
  const Eigen::Vector3d motion = pair.carried - pair.start - pair.carry_begin;
  const double approach = pair.facing.dot(motion), distance = motion.norm();
  const BodyApproach& begin = pair.approach_begin;
  BodyApproach& after = pair.approach = begin;
  const bool any_motion = first > 0. && pair.near_edge;
  if (any_motion)
    after.beside_edges = begin.beside_edges + distance;
  else
  {
    after.now = begin.now + approach;
    after.most = larger(begin.most, after.now);
    after.least = smaller(begin.least, after.now);
  }
  pair.reference_gap = side * smaller(0., side * first + faded_by(pair, first));
  const double gained = any_motion ? distance : progress(after, first) - progress(begin, first);
  if (pair.reference_gap == 0. || !(gained > round_off * pair.size)) // round-off must not choose a direction
    return;
  const double rate = side * fading_per_distance, slow = slow_start(pair), across = progress(after, first);
  if (any_motion)
    pair.fading = rate / distance * motion;
  else
    pair.fading = (across < slow ? across / slow : 1.) * (approach > 0. ? rate : -rate) * pair.facing;
}

/// Forces and trial history of a pair at its position, its body having moved.
KEDGE_FUNCTION void respond(ContactPair& pair, const SurfaceMotion& surface, const bool keeps_multipliers)
{
  // a corner that touches nothing keeps no history and no multiplier
  const Frame &before = surface.before, &now = surface.now;
  pair.active = false;
  pair.force.setZero();
  pair.gap = infinity;
  pair.fading.setZero();
  pair.trial = ContactHistory();
  pair.proposed = pair.augmented;
  pair.proposed.multiplier = 0.;
  pair.proposed.tangential.setZero();

  const bool bonded = pair.committed.bonded;
  const Eigen::Vector3d x = now.to_body(pair.position);
  pair.slip = x - before.to_body(pair.start); // as the body sees it
  pair.reference_gap = pair.committed.reference_gap;
  if (!bonded && pair.reference_gap != 0.) // most have none
    fade(pair, surface);
  // up to where the multiplier and the reference press, or where the reference is left
  const double reaches = pair.reference_gap == 0. ? 0. : larger(0., pair.reference_gap + leaves_beyond * pair.size);
  const double held_off = pair.augmented.multiplier / pair.stiffness.normal + reaches;
  SurfacePart part;
  if (!find_part(pair, surface, x, held_off, part))
    return;
  pair.gap = part.gap;

  ContactGeometry at;
  at.gap = part.gap - pair.reference_gap;
  if (std::fabs(at.gap) < round_off * pair.size)
    at.gap = 0.;
  at.normal = now.direction_to_world(part.normal);
  at.steepness = part.steepness;
  at.turning = now.rotation * part.turning * now.rotation.transpose();
  at.slip = now.direction_to_world(pair.slip - pair.slip_begin);
  const Eigen::Vector3d previous = now.direction_to_world(before.direction_to_body(pair.augmented.tangential));

  const ContactResponse response = respond_to_contact(at, pair.stiffness, previous, pair.augmented.multiplier, bonded);
  pair.active = response.active;
  pair.force = response.force;
  pair.tangent = response.tangent;
  pair.by_gap = response.by_gap;
  pair.normal = at.normal;
  pair.trial.tangential = response.tangential;
  pair.trial.pressure = response.active ? response.force.dot(at.normal) : 0.;
  // soil that comes back to where it has left the body finds it there
  if (response.active || at.gap < leaves_beyond * pair.size)
  {
    pair.trial.reference_gap = pair.reference_gap;
    pair.trial.memory.farthest_off = larger(0., pair.committed.memory.farthest_off - faded_by(pair, 1.));
    pair.trial.memory.farthest_in = larger(0., pair.committed.memory.farthest_in - faded_by(pair, -1.));
    pair.trial.memory.approach = pair.approach;
    pair.trial.memory.opening = response.active ? 0. : at.gap;
  }
  else if (part.gap < 0.) // still inside: it starts from there, as one that is found inside
  {
    pair.trial.reference_gap = part.gap;
    pair.trial.memory = begins_at(part.gap);
  }
  pair.trial.bonded = bonded || (pair.bonds && response.active);
  if (response.active && keeps_multipliers)
  {
    const double pressure = pair.proposed.multiplier = response.force.dot(at.normal);
    if (pair.trial.bonded) // from now on the spring alone carries what the multiplier does
      pair.trial.reference_gap = part.gap + pressure / pair.stiffness.normal;
    else
      pair.trial.multiplier = pressure;
  }
  pair.proposed.tangential = before.direction_to_world(now.direction_to_body(response.tangential));
}

/// Largest displacement of a node, m: no point between nodes goes farther.
double largest_displacement(const unsigned int dim, const View<double*>& increment)
{
  double squared = 0.;
  Kokkos::parallel_reduce(
      "largest displacement", Policy(0, increment.extent(0) / dim),
      KOKKOS_LAMBDA(const std::size_t v, double& largest) {
        double sum = 0.;
        for (unsigned int d = 0; d < dim; ++d)
          sum += increment(dim * v + d) * increment(dim * v + d);
        largest = larger(largest, sum);
      },
      Kokkos::Max<double>(squared));
  return std::sqrt(squared);
}

/// Of one point after the other: pairs and forces.
template <int dim> struct EvaluatePoint
{
  ContactArrays contact;
  SurfaceMotions surfaces;
  View<double*> increment;
  double farthest; ///< that any point goes, m
  bool keeps_multipliers;

  KEDGE_FUNCTION double left(const ContactRest& rest) const
  {
    const SurfaceMotion& surface = surfaces(rest.surface);
    return rest.clearance - surface.shift - surface.turn * rest.lever;
  }

  KEDGE_FUNCTION void clear(const unsigned int i) const
  {
    for (unsigned int k = 0; k < 3; ++k)
      contact.points.force(3 * i + k) = 0.;
    for (unsigned int k = 0; k < 9; ++k)
      contact.points.tangent(9 * i + k) = 0.;
  }

  KEDGE_FUNCTION void add(const ContactPair& pair, const unsigned int i) const
  {
    for (int d = 0; d < dim; ++d)
    {
      contact.points.force(3 * i + d) += pair.force[world_axis(dim, d)];
      for (int e = 0; e < dim; ++e)
        contact.points.tangent(9 * i + 3 * d + e) += pair.tangent(world_axis(dim, d), world_axis(dim, e));
    }
  }

  KEDGE_FUNCTION void operator()(const unsigned int i) const
  {
    const unsigned int begin = contact.pair_begin(i), end = contact.pair_begin(i + 1);
    bool all_far = !contact.acts(i);
    for (unsigned int k = begin; all_far && k < end; ++k)
      all_far = contact.rests(k).asleep && farthest < left(contact.rests(k));
    if (all_far)
      return;
    if (contact.acts(i))
      clear(i);
    const Eigen::Vector3d displacement = point_displacement<dim>(contact.points, increment, i);
    bool acts = false;
    for (unsigned int k = begin; k < end; ++k)
    {
      ContactRest& rest = contact.rests(k);
      if (rest.asleep && displacement.norm() < left(rest))
        continue; // as its last response has left it: it touches nothing
      ContactPair& pair = contact.pairs(k);
      const SurfaceMotion& surface = surfaces(rest.surface);
      pair.position = pair.start + displacement;
      respond(pair, surface, keeps_multipliers);
      put_to_rest(pair, surface, rest);
      rest.followed = false;
      if (!pair.active)
        continue;
      acts = true;
      add(pair, i);
    }
    contact.acts(i) = acts;
  }
};

/// Lists the points whose pairs act.
void list_acting(ContactArrays& contact)
{
  const View<unsigned char*> acts = contact.acts;
  const View<unsigned int*> acting = contact.points.acting;
  unsigned int n = 0;
  Kokkos::parallel_scan(
      "acting points", Policy(0, acts.extent(0)),
      KOKKOS_LAMBDA(const std::size_t i, unsigned int& count, const bool is_last) {
        if (!acts(i))
          return;
        if (is_last)
          acting(count) = i;
        ++count;
      },
      n);
  contact.points.n_acting = n;
}
} // namespace

void make_room(ContactArrays& contact)
{
  PointForces& points = contact.points;
  const std::size_t n = points.begin.extent(0) > 0 ? points.begin.extent(0) - 1 : 0;
  contact.acts = View<unsigned char*>("acts", n);
  points.force = View<double*>("point forces", 3 * n);
  points.tangent = View<double*>("point tangents", 9 * n);
  points.acting = View<unsigned int*>(Kokkos::view_alloc("acting points", Kokkos::WithoutInitializing), n);
  points.n_acting = 0;
}

void evaluate_contact(const unsigned int dim, ContactArrays& contact, const SurfaceMotions& surfaces,
                      const View<double*>& increment, const bool keeps_multipliers)
{
  const double farthest = largest_displacement(dim, increment);
  const Policy all(0, contact.points.n());
  if (dim == 2)
    Kokkos::parallel_for("contact", all, EvaluatePoint<2>{contact, surfaces, increment, farthest, keeps_multipliers});
  else
    Kokkos::parallel_for("contact", all, EvaluatePoint<3>{contact, surfaces, increment, farthest, keeps_multipliers});
  list_acting(contact);
}
} // namespace kedge
