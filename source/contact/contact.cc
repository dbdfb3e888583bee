#include <algorithm>
#include <cmath>
#include <kedge/base/communication.h>
#include <kedge/base/world_axes.h>
#include <kedge/basis/active_nodes.h>
#include <kedge/contact/contact.h>
#include <limits>
#include <unordered_set>

namespace kedge
{
namespace
{
/// What a body's way (m) takes off the reference gaps of corners that were inside it at the start: over four times
/// their depth they fade, slowly enough for the soil to give way.
constexpr double fading_per_way = 0.25;

/// A corner takes its shape functions from the cell on its particle's side, also where it lies on a face of cells.
constexpr double nudge = 1e-6;

template <int dim> Eigen::Vector3d to_world(const std::array<double, dim>& x)
{
  // plane strain happens in the plane y = 0
  return dim == 3 ? Eigen::Vector3d(x[0], x[1], x[dim - 1]) : Eigen::Vector3d(x[0], 0., x[1]);
}

double stiffest(const ContactStiffness& stiffness) { return std::max(stiffness.normal, stiffness.tangential); }

template <int dim>
ContactStiffness make_stiffness(const ContactParameters& parameters, const double volume, const double young)
{
  const double size = std::pow(volume, 1. / dim);
  const double area = std::pow(size, dim - 1);
  const double corner_share = dim == 3 ? 0.25 : 0.5; // of the particle's face
  const double unit = young * area / size * corner_share;
  return {parameters.normal_penalty_factor * unit, parameters.tangential_penalty_factor * unit,
          parameters.friction_coefficient};
}

Eigen::Matrix3d normal_subspace(const ClosestPoint& closest)
{
  switch (closest.feature)
  {
    case Feature::edge:
      return Eigen::Matrix3d::Identity() - closest.tangent * closest.tangent.transpose();
    case Feature::vertex:
      return Eigen::Matrix3d::Identity();
    default:
      return closest.normal * closest.normal.transpose();
  }
}
} // namespace

template <int dim>
Contact<dim>::Contact(const ContactParameters& parameters_, const MPI_Comm communicator_)
    : parameters(parameters_), communicator(communicator_)
{
}

template <int dim>
void Contact<dim>::find_pairs(const RigidSystems& bodies, const LeafTable<dim>& table,
                              const ContactParticles<dim>& particles, const std::vector<unsigned int>& number,
                              const double reach)
{
  pairs.clear();
  points = PointForces();
  std::vector<NodeShare<dim>> shares;
  for (std::size_t p = 0; p < particles.centre.size(); ++p)
  {
    double radius = reach;
    for (const double half : particles.half_width[p])
      radius += 2. * half;
    std::vector<unsigned int> near;
    for (unsigned int s = 0; s < bodies.surfaces.size(); ++s)
    {
      const WeldedSurface& welded = bodies.surfaces[s];
      const Eigen::Vector3d x = bodies.points[welded.point].pose.to_body(to_world<dim>(particles.centre[p]));
      if (!welded.surface.surely_farther_than(x, radius) && welded.surface.closest_point_within(x, radius))
        near.push_back(s);
    }
    if (near.empty())
      continue;

    const ContactStiffness stiffness = make_stiffness<dim>(parameters, particles.initial_volume[p], particles.young[p]);
    for (unsigned int corner = 0; corner < (1u << dim); ++corner)
    {
      std::array<double, dim> x, inside;
      for (unsigned int d = 0; d < dim; ++d)
      {
        const double sign = (corner >> d) & 1u ? 1. : -1., half = particles.half_width[p][d];
        x[d] = particles.centre[p][d] + sign * half;
        inside[d] =
            std::clamp(particles.centre[p][d] + sign * half * (1. - nudge), 0., table.base_size * table.base_cells[d]);
      }
      const int leaf = table.find_leaf(inside);
      if (leaf < 0)
        continue;
      for (unsigned int d = 0; d < dim; ++d) // the corner itself, so that moments balance too
        inside[d] =
            std::clamp(x[d], table.leaves[leaf].lower[d], table.leaves[leaf].lower[d] + table.leaves[leaf].size);
      shares.clear();
      add_leaf_shape<dim>(table, leaf, inside, 1., shares);
      // a sliver of the box may reach into a leaf without making all its nodes active
      shares.erase(std::remove_if(shares.begin(), shares.end(),
                                  [&](const auto& share) { return number[share.node] == ActiveNodes::inactive; }),
                   shares.end());
      double sum = 0.;
      for (const NodeShare<dim>& share : shares)
        sum += share.value;
      if (!(sum > 0.))
        continue;
      const unsigned int point = points.n_points();
      for (const NodeShare<dim>& share : shares)
      {
        points.nodes.push_back(number[share.node]);
        points.weights.push_back(share.value / sum);
      }
      points.begin.push_back(points.nodes.size());
      for (const unsigned int s : near)
      {
        Pair pair;
        pair.key = {particles.id[p], corner, s};
        pair.point = point;
        pair.start = to_world<dim>(x);
        pair.stiffness = stiffness;
        pair.size = std::pow(particles.initial_volume[p], 1. / dim);
        if (const auto entry = history.find(pair.key); entry != history.end())
          pair.committed = entry->second;
        pair.trial = pair.augmented = pair.committed;
        pairs.push_back(pair);
      }
    }
  }
  points.force.assign(3 * points.n_points(), 0.);
  points.tangent.assign(9 * points.n_points(), 0.);
}

template <int dim> void Contact<dim>::take_reference_gaps(const RigidSystems& bodies)
{
  for (Pair& pair : pairs)
  {
    const WeldedSurface& welded = bodies.surfaces[pair.key.surface];
    const auto closest = welded.surface.closest_point_within(bodies.points[welded.point].pose.to_body(pair.start), 0.);
    if (closest && closest->gap < 0.)
    {
      pair.committed.reference_gap = closest->gap;
      pair.trial = pair.augmented = pair.committed;
      history[pair.key] = pair.committed;
    }
  }
}

template <int dim> void Contact<dim>::reset_multipliers()
{
  for (Pair& pair : pairs)
    pair.augmented = pair.committed;
}

template <int dim> void Contact<dim>::augment(const double factor)
{
  for (Pair& pair : pairs)
  {
    const double before = pair.augmented.multiplier;
    pair.augmented = pair.proposed;
    pair.augmented.multiplier = std::max(0., before + factor * (pair.proposed.multiplier - before));
  }
}

template <int dim> double Contact<dim>::excess() const
{
  double worst = 0.;
  if (parameters.method == ContactMethod::augmented_lagrangian)
    for (const Pair& pair : pairs)
      if (pair.active)
        worst = std::max(worst, std::abs(pair.gap - pair.committed.reference_gap) /
                                    (parameters.penetration_tolerance * pair.size));
  return max_over_ranks(worst, communicator);
}

template <int dim>
Eigen::Vector3d Contact<dim>::corner_displacement(const Pair& pair, const double* nodal_increment) const
{
  Eigen::Vector3d u = Eigen::Vector3d::Zero();
  for (unsigned int v = points.begin[pair.point]; v < points.begin[pair.point + 1]; ++v)
    for (unsigned int d = 0; d < dim; ++d)
      u[world_axis(dim, d)] += points.weights[v] * nodal_increment[dim * points.nodes[v] + d];
  return u;
}

template <int dim>
const PointForces& Contact<dim>::evaluate(const RigidSystems& committed, const std::vector<Vector6>& increments,
                                          const double* nodal_increment)
{
  std::vector<Pose> moved;
  for (std::size_t i = 0; i < committed.points.size(); ++i)
    moved.push_back(committed.points[i].pose.moved(increments[i]));

  std::fill(points.force.begin(), points.force.end(), 0.);
  std::fill(points.tangent.begin(), points.tangent.end(), 0.);
  touching.clear();
  for (Pair& pair : pairs)
  {
    const WeldedSurface& welded = committed.surfaces[pair.key.surface];
    const Pose &before = committed.points[welded.point].pose, &now = moved[welded.point];
    pair.position = pair.start + corner_displacement(pair, nodal_increment);
    pair.active = false;
    pair.force.setZero();
    pair.gap = std::numeric_limits<double>::infinity();
    pair.trial = History();
    pair.proposed = pair.augmented;
    pair.proposed.multiplier = 0.;
    pair.proposed.tangential.setZero();
    const double held_off = pair.augmented.multiplier / pair.stiffness.normal; // up to where the multiplier presses
    const auto closest = welded.surface.closest_point_within(now.to_body(pair.position), held_off, pair.known);
    if (!closest)
      continue;
    pair.gap = closest->gap;
    // a corner that comes out of its first penetration finds the true surface when it returns; while its body moves,
    // the surface comes to meet it
    const double way = (now.to_world(before.to_body(pair.start)) - pair.start).norm();
    pair.trial.reference_gap =
        std::min(0., std::max(pair.committed.reference_gap + fading_per_way * way, closest->gap));

    ContactGeometry at;
    at.distance = closest->gap;
    at.gap = closest->gap - pair.committed.reference_gap;
    at.normal = now.direction_to_world(closest->normal);
    const Eigen::Matrix3d turn = now.rotation.toRotationMatrix();
    at.normal_subspace = turn * normal_subspace(*closest) * turn.transpose();
    at.slip = now.direction_to_world(now.to_body(pair.position) - before.to_body(pair.start)); // as the body sees it
    const Eigen::Vector3d previous = now.direction_to_world(before.direction_to_body(pair.augmented.tangential));

    const ContactResponse response = respond_to_contact(at, pair.stiffness, previous, pair.augmented.multiplier);
    pair.active = response.active;
    pair.force = response.force;
    pair.tangent = response.tangent;
    pair.trial.tangential = response.tangential;
    if (!response.active)
      continue;
    if (parameters.method == ContactMethod::augmented_lagrangian)
    {
      pair.trial.multiplier = pair.proposed.multiplier = response.force.dot(at.normal);
      pair.proposed.tangential = before.direction_to_world(now.direction_to_body(response.tangential));
    }
    touching.push_back({pair.position, pair.force, pair.key.surface});
    for (unsigned int i = 0; i < dim; ++i)
    {
      points.force[3 * pair.point + i] += response.force[world_axis(dim, i)];
      for (unsigned int j = 0; j < dim; ++j)
        points.tangent[9 * pair.point + 3 * i + j] += response.tangent(world_axis(dim, i), world_axis(dim, j));
    }
  }
  return points;
}

template <int dim> std::vector<double> Contact<dim>::point_stiffness() const
{
  std::vector<double> result(points.n_points(), 0.);
  for (const Pair& pair : pairs)
    result[pair.point] += stiffest(pair.stiffness);
  return result;
}

template <int dim> double Contact<dim>::largest_body_frequency(const RigidSystems& bodies) const
{
  // stiffness, N/m, and stiffness times the square of the arm, N m, of all springs to a point
  std::vector<Eigen::Vector2d> springs(bodies.points.size(), Eigen::Vector2d::Zero());
  for (const Pair& pair : pairs)
  {
    const unsigned int point = bodies.surfaces[pair.key.surface].point;
    const double stiffness = stiffest(pair.stiffness);
    springs[point] += stiffness * Eigen::Vector2d(1., (pair.start - bodies.points[point].pose.position).squaredNorm());
  }
  if (!springs.empty())
    MPI_Allreduce(MPI_IN_PLACE, springs.data(), 2 * springs.size(), MPI_DOUBLE, MPI_SUM, communicator);
  double largest = 0.;
  for (std::size_t i = 0; i < springs.size(); ++i)
  {
    const RigidPoint& point = bodies.points[i];
    double sum = point.is_free(0) || point.is_free(1) || point.is_free(2) ? springs[i][0] / point.mass : 0.;
    const bool turns_about_all = point.is_free(3) && point.is_free(4) && point.is_free(5);
    double least = turns_about_all ? point.inertia.minCoeff() : std::numeric_limits<double>::infinity();
    const Eigen::Vector3d about_axes = point.world_inertia().diagonal();
    for (unsigned int axis = 0; axis < 3; ++axis)
      if (point.is_free(3 + axis))
        least = std::min(least, about_axes[axis]);
    sum += springs[i][1] / least;
    largest = std::max(largest, sum);
  }
  return largest;
}

template <int dim>
BodyLoads Contact<dim>::loads(const RigidSystems& committed, const std::vector<Vector6>& increments) const
{
  BodyLoads result(committed.points.size(), Vector6::Zero());
  for (const Pair& pair : pairs)
    if (pair.active)
    {
      const unsigned int point = committed.surfaces[pair.key.surface].point;
      const Eigen::Vector3d arm = pair.position - committed.points[point].pose.moved(increments[point]).position;
      result[point].template head<3>() -= pair.force;
      result[point].template tail<3>() -= arm.cross(pair.force);
    }
  if (!result.empty())
    MPI_Allreduce(MPI_IN_PLACE, result.data(), 6 * result.size(), MPI_DOUBLE, MPI_SUM, communicator);
  return result;
}

template <int dim> void Contact<dim>::commit()
{
  history.clear();
  for (const Pair& pair : pairs)
    if (pair.active || pair.trial.reference_gap < 0.)
      history[pair.key] = pair.trial;
}

template <int dim> void Contact<dim>::follow_particles(const std::vector<long long>& ids)
{
  if (size_of(communicator) == 1)
    return;
  const std::unordered_set<long long> here(ids.begin(), ids.end());
  std::vector<ContactRecord> leaving;
  for (auto entry = history.begin(); entry != history.end();)
    if (here.count(entry->first.particle))
      ++entry;
    else
    {
      leaving.push_back(to_record(entry->first, entry->second));
      entry = history.erase(entry);
    }
  for (const ContactRecord& record : gather_everywhere(leaving, communicator))
    if (here.count(record.particle))
      enter(record);
}

template <int dim> ContactRecord Contact<dim>::to_record(const Key& key, const History& state)
{
  const Eigen::Vector3d& t = state.tangential;
  return {key.particle, key.corner, key.surface, {t[0], t[1], t[2]}, state.reference_gap, state.multiplier};
}

template <int dim> void Contact<dim>::enter(const ContactRecord& record)
{
  History& state = history[{record.particle, record.corner, record.surface}];
  state.tangential = Eigen::Map<const Eigen::Vector3d>(record.tangential);
  state.reference_gap = record.reference_gap;
  state.multiplier = record.multiplier;
}

template <int dim> std::vector<ContactRecord> Contact<dim>::export_history() const
{
  std::vector<ContactRecord> records;
  for (const auto& [key, state] : history)
    records.push_back(to_record(key, state));
  return records;
}

template <int dim>
void Contact<dim>::import_history(const std::vector<ContactRecord>& records, const std::vector<long long>& ids)
{
  history.clear();
  for (const ContactRecord& record : records)
    enter(record);
  follow_particles(ids);
}

template <int dim> std::map<long long, double> Contact<dim>::smallest_gaps(const RigidSystems& moved) const
{
  std::map<long long, double> gaps;
  for (const Pair& pair : pairs)
  {
    double gap = pair.gap;
    if (!std::isfinite(gap)) // evaluations look no farther than what may press
    {
      const WeldedSurface& welded = moved.surfaces[pair.key.surface];
      const Eigen::Vector3d x = moved.points[welded.point].pose.to_body(pair.position);
      if (const auto closest = welded.surface.closest_point_within(x, pair.size))
        gap = closest->gap;
    }
    const auto [entry, is_new] = gaps.emplace(pair.key.particle, gap);
    if (!is_new)
      entry->second = std::min(entry->second, gap);
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
      deepest = std::max(deepest, pair.committed.reference_gap - pair.gap);
  return max_over_ranks(deepest, communicator);
}

template class Contact<2>;
template class Contact<3>;
} // namespace kedge
