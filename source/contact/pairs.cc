// Which corners may meet which surfaces in a step, where they hang on the nodes, and what their springs are like.
#include <algorithm>
#include <cmath>
#include <kedge/base/communication.h>
#include <kedge/base/world_axes.h>
#include <kedge/basis/active_nodes.h>
#include <kedge/contact/contact.h>
#include <limits>

namespace kedge
{
namespace
{
/// A corner takes its shape functions from the cell on its particle's side, also where it lies on a face of cells.
constexpr double nudge = 1e-6;
/// What a node holds of a corner is round-off below this share, at the face opposite to that where the corner lies: a
/// force that only such nodes would carry could grow without end.
constexpr double least_share = 1e-9;

/// Corners of a buried body's neighbours are bonded up to this distance, in sizes of the particle: whatever the
/// distance of the first row of particles from a face along the axes, one corner of each column lies nearer. Less than
/// a half by round-off: of two corners on either side of a face only one counts.
constexpr double bonding_distance = 0.5 - 1e-6;

/// How far from a surface a reference gap may wander, in sizes of the particle. Beyond, the box counts.
constexpr double farthest_reference = 0.25;
/// The same for corners off the surface that are not bonded and have not carried from farther off.
constexpr double hardly_off = 0.02;

std::vector<InterfaceParameters> interfaces_of(const RigidSystems& bodies, const ContactParameters& parameters)
{
  std::vector<InterfaceParameters> interfaces;
  for (const WeldedSurface& welded : bodies.surfaces)
    interfaces.push_back(welded.interface.or_else(parameters.interface));
  return interfaces;
}

/// What a corner stands for on a face of its particle, m2 (2-D: m).
template <int dim> double corner_area(const double size) { return dim == 3 ? 0.25 * size * size : 0.5 * size; }

/// Springs and limits of a corner that stands for its share of a face of its particle (size: m, young: Pa).
template <int dim>
ContactStiffness make_stiffness(const ContactParameters& parameters, const InterfaceParameters& interface,
                                const double size, const double young)
{
  const double unit = young / size * corner_area<dim>(size);
  return {parameters.normal_penalty_factor * unit, parameters.tangential_penalty_factor * unit,
          interface.friction_coefficient.value_or(0.), interface.adhesion.value_or(0.) * corner_area<dim>(size),
          interface.limit()};
}

/// The surfaces whose distance from x (m) is at most `radius` and their reach.
std::vector<unsigned int> surfaces_near(const RigidSystems& bodies, const Eigen::Vector3d& x, const double radius,
                                        const std::vector<double>& reach)
{
  std::vector<unsigned int> near;
  for (unsigned int s = 0; s < bodies.surfaces.size(); ++s)
  {
    const WeldedSurface& welded = bodies.surfaces[s];
    if (welded.surface.is_within(bodies.points[welded.point].pose.to_body(x), radius + reach[s]))
      near.push_back(s);
  }
  return near;
}

/// A particle and the surfaces that it may meet.
struct NearBodies
{
  std::size_t particle;
  std::vector<unsigned int> surfaces;
};

/// The particles that may meet a surface in the step.
template <int dim>
std::vector<NearBodies> find_near(const RigidSystems& bodies, const ContactParticles<dim>& particles,
                                  const std::vector<double>& reach)
{
  std::vector<NearBodies> found;
  for (std::size_t p = 0; p < particles.centre.size(); ++p)
  {
    // no corner is farther from the centre than the half-widths together; as much again is left for its own motion
    double radius = particles.travel[p];
    for (const double half : particles.half_width[p])
      radius += 2. * half;
    std::vector<unsigned int> near = surfaces_near(bodies, to_world<dim>(particles.centre[p]), radius, reach);
    if (!near.empty())
      found.push_back({p, std::move(near)});
  }
  return found;
}

/// The history of particles whose numbers are not among `ids`.
std::map<ContactKey, ContactHistory> history_of_others(const std::map<ContactKey, ContactHistory>& history,
                                                       const std::vector<long long>& ids)
{
  std::map<ContactKey, ContactHistory> others = history;
  std::vector<long long> remembered; // ascending
  for (const auto& entry : history)
    if (remembered.empty() || remembered.back() != entry.first.particle)
      remembered.push_back(entry.first.particle);
  for (const long long id : ids)
    if (std::binary_search(remembered.begin(), remembered.end(), id))
      others.erase(others.lower_bound({id, 0, 0}), others.lower_bound({id + 1, 0, 0}));
  return others;
}

/// Corner of a particle's domain; bit d of its number tells the side along axis d.
template <int dim>
std::array<double, dim> find_corner(const ContactParticles<dim>& particles, const std::size_t p,
                                    const unsigned int corner)
{
  std::array<double, dim> x;
  for (unsigned int d = 0; d < dim; ++d)
    x[d] = particles.centre[p][d] + ((corner >> d) & 1u ? 1. : -1.) * particles.half_width[p][d];
  return x;
}

template <int dim>
std::vector<SoilBox> boxes_of(const ContactParticles<dim>& particles, const std::vector<NearBodies>& near)
{
  std::vector<SoilBox> boxes;
  for (const NearBodies& one : near)
  {
    const Eigen::Vector3d x = to_world<dim>(particles.centre[one.particle]),
                          half = to_world<dim>(particles.half_width[one.particle]);
    boxes.push_back({{x[0], x[1], x[2]}, {half[0], half[1], half[2]}});
  }
  return boxes;
}

/// Nodes of points, as PointForces has them.
template <int dim> struct Hanging
{
  std::vector<unsigned int> begin{0}, nodes;
  std::vector<double> weights;
  std::vector<NodeShare<dim>> shares; ///< workspace
};

/// Adds a corner of a particle to the points, hung on the active nodes of the leaf on its particle's side. False where
/// there is no such node.
template <int dim>
bool add_corner(const LeafTable<dim>& table, const std::vector<unsigned int>& number,
                const std::array<double, dim>& centre, const std::array<double, dim>& corner, Hanging<dim>& points)
{
  std::array<double, dim> inside;
  for (unsigned int d = 0; d < dim; ++d)
    inside[d] =
        std::clamp(centre[d] + (corner[d] - centre[d]) * (1. - nudge), 0., table.base_size * table.base_cells[d]);
  const int leaf = table.find_leaf(inside);
  if (leaf < 0)
    return false;
  // shape functions of this leaf, but at the corner itself, so that moments balance too
  for (unsigned int d = 0; d < dim; ++d)
    inside[d] =
        std::clamp(corner[d], table.leaves[leaf].lower[d], table.leaves[leaf].lower[d] + table.leaves[leaf].size);
  std::vector<NodeShare<dim>>& shares = points.shares;
  shares.clear();
  add_leaf_shape<dim>(table, leaf, inside, 1., shares);
  // a sliver of the box may reach into a leaf without making all its nodes active
  shares.erase(std::remove_if(shares.begin(), shares.end(),
                              [&](const auto& share) {
                                return number[share.node] == ActiveNodes::inactive ||
                                       std::abs(share.value) < least_share;
                              }),
               shares.end());
  if (shares.empty())
    return false;
  double sum = 0.;
  for (const NodeShare<dim>& share : shares)
    sum += share.value;
  for (const NodeShare<dim>& share : shares)
  {
    points.nodes.push_back(number[share.node]);
    points.weights.push_back(share.value / sum);
  }
  points.begin.push_back(points.nodes.size());
  return true;
}
} // namespace

template <int dim> void Contact<dim>::settle(ContactPair& pair, const RigidSystems& bodies)
{
  const WeldedSurface& welded = bodies.surfaces[pair.key.surface];
  ContactHistory& state = pair.committed;
  const Eigen::Vector3d x = bodies.points[welded.point].pose.to_body(pair.start);
  const bool carries = state.pressure != 0. || state.bonded || state.memory.opening > 0.;
  const double first = state.reference_gap, limit = farthest_reference * pair.size;
  const auto closest = welded.surface.closest_point_within(x, carries ? std::numeric_limits<double>::max() : 0.);
  if (!closest)
    return;
  const double balancing =
      carries ? closest->gap + (state.pressure - state.multiplier) / pair.stiffness.normal - state.memory.opening
              : std::min(first, closest->gap);
  // A corner that its box has drawn off the surface hardly presses: at edges such ones would drag soil along. One that
  // the burial has put deep inside may go deeper, or the limit would let it go one way and not come back.
  const double margin = hardly_off * pair.size, in = std::max(limit, state.memory.farthest_in + margin);
  const double off = std::max(state.bonded ? limit : margin, state.memory.farthest_off);
  state.reference_gap = std::clamp(balancing, std::min(first, -in), std::max(first, off));
}

template <int dim> void Contact<dim>::make_room_for_pairs(const std::size_t most)
{
  if (most <= pairs.size())
    return;
  pairs = {};                                                         // its memory first
  pairs = SharedArray<ContactPair>("contact pairs", most + most / 4); // so that the next steps find room
  rests = SharedArray<ContactRest>("contact rests", pairs.size());
}

template <int dim>
void Contact<dim>::find_pairs(const RigidSystems& bodies, const LeafTable<dim>& table,
                              const ContactParticles<dim>& particles, const std::vector<unsigned int>& number,
                              const std::vector<double>& reach)
{
  waiting = history_of_others(history, particles.id);
  // what is found inside a body for the first time has come there with its box, between two steps
  const bool contact_goes_on = sum_over_ranks(static_cast<long long>(history.size()), communicator) > 0;
  const std::vector<InterfaceParameters> interfaces = interfaces_of(bodies, parameters);

  const std::vector<NearBodies> near_bodies = find_near(bodies, particles, reach);
  std::size_t most_pairs = 0;
  for (const NearBodies& near : near_bodies)
    most_pairs += near.surfaces.size() << dim;
  arrays = {};
  make_room_for_pairs(most_pairs);
  const auto host_pairs = pairs.overwrite_on_host();
  const auto host_rests = rests.overwrite_on_host();
  n_pairs = 0;
  Hanging<dim> points;
  std::vector<unsigned int> pair_begin;
  for (const auto& [p, surfaces] : near_bodies)
  {
    const double size = std::pow(particles.initial_volume[p], 1. / dim);
    for (unsigned int corner = 0; corner < (1u << dim); ++corner)
    {
      const std::array<double, dim> x = find_corner(particles, p, corner);
      const unsigned int point = points.begin.size() - 1;
      if (!add_corner<dim>(table, number, particles.centre[p], x, points))
        continue;
      // one point for the corner, one pair for each surface that it may touch
      pair_begin.push_back(n_pairs);
      for (const unsigned int s : surfaces)
      {
        ContactPair& pair = host_pairs(n_pairs) = ContactPair();
        pair.key = {particles.id[p], corner, s};
        pair.point = point;
        pair.start = to_world<dim>(x);
        pair.stiffness = make_stiffness<dim>(parameters, interfaces[s], size, particles.young[p]);
        pair.bonds = interfaces[s].bonded.value_or(false);
        pair.size = size;
        remember(pair, bodies, contact_goes_on);
        const Pose& pose = bodies.points[bodies.surfaces[s].point].pose;
        host_rests(n_pairs) = {s, false, false, (pair.start - pose.position).norm(), 0.};
        ++n_pairs;
      }
    }
  }
  pair_begin.push_back(n_pairs);
  boxes = boxes_of(particles, near_bodies);
  share_adhesion(bodies);

  arrays.pair_begin = upload(pair_begin, "pair begin");
  arrays.points.begin = upload(points.begin, "point begin");
  arrays.points.nodes = upload(points.nodes, "point nodes");
  arrays.points.weights = upload(points.weights, "point weights");
  make_room(arrays);
  nodal_increment = View<double*>();
  n_rigid_points = bodies.points.size();
  has_searched = true;
}

template <int dim>
void Contact<dim>::share_adhesion(const RigidSystems& bodies, const std::function<bool(const ContactPair&)>& carries)
{
  const std::vector<InterfaceParameters> interfaces = interfaces_of(bodies, parameters);
  const auto host = pairs.on_host();
  for (unsigned int s = 0; s < bodies.surfaces.size(); ++s)
  {
    const double adhesion = interfaces[s].adhesion.value_or(0.);
    if (adhesion == 0.)
      continue;
    std::vector<ContactPair*> carrying;
    std::vector<CarryingCorner> corners;
    for (std::size_t k = 0; k < n_pairs; ++k)
      if (ContactPair& pair = host(k); pair.key.surface == s)
      {
        const double weight = corner_area<dim>(pair.size);
        pair.stiffness.adhesion = adhesion * weight; // what touches only from now on keeps the share of a face
        if (!carries(pair))
          continue;
        carrying.push_back(&pair);
        corners.push_back({{pair.start[0], pair.start[1], pair.start[2]}, pair.size, weight});
      }
    const std::vector<double> area = share_area(bodies, bodies.surfaces[s], corners, boxes, dim, communicator);
    for (std::size_t i = 0; i < carrying.size(); ++i)
      carrying[i]->stiffness.adhesion = adhesion * area[i];
  }
}

template <int dim> void Contact<dim>::share_adhesion(const RigidSystems& bodies)
{
  share_adhesion(bodies, [](const ContactPair& pair) { return pair.committed.pressure > 0. || pair.committed.bonded; });
}

template <int dim>
void Contact<dim>::remember(ContactPair& pair, const RigidSystems& bodies, const bool contact_goes_on) const
{
  const auto entry = history.find(pair.key);
  if (entry != history.end())
    pair.committed = entry->second;
  if (entry != history.end() || contact_goes_on)
    settle(pair, bodies);
  pair.trial = pair.augmented = pair.committed;
  pair.approach = pair.approach_begin = pair.committed.memory.approach;
}

template <int dim> void Contact<dim>::take_reference_gaps(const RigidSystems& bodies)
{
  wake_all();
  history.clear(); // what cells were fitted for held soil that the bodies have replaced
  const auto host = pairs.on_host();
  for (std::size_t k = 0; k < n_pairs; ++k)
  {
    ContactPair& pair = host(k);
    pair.committed = pair.trial = pair.augmented = ContactHistory();
    pair.approach = pair.approach_begin = BodyApproach();
    const WeldedSurface& welded = bodies.surfaces[pair.key.surface];
    const Eigen::Vector3d x = bodies.points[welded.point].pose.to_body(pair.start);
    const auto closest = welded.surface.closest_point_within(x, pair.bonds ? bonding_distance * pair.size : 0.);
    if (!closest || !(closest->gap < 0. || pair.bonds))
      continue;
    pair.committed.reference_gap = closest->gap;
    pair.committed.memory = begins_at(closest->gap);
    pair.committed.bonded = pair.bonds;
    pair.trial = pair.augmented = pair.committed;
    history[pair.key] = pair.committed;
  }
  share_adhesion(bodies);
}

#define KEDGE_INSTANTIATE(dim)                                                                                         \
  template void Contact<dim>::find_pairs(const RigidSystems&, const LeafTable<dim>&, const ContactParticles<dim>&,     \
                                         const std::vector<unsigned int>&, const std::vector<double>&);                \
  template void Contact<dim>::take_reference_gaps(const RigidSystems&);                                                \
  template void Contact<dim>::share_adhesion(const RigidSystems&, const std::function<bool(const ContactPair&)>&);     \
  template void Contact<dim>::share_adhesion(const RigidSystems&);
KEDGE_INSTANTIATE(2)
KEDGE_INSTANTIATE(3)
} // namespace kedge
