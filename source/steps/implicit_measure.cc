// How far an implicit step is from balance, and where.
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <kedge/assembly/force_sizes.h>
#include <kedge/base/communication.h>
#include <kedge/base/world_axes.h>
#include <kedge/steps/implicit_step.h>

namespace kedge
{
namespace
{
/// Stress below which a point counts as unstressed, over the one that the measure adds at every node.
constexpr double next_to_no_stress = 0.005;
/// How far a body is looked for, in cells.
constexpr double reach_in_cells = 3.;
/// Tolerances of the load on a body that may be unbalanced at the nodes that it loads.
constexpr double at_a_body = 10.;
/// Tolerances of the loads on all bodies that may be unbalanced at all nodes, as roots of sums of squares.
constexpr double everywhere = 40.;
/// How far a free body that soil carries, before and after, may go in a step, in cells at it. What goes farther has
/// left the solution that it followed for another one.
constexpr double farthest_in_contact = 0.75;
} // namespace

/// The present forces become what residuals are compared with.
template <int dim> void ImplicitStep<dim>::renew_force_measure()
{
  const NodalVector sizes = system().make_nodal_vector();
  Kokkos::deep_copy(sizes, given_sizes);
  add_internal_force_sizes<dim>(context.soil.particles().arrays(), basis.stencils, sizes);
  add_point_force_sizes(dim, acting_points, sizes);
  if (load.newmark.is_dynamic())
  {
    const NodalVector inertia = system().make_nodal_vector();
    add_inertia_force(equations->mass_graph(), equations->motion(), load.newmark, local_increment, inertia);
    add_force_sizes(dim, inertia, sizes);
  }
  TpetraVector owned(system().graph().row_map);
  system().collect(sizes, owned);
  force_measure.renew(owned);
  if (balance.magnitude.size() > 0) // else there is no free dof, or no evaluation yet
    body_scale = rigid_unknowns->scale(balance, forces_on_bodies(), body_levers);
}

/// Weight and load of each rigid point, N.
template <int dim> std::vector<double> ImplicitStep<dim>::forces_on_bodies() const
{
  const BodyLoads loads = body_loads();
  const double g = Eigen::Map<const Eigen::Vector3d>(context.gravity.data()).norm();
  std::vector<double> forces;
  for (std::size_t i = 0; i < context.bodies.points.size(); ++i)
    forces.push_back(context.bodies.points[i].mass * g + (loads.empty() ? 0. : loads[i].head<3>().norm()));
  return forces;
}

/// Why the solution found is not one: a body that the soil has carried leaps to another place. Empty if none does.
template <int dim> std::string ImplicitStep<dim>::refusal_of_leap() const
{
  if (rigid_unknowns->empty())
    return "";
  const BodyLoads loads = body_loads();
  const double cell = cell_size_at_surfaces(context.stage.cells, context.soil.mesh().layout().base_size);
  std::vector<double> distance(loads.size(), 0.); // from where the step began to look for balance, in cells
  if (!loads.empty())
  {
    const std::vector<double> apart = farthest_apart(context.bodies, body_increments, load.body_increments);
    for (std::size_t i = 0; i < loads.size(); ++i)
      distance[i] = loads[i].isZero() ? 0. : apart[i] / cell;
  }
  const auto leaps = [](const double cells) { return cells > farthest_in_contact; };
  if (std::none_of(distance.begin(), distance.end(), leaps)) // nearly always, and no rank need ask the others
    return "";
  const std::vector<bool> carried = context.soil.contact().points_that_press(context.bodies);
  for (std::size_t i = 0; i < distance.size(); ++i)
    if (carried[i] && leaps(distance[i]))
      return fmt::format("a free body that the soil carries moved by {:.2g} cells", distance[i]);
  return "";
}

/// Of a residual that was evaluated last.
template <int dim> double ImplicitStep<dim>::measure(const TpetraVector& r) const
{
  const bool by_weight = context.solver.measures_by_weight();
  const auto nodal = rigid_unknowns->nodal(r);
  double soil = by_weight ? nodal->norm2() : force_measure.of(*nodal);
  if (by_weight && soil > 0.) // there may be no soil, and no weight of it
    soil /= weight_norm;
  if (rigid_unknowns->empty())
    return soil;
  const double bodies = rigid_unknowns->measure(balance, body_scale);
  return std::isfinite(bodies) ? std::max(soil, bodies) : bodies;
}

/// Whether little is unbalanced compared with the loads on the bodies. The forces at all nodes are no measure for that
/// where they are large, as deep down: soil under a footing that has not moved yet would pass.
template <int dim> bool ImplicitStep<dim>::carries_bodies(const TpetraVector& r) const
{
  if (!context.stage.rigid_bodies)
    return true;
  const NodalVector sizes = system().make_nodal_vector();
  context.soil.contact().add_sizes(sizes);
  TpetraVector share(system().graph().row_map);
  system().collect(sizes, share);
  const auto nodal = rigid_unknowns->nodal(r);
  const double loads = share.norm2(), unbalanced = nodal->norm2();
  if (!(loads > 0.))
    return true;
  find_shares(dim, *nodal, share);
  const double tolerance = context.solver.force_tolerance;
  return unbalanced < everywhere * tolerance * loads &&
         context.soil.contact().unbalanced_share(system().spread(share)) < at_a_body * tolerance;
}

template <int dim> ResidualPlace ImplicitStep<dim>::find_residual()
{
  ResidualPlace place;
  TpetraVector r(increment->getMap());
  residual(*increment, r); // of the last iterate, not of a trial beyond it
  renew_force_measure();
  const MPI_Comm communicator = basis.nodes.communicator;
  const WorstNode worst = force_measure.worst(*rigid_unknowns->nodal(r));
  if (!(worst.share >= 0.))
    return place;
  place.share = worst.share;
  place.bodies_dominate = !rigid_unknowns->empty() &&
                          rigid_unknowns->measure(balance, body_scale) > force_measure.of(*rigid_unknowns->nodal(r));

  // Where the node is.
  std::array<double, dim + 1> known{};
  if (rank_of(communicator) == worst.rank)
  {
    const NodePlaces places = find_node_places();
    std::copy_n(places.position.begin() + dim * worst.node, dim, known.begin());
    known[dim] = places.spacing[worst.node];
  }
  MPI_Bcast(known.data(), dim + 1, MPI_DOUBLE, worst.rank, communicator);
  place.position.assign(known.begin(), known.begin() + dim);
  place.cell_size = known[dim];
  place.gap = INFINITY;
  for (const WeldedSurface& welded : context.bodies.surfaces)
  {
    const Pose pose = context.bodies.points[welded.point].pose.moved(body_increments[welded.point]);
    const Eigen::Vector3d x = pose.to_body(to_world<dim>(place.position));
    if (const auto closest = welded.surface.closest_point_within(x, reach_in_cells * place.cell_size))
      place.gap = std::min(place.gap, closest->gap);
  }

  // What is around it.
  const ParticleSet<dim>& particles = context.soil.particles();
  const ParticleArrays& arrays = particles.arrays();
  const std::vector<double> volume = download(arrays.initial_volume), plastic = download(arrays.trial_plastic);
  const auto stress = copy_to_host(arrays.trial_stress);
  const double least = next_to_no_stress * force_measure.least_stress();
  double filled = 0., points = 0., yielding = 0., unstressed = 0.;
  for (std::size_t p = 0; p < volume.size(); ++p)
  {
    bool near = true;
    for (unsigned int d = 0; d < dim; ++d)
      near = near && std::abs(particles.positions()[p][d] - place.position[d]) <= place.cell_size;
    if (!near)
      continue;
    double square = 0.;
    for (int i = 0; i < 6; ++i)
      square += stress(p, i) * stress(p, i);
    filled += volume[p];
    points += 1.;
    yielding += plastic[p] > 0.;
    unstressed += std::sqrt(square) < least;
  }
  const LeafTable<dim>& table = context.soil.mesh().leaves();
  double room = 1.;
  for (unsigned int d = 0; d < dim; ++d)
    room *= std::min(place.position[d] + place.cell_size, table.upper_end(d)) -
            std::max(place.position[d] - place.cell_size, table.lower_end(d));
  points = std::max(1., sum_over_ranks(points, communicator));
  place.filled = sum_over_ranks(filled, communicator) / room;
  place.yielding = sum_over_ranks(yielding, communicator) / points;
  place.unstressed = sum_over_ranks(unstressed, communicator) / points;
  return place;
}

#define KEDGE_INSTANTIATE(dim)                                                                                         \
  template void ImplicitStep<dim>::renew_force_measure();                                                              \
  template std::vector<double> ImplicitStep<dim>::forces_on_bodies() const;                                            \
  template bool ImplicitStep<dim>::carries_bodies(const TpetraVector&) const;                                          \
  template std::string ImplicitStep<dim>::refusal_of_leap() const;                                                     \
  template double ImplicitStep<dim>::measure(const TpetraVector&) const;                                               \
  template ResidualPlace ImplicitStep<dim>::find_residual();
KEDGE_INSTANTIATE(2)
KEDGE_INSTANTIATE(3)
} // namespace kedge
