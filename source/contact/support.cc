// What bodies carry that have taken the place of soil.
#include <algorithm>
#include <kedge/base/world_axes.h>
#include <kedge/contact/contact.h>

namespace kedge
{
namespace
{
constexpr unsigned int n_sweeps = 100;          ///< so many on any number of ranks
constexpr double support_distance = 0.5 - 1e-6; ///< in sizes of the particle: of two corners on either side one carries

/// The nearest force that the contact law allows: pressure, and along the surface no more than it can hold.
Eigen::Vector3d admissible(const Eigen::Vector3d& force, const Eigen::Vector3d& normal,
                           const ContactStiffness& stiffness, const bool bonded)
{
  const double pressure = bonded ? force.dot(normal) : std::max(0., force.dot(normal));
  const Eigen::Vector3d along = force - force.dot(normal) * normal;
  const double limit = pressure > 0. || bonded ? slip_limit(stiffness, pressure, bonded).force : 0.,
               size = along.norm();
  return pressure * normal + (size > limit ? limit / size : 1.) * along;
}
} // namespace

/// Each sweep hands what is missing at a node to its corners in equal shares per weight (Landweber's iteration; the
/// sums of the rows of weights bound its step). Forces start from zero, so that of all that balance they are small.
template <int dim>
void Contact<dim>::replace_support(const RigidSystems& bodies, std::vector<double> missing,
                                   const std::function<void(std::vector<double>&)>& sum)
{
  wake_all();
  const auto find_closest = [&](const ContactPair& pair)
  {
    const WeldedSurface& welded = bodies.surfaces[pair.key.surface];
    const Pose& pose = bodies.points[welded.point].pose;
    return welded.surface.closest_point_within(pose.to_body(pair.start), support_distance * pair.size);
  };
  share_adhesion(bodies, [&](const ContactPair& pair) { return find_closest(pair).has_value(); }); // what they may hold
  struct Carrier
  {
    ContactPair* pair;
    double gap;
    Eigen::Vector3d normal, force;
  };
  const auto host = pairs.on_host();
  const auto begin = copy_to_host(arrays.points.begin), nodes = copy_to_host(arrays.points.nodes);
  const auto weights = copy_to_host(arrays.points.weights);
  std::vector<Carrier> carriers;
  std::vector<double> weight(missing.size(), 0.);
  const auto for_each_dof = [&](const Carrier& carrier, const auto& visit)
  {
    for (unsigned int v = begin(carrier.pair->point); v < begin(carrier.pair->point + 1); ++v)
      for (unsigned int d = 0; d < dim; ++d)
        visit(dim * nodes(v) + d, world_axis(dim, d), weights(v));
  };
  for (std::size_t k = 0; k < n_pairs; ++k)
  {
    ContactPair& pair = host(k);
    const auto closest = find_closest(pair);
    if (!closest)
      continue;
    const Pose& pose = bodies.points[bodies.surfaces[pair.key.surface].point].pose;
    carriers.push_back({&pair, closest->gap, pose.direction_to_world(closest->normal), Eigen::Vector3d::Zero()});
    for_each_dof(carriers.back(), [&](const std::size_t dof, unsigned int, const double w) { weight[dof] += w; });
  }
  sum(weight);
  for (std::size_t i = 0; i < missing.size(); ++i)
    if (weight[i] == 0.)
      missing[i] = 0.; // no corner reaches this node

  std::vector<double> left = missing;
  for (unsigned int sweep = 0; sweep < n_sweeps; ++sweep)
  {
    std::vector<double> carried(missing.size(), 0.);
    for (Carrier& carrier : carriers)
    {
      Eigen::Vector3d force = carrier.force;
      for_each_dof(carrier, [&](const std::size_t dof, const unsigned int axis, const double w)
                   { force[axis] += weight[dof] > 0. ? w * left[dof] / weight[dof] : 0.; });
      carrier.force = admissible(force, carrier.normal, carrier.pair->stiffness, carrier.pair->committed.bonded);
      for_each_dof(carrier, [&](const std::size_t dof, const unsigned int axis, const double w)
                   { carried[dof] += w * carrier.force[axis]; });
    }
    sum(carried);
    for (std::size_t i = 0; i < left.size(); ++i)
      left[i] = weight[i] > 0. ? missing[i] - carried[i] : 0.;
  }

  for (const Carrier& carrier : carriers)
  {
    ContactPair& pair = *carrier.pair;
    ContactHistory& state = pair.committed;
    state.pressure = carrier.force.dot(carrier.normal);
    state.tangential = carrier.force - state.pressure * carrier.normal;
    if (state.pressure == 0. && !state.bonded)
      continue;
    if (parameters.method == ContactMethod::augmented_lagrangian && !state.bonded)
      state.multiplier = state.pressure;
    state.reference_gap = carrier.gap + (state.pressure - state.multiplier) / pair.stiffness.normal;
    state.memory = begins_at(state.reference_gap);
    pair.trial = pair.augmented = state;
    history[pair.key] = state;
  }
  share_adhesion(bodies);
}

template void Contact<2>::replace_support(const RigidSystems&, std::vector<double>,
                                          const std::function<void(std::vector<double>&)>&);
template void Contact<3>::replace_support(const RigidSystems&, std::vector<double>,
                                          const std::function<void(std::vector<double>&)>&);
} // namespace kedge
