// Forces of all pairs for given motions of soil and bodies, and the multipliers that they leave behind.
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
/// What a metre of a body's motion takes off the reference gaps of corners that were inside it at the start: over four
/// times their depth they fade, slowly enough for the soil to give way.
constexpr double fading_per_distance = 0.25;

/// Nearer to an edge or a vertex than this, in sizes of the particle, a corner counts as on it: the direction from
/// there is what the last solution has left of the distance.
constexpr double on_surface = 0.05;

/// Pairs respond from this distance on, in sizes of the particle, so that they have a slip before they touch.
constexpr double wakes_before = 0.1;

Eigen::Matrix3d normal_subspace(const ClosestPoint& closest)
{
  switch (closest.feature)
  {
    case Feature::edge:
      return Eigen::Matrix3d::Identity() - closest.tangent * closest.tangent.transpose();
    case Feature::vertex:
      return Eigen::Matrix3d::Identity();
    case Feature::face:
      break;
  }
  return closest.normal * closest.normal.transpose();
}

/// Of nodal vectors at a point, in the world's axes. Evaluations call this for every pair, so sums stay in
/// registers.
template <int dim>
inline Eigen::Vector3d weighted_sum(const PointForces& points, const std::vector<double>& nodal, const unsigned int at)
{
  double sum[dim] = {};
  for (unsigned int v = points.begin[at]; v < points.begin[at + 1]; ++v)
    for (int d = 0; d < dim; ++d)
      sum[d] += points.weights[v] * nodal[dim * points.nodes[v] + d];
  Eigen::Vector3d u = Eigen::Vector3d::Zero();
  for (int d = 0; d < dim; ++d)
    u[world_axis(dim, d)] = sum[d];
  return u;
}
} // namespace

template <int dim>
Contact<dim>::Contact(const ContactParameters& parameters_, const MPI_Comm communicator_)
    : parameters(parameters_), communicator(communicator_)
{
}

template <int dim> Eigen::Vector3d Contact<dim>::corner_displacement(const unsigned int point) const
{
  if (nodal_increment.empty()) // nothing is evaluated yet
    return Eigen::Vector3d::Zero();
  return weighted_sum<dim>(points, nodal_increment, point);
}

/// By surface.
template <int dim>
auto Contact<dim>::find_approaches(const RigidSystems& committed, const std::vector<Pose>& moved)
    -> std::vector<Approach>
{
  std::vector<Approach> approaches;
  for (const WeldedSurface& welded : committed.surfaces)
  {
    const Pose &before = committed.points[welded.point].pose, &now = moved[welded.point];
    const double angle = before.rotation.angularDistance(now.rotation);
    approaches.push_back({(now.position - before.position).norm(), 2. * std::sin(0.5 * angle)});
  }
  return approaches;
}

template <int dim> void Contact<dim>::wake_all()
{
  for (Rest& rest : rests)
    rest.asleep = false;
}

template <int dim>
const PointForces& Contact<dim>::evaluate(const RigidSystems& committed, const std::vector<Vector6>& increments,
                                          const double* increment, const std::size_t n_nodes)
{
  nodal_increment.assign(increment, increment + dim * n_nodes);
  std::vector<Pose> moved;
  for (std::size_t i = 0; i < committed.points.size(); ++i)
    moved.push_back(committed.points[i].pose.moved(increments[i]));

  const std::vector<Approach> approaches = find_approaches(committed, moved);
  for (const unsigned int point : acting)
  {
    std::fill_n(&points.force[3 * point], 3, 0.);
    std::fill_n(&points.tangent[9 * point], 9, 0.);
  }
  acting.clear();
  touching.clear();
  for (std::size_t k = 0; k < pairs.size(); ++k)
  {
    Rest& rest = rests[k];
    const Approach& approach = approaches[rest.surface];
    const double left = rest.clearance - approach.shift - approach.turn * rest.lever;
    const Eigen::Vector3d displacement = weighted_sum<dim>(points, nodal_increment, rest.point);
    if (rest.asleep && displacement.norm() < left)
      continue; // as its last response has left it: it touches nothing
    Pair& pair = pairs[k];
    const WeldedSurface& welded = committed.surfaces[pair.key.surface];
    pair.position = pair.start + displacement;
    respond(pair, welded.surface, committed.points[welded.point].pose, moved[welded.point]);
    put_to_rest(pair, welded.surface, moved[welded.point], rest);
    if (!pair.active)
      continue;
    acting.push_back(pair.point);
    touching.push_back({pair.position, pair.force, pair.key.surface});
    for (unsigned int i = 0; i < dim; ++i)
    {
      points.force[3 * pair.point + i] += pair.force[world_axis(dim, i)];
      for (unsigned int j = 0; j < dim; ++j)
        points.tangent[9 * pair.point + 3 * i + j] += pair.tangent(world_axis(dim, i), world_axis(dim, j));
    }
  }
  return points;
}

