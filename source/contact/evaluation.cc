// Contact of given motions of soil and bodies, and what it leaves behind. Kernels of contact_forces do the work.
#include <algorithm>
#include <cmath>
#include <kedge/base/communication.h>
#include <kedge/contact/contact.h>
#include <limits>

namespace kedge
{
template <int dim>
Contact<dim>::Contact(const ContactParameters& parameters_, const MPI_Comm communicator_)
    : parameters(parameters_), communicator(communicator_)
{
}

template <int dim> void Contact<dim>::wake_all()
{
  const auto host = rests.on_host();
  for (std::size_t k = 0; k < n_pairs; ++k)
    host(k).asleep = false;
}

template <int dim> ContactArrays& Contact<dim>::on_device()
{
  arrays.pairs = pairs.on_device();
  arrays.rests = rests.on_device();
  return arrays;
}

template <int dim> ContactArrays Contact<dim>::arrays_of_last_evaluation() const
{
  ContactArrays result = arrays;
  result.pairs = pairs.read_on_device();
  result.rests = rests.read_on_device();
  return result;
}

template <int dim>
SurfaceMotions Contact<dim>::find_motions(const RigidSystems& committed, const std::vector<Vector6>& increments) const
{
  std::vector<SurfaceMotion> result;
  for (const WeldedSurface& welded : committed.surfaces)
  {
    const Pose& before = committed.points[welded.point].pose;
    const Pose now = before.moved(increments[welded.point]);
    const double angle = before.rotation.angularDistance(now.rotation);
    result.push_back({welded.surface.for_kernels(n_pairs), before.frame(), now.frame(),
                      (now.position - before.position).norm(), 2. * std::sin(0.5 * angle), welded.point});
  }
  return upload(result, "motions of surfaces");
}

template <int dim>
const PointForces& Contact<dim>::evaluate(const RigidSystems& committed, const std::vector<Vector6>& increments,
                                          const View<double*>& increment)
{
  if (nodal_increment.extent(0) != increment.extent(0))
    nodal_increment = View<double*>(Kokkos::view_alloc("increment", Kokkos::WithoutInitializing), increment.extent(0));
  Kokkos::deep_copy(nodal_increment, increment);
  motions = find_motions(committed, increments);
  evaluate_contact(dim, on_device(), motions, nodal_increment, keeps_multipliers());
  return arrays.points;
}

template <int dim> void Contact<dim>::reset_multipliers() { kedge::reset_multipliers(on_device(), n_pairs); }

template <int dim> void Contact<dim>::augment(const double factor) { kedge::augment(on_device(), n_pairs, factor); }

template <int dim> void Contact<dim>::follow_path() { kedge::follow_path(on_device(), n_pairs); }

template <int dim> double Contact<dim>::excess() const
{
  const double here = keeps_multipliers() ? largest_excess(arrays_of_last_evaluation()) : 0.;
  return max_over_ranks(here / parameters.penetration_tolerance, communicator);
}

template <int dim> BodyLoads Contact<dim>::loads() const
{
  BodyLoads result = contact_loads(arrays_of_last_evaluation(), motions, n_rigid_points);
  if (!result.empty())
    MPI_Allreduce(MPI_IN_PLACE, result.data(), 6 * result.size(), MPI_DOUBLE, MPI_SUM, communicator);
  return result;
}

template <int dim> void Contact<dim>::add_sizes(const View<double*>& sizes) const
{
  add_contact_sizes(dim, arrays_of_last_evaluation(), motions, sizes);
}

template <int dim> double Contact<dim>::unbalanced_share(const View<double*>& share) const
{
  auto sums = contact_balance(dim, arrays_of_last_evaluation(), motions, share, n_rigid_points);
  if (!sums.empty())
    MPI_Allreduce(MPI_IN_PLACE, sums.data(), 2 * sums.size(), MPI_DOUBLE, MPI_SUM, communicator);
  double largest = 0.;
  for (const auto& [size, unbalanced] : sums)
    if (unbalanced > 0.)
      largest = std::max(largest, unbalanced / size);
  return largest;
}

template <int dim> BodyTangents Contact<dim>::load_tangents() const
{
  BodyTangents result = contact_load_tangents(arrays_of_last_evaluation(), motions, n_rigid_points);
  if (!result.empty())
    MPI_Allreduce(MPI_IN_PLACE, result.data(), 36 * result.size(), MPI_DOUBLE, MPI_SUM, communicator);
  return result;
}

template <int dim> std::unordered_map<long long, double> Contact<dim>::smallest_gaps(const RigidSystems& moved) const
{
  const auto host = pairs.read_on_host();
  struct
  {
    HostView<unsigned int*> begin, nodes;
    HostView<double*> weights;
  } const points{copy_to_host(arrays.points.begin), copy_to_host(arrays.points.nodes),
                 copy_to_host(arrays.points.weights)};
  const auto increment = copy_to_host(nodal_increment);
  std::unordered_map<long long, double> gaps;
  auto of_particle = gaps.end();
  for (std::size_t k = 0; k < n_pairs; ++k)
  {
    const ContactPair& pair = host(k);
    if (of_particle == gaps.end() || of_particle->first != pair.key.particle) // its pairs follow one another
      of_particle = gaps.emplace(pair.key.particle, std::numeric_limits<double>::infinity()).first;
    double& smallest = of_particle->second;
    double gap = pair.gap;
    if (!std::isfinite(gap) && smallest > 0.) // evaluations look no farther than what may press
    {
      const WeldedSurface& welded = moved.surfaces[pair.key.surface];
      const Eigen::Vector3d x = moved.points[welded.point].pose.to_body(
          increment.extent(0) == 0 ? pair.start : pair.start + point_displacement<dim>(points, increment, pair.point));
      KnownDistance known = pair.known;
      if (const auto closest = welded.surface.closest_point_within(x, std::min(pair.size, smallest), known))
        gap = closest->gap;
    }
    smallest = std::min(smallest, gap);
  }
  return gaps;
}

template <int dim> auto Contact<dim>::touches() const -> std::vector<Touch>
{
  const auto host = pairs.read_on_host();
  std::vector<Touch> result;
  for (std::size_t k = 0; k < n_pairs; ++k)
    if (host(k).active)
      result.push_back({host(k).position, host(k).force, host(k).key.surface});
  return result;
}

template <int dim> long long Contact<dim>::n_active() const
{
  return sum_over_ranks(count_active(arrays_of_last_evaluation()), communicator);
}

template <int dim> double Contact<dim>::deepest_penetration() const
{
  return max_over_ranks(kedge::deepest_penetration(arrays_of_last_evaluation()), communicator);
}

template <int dim> double Contact<dim>::largest_compression() const
{
  return max_over_ranks(kedge::largest_compression(arrays_of_last_evaluation()), communicator);
}

template class Contact<2>;
template class Contact<3>;
} // namespace kedge