/// A pair that has just responded falls asleep where it touches nothing and holds nothing that could press.
template <int dim> void Contact<dim>::put_to_rest(const Pair& pair, const Surface& surface, const Pose& now, Rest& rest)
{
  const bool remembers = pair.committed.bonded || pair.committed.multiplier != 0. ||
                         pair.committed.reference_gap != 0. || pair.augmented.multiplier != 0.;
  rest.asleep = !(pair.active || remembers || std::isfinite(pair.gap));
  if (rest.asleep)
    rest.clearance = std::max(rest.clearance, surface.least_gap(now.to_body(pair.position), pair.known) -
                                                  pair.slip.norm() - wakes_before * pair.size);
}

/// Within a step a plane stands for the surface where its kinks would keep Newton's method from coming to rest: tension
/// pulls a corner inside a convex body into the kinks of the distance, where the normal jumps from facet to facet, and
/// a multiplier presses on however near the surface is, while the normal at an edge turns by 1/distance.
template <int dim>
std::optional<ClosestPoint> Contact<dim>::find_closest(Pair& pair, const Surface& surface, const Pose& before,
                                                       const Eigen::Vector3d& x, const double distance)
{
  if (!pair.on_plane && (pair.committed.bonded || pair.committed.multiplier > 0. || pair.committed.reference_gap > 0.))
  {
    pair.on_plane = true;
    pair.plane = surface.closest_point(before.to_body(pair.start));
    if (std::abs(pair.plane.gap) < on_surface * pair.size)
      pair.plane.normal = pair.plane.pseudo_normal;
  }
  if (!pair.on_plane)
    return surface.closest_point_within(x, distance, pair.known);
  ClosestPoint closest = pair.plane;
  closest.gap += closest.normal.dot(pair.slip);
  closest.feature = Feature::face;
  return closest;
}

/// Lets the true surface come to meet the soil while the body moves; `carried` is where the body takes the place of the
/// corner's start, m.
template <int dim> void Contact<dim>::fade(Pair& pair, const Eigen::Vector3d& carried)
{
  const double first = pair.committed.reference_gap, distance = (carried - pair.start).norm();
  const double side = first < 0. ? 1. : -1.;
  pair.carried = carried;
  pair.reference_gap = side * std::min(0., side * first + fading_per_distance * distance);
  if (pair.reference_gap != 0. && distance > 0.)
    pair.fading = side * fading_per_distance / distance * (carried - pair.start);
}

template <int dim>
void Contact<dim>::respond(Pair& pair, const Surface& surface, const Pose& before, const Pose& now) const
{
  // a corner that touches nothing keeps no history and no multiplier
  pair.active = false;
  pair.force.setZero();
  pair.gap = std::numeric_limits<double>::infinity();
  pair.fading.setZero();
  pair.trial = History();
  pair.proposed = pair.augmented;
  pair.proposed.multiplier = 0.;
  pair.proposed.tangential.setZero();

  const bool bonded = pair.committed.bonded;
  const Eigen::Vector3d x = now.to_body(pair.position);
  pair.slip = x - before.to_body(pair.start); // as the body sees it
  pair.reference_gap = pair.committed.reference_gap;
  if (!bonded && pair.reference_gap != 0.) // most have none
    fade(pair, now.to_world(before.to_body(pair.start)));
  // up to where the multiplier and the reference press
  const double held_off = pair.augmented.multiplier / pair.stiffness.normal + std::max(0., pair.reference_gap);
  const auto closest = find_closest(pair, surface, before, x, held_off);
  if (!closest)
    return;
  pair.gap = closest->gap;
  if (!pair.on_plane)
  {
    pair.plane = *closest;
    pair.plane.gap -= closest->normal.dot(pair.slip);
  }

  ContactGeometry at;
  at.distance = closest->gap;
  at.gap = closest->gap - pair.reference_gap;
  at.normal = now.direction_to_world(closest->normal);
  const Eigen::Matrix3d turn = now.rotation.toRotationMatrix();
  at.normal_subspace = turn * normal_subspace(*closest) * turn.transpose();
  at.slip = now.direction_to_world(pair.slip - pair.slip_begin);
  const Eigen::Vector3d previous = now.direction_to_world(before.direction_to_body(pair.augmented.tangential));

  const ContactResponse response = respond_to_contact(at, pair.stiffness, previous, pair.augmented.multiplier, bonded);
  pair.active = response.active;
  pair.force = response.force;
  pair.tangent = response.tangent;
  pair.normal = at.normal;
  pair.trial.tangential = response.tangential;
  pair.trial.pressure = response.active ? response.force.dot(at.normal) : 0.;
  // a corner that comes out of its first penetration finds the true surface when it returns
  pair.trial.reference_gap =
      response.active ? pair.reference_gap : std::min(0., std::max(pair.reference_gap, closest->gap));
  pair.trial.bonded = bonded || (pair.bonds && response.active);
  if (response.active && parameters.method == ContactMethod::augmented_lagrangian)
  {
    const double pressure = pair.proposed.multiplier = response.force.dot(at.normal);
    if (pair.trial.bonded) // from now on the spring alone carries what the multiplier does
      pair.trial.reference_gap = closest->gap + pressure / pair.stiffness.normal;
    else
      pair.trial.multiplier = pressure;
  }
  pair.proposed.tangential = before.direction_to_world(now.direction_to_body(response.tangential));
}

template <int dim> void Contact<dim>::reset_multipliers()
{
  for (Pair& pair : pairs)
  {
    pair.augmented = pair.committed;
    pair.slip_begin.setZero();
    pair.on_plane = false;
  }
}

template <int dim> void Contact<dim>::augment(const double factor)
{
  for (Pair& pair : pairs)
  {
    if (pair.committed.bonded) // springs alone: around edges the nodes cannot keep the gaps of all bonded corners
      continue;
    const double before = pair.augmented.multiplier;
    pair.augmented = pair.proposed;
    pair.augmented.multiplier = std::max(0., before + factor * (pair.proposed.multiplier - before));
    pair.on_plane = pair.on_plane || pair.active;
  }
}

template <int dim> void Contact<dim>::follow_path()
{
  for (Pair& pair : pairs)
  {
    pair.augmented.tangential = pair.proposed.tangential; // none where nothing touches
    pair.slip_begin = pair.slip;
  }
}

template <int dim> double Contact<dim>::excess() const
{
  double worst = 0.;
  if (parameters.method == ContactMethod::augmented_lagrangian)
    for (const Pair& pair : pairs)
      if (pair.active && !pair.committed.bonded)
        worst =
            std::max(worst, std::abs(pair.gap - pair.reference_gap) / (parameters.penetration_tolerance * pair.size));
  return max_over_ranks(worst, communicator);
}

template <int dim> std::map<long long, double> Contact<dim>::smallest_gaps(const RigidSystems& moved) const
{
  std::map<long long, double> gaps;
  for (const Pair& pair : pairs)
  {
    double& smallest = gaps.emplace(pair.key.particle, std::numeric_limits<double>::infinity()).first->second;
    double gap = pair.gap;
    if (!std::isfinite(gap) && smallest > 0.) // evaluations look no farther than what may press
    {
      const WeldedSurface& welded = moved.surfaces[pair.key.surface];
      const Eigen::Vector3d x = moved.points[welded.point].pose.to_body(pair.start + corner_displacement(pair.point));
      KnownDistance known = pair.known;
      if (const auto closest = welded.surface.closest_point_within(x, std::min(pair.size, smallest), known))
        gap = closest->gap;
    }
    smallest = std::min(smallest, gap);
  }
  return gaps;
}

template <int dim> long long Contact<dim>::n_active() const
{
  const long long here = std::count_if(pairs.begin(), pairs.end(), [](const Pair& pair) { return pair.active; });
  return sum_over_ranks(here, communicator);
}

template <int dim> double Contact<dim>::deepest_penetration() const
{
  double deepest = 0.;
  for (const Pair& pair : pairs)
    if (pair.active)
      deepest = std::max(deepest, pair.reference_gap - pair.gap);
  return max_over_ranks(deepest, communicator);
}

template class Contact<2>;
template class Contact<3>;
} // namespace kedge
