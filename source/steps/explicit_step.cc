#include <KokkosBlas1_axpby.hpp>
#include <cmath>
#include <fmt/format.h>
#include <kedge/assembly/acting_points.h>
#include <kedge/assembly/inertia.h>
#include <kedge/base/communication.h>
#include <kedge/steps/explicit_step.h>
#include <kedge/steps/wished_in_place.h>
#include <limits>

namespace kedge
{
namespace
{
/// Beyond this the basis of the step's start no longer describes where a material point is.
constexpr double most_cells_per_step = 0.75;

/// Share of the velocities that no node sees which a time step takes away, and at most a basis step: so the basis step
/// does not decide how fast they fade where it is short.
constexpr double noise_taken = 1e-3, most_noise_taken = 0.1;

/// A node this much slower than what its force adds to its velocity in a time step counts as at rest.
constexpr double at_rest = 1e-3;

using Policy = Kokkos::RangePolicy<ExecutionSpace>;
using ParticleVectors = View<double* [3]>;

// Kernels have functions of their own, for nvcc refuses them in private ones of a class.

/// nodal = factor nodal / inertia
void divide(const NodalVector& nodal, const double factor, const NodalVector& inertia)
{
  Kokkos::parallel_for(
      "project", Policy(0, nodal.extent(0)),
      KOKKOS_LAMBDA(const std::size_t i) { nodal(i) = factor * nodal(i) / inertia(i); });
}

/// nodal = nodal / mass, the mass being that of nodes; 0 where there is none, and at dofs of infinite inertia if that
/// is given.
template <int dim> void find_means(const NodalVector& nodal, const View<double*>& mass, const NodalVector& inertia = {})
{
  Kokkos::parallel_for(
      "means", Policy(0, mass.extent(0)), KOKKOS_LAMBDA(const std::size_t v) {
        for (int d = 0; d < dim; ++d)
        {
          const bool held = inertia.extent(0) > 0 && std::isinf(inertia(dim * v + d));
          nodal(dim * v + d) = mass(v) > 0. && !held ? nodal(dim * v + d) / mass(v) : 0.;
        }
      });
}

/// Lets forces act on velocities for a time. Local damping opposes every velocity by a share of the force on it
/// (Cundall 1987), less where the velocity is next to nothing: round-off must not choose its side.
void kick_nodes(const NodalVector& velocity, const NodalVector& force, const NodalVector& inertia, const double time,
                const double damping)
{
  Kokkos::parallel_for(
      "kick", Policy(0, force.extent(0)), KOKKOS_LAMBDA(const std::size_t i) {
        const double change = time / inertia(i) * force(i), speed = std::fabs(velocity(i));
        const double direction = speed > 0. ? velocity(i) / std::fmax(speed, at_rest * std::fabs(change)) : 0.;
        velocity(i) += change - damping * std::fabs(change) * direction;
      });
}
} // namespace

template <int dim>
ExplicitStep<dim>::ExplicitStep(const StepContext<dim>& context_)
    : context(context_),
      basis(make_step_basis(context, {}, false)),
      exchange(dim, numbering_of(basis.nodes)),
      node_exchange(1, numbering_of(basis.nodes))
{
  if (context.stage.rigid_bodies)
  {
    RigidStep whole = rigid_step();
    whole.dt = step_length(context.stage.stepping);
    find_contact_pairs(context, basis.nodes, whole);
    if (context.replaces_soil)
      replace_soil(context, basis);
  }

  lump_mass();
  const auto scope = context.timings.measure("stable step");
  stable = find_stable_step(context, basis, {exchange, node_exchange, mass, inertia});
}

/// Finds mass, inertia and weight of the nodes.
template <int dim> void ExplicitStep<dim>::lump_mass()
{
  const auto scope = context.timings.measure("lumped mass");
  const ParticleArrays& particles = context.soil.particles().arrays();
  const double share = least_share(context.basis), scaling = context.stage.stepping.mass_scaling;
  weight = exchange.make_nodal_vector();
  add_weight<dim>(particles, basis.stencils, context.gravity, 1., weight);
  exchange.sum_over_ranks(weight);

  mass = View<double*>("lumped mass", basis.nodes.n_local());
  add_lumped_mass(particles, basis.stencils, share, mass);
  node_exchange.sum_over_ranks(mass);
  const auto host_mass = copy_to_host(mass);
  inertia = exchange.make_nodal_vector();
  const auto host_inertia = make_mirror(inertia);
  const std::vector<unsigned char> held = find_constrained_dofs(context, basis.nodes);
  for (std::size_t v = 0; v < host_mass.extent(0); ++v)
  {
    host_mass(v) *= scaling;
    for (std::size_t i = dim * v; i < dim * (v + 1); ++i)
      host_inertia(i) = held[i] || !(host_mass(v) > 0.) ? std::numeric_limits<double>::infinity() : host_mass(v);
  }
  Kokkos::deep_copy(mass, host_mass);
  Kokkos::deep_copy(inertia, host_inertia);
}

template <int dim> double ExplicitStep<dim>::duration() const
{
  return load.step_fraction * step_length(context.stage.stepping);
}

template <int dim> Eigen::Vector3d ExplicitStep<dim>::gravity() const
{
  return load.gravity_factor * to_world_axes(context.gravity, dim);
}

/// Without a dt, for the inertia of a step is the mean of many small ones.
template <int dim> RigidStep ExplicitStep<dim>::rigid_step() const
{
  RigidStep step;
  step.gravity = gravity();
  step.fraction = load.step_fraction;
  return step;
}

template <int dim> NewtonReport ExplicitStep<dim>::solve(const StepLoad& load_)
{
  const auto scope = context.timings.measure("time steps");
  load = load_;
  const SteppingParameters& stepping = context.stage.stepping;
  const double longest = stepping.dt > 0. ? std::min(stepping.dt, stable.all) : stepping.cfl * stable.all;
  n_time_steps = std::max(1., std::ceil(duration() / longest * (1. - 1e-9)));
  begin();

  NewtonReport report;
  const double dt = duration() / n_time_steps;
  impulse.assign(context.bodies.points.size(), Vector6::Zero());
  bool admissible = follow_forces(load.start_time);
  kick(0.5 * dt);
  for (unsigned int k = 1; k <= n_time_steps && admissible && report.failure.empty(); ++k)
  {
    drift(dt);
    if (motion)
      report.failure = motion->drift(gravity(), load.step_fraction / n_time_steps, dt);
    admissible = follow_forces(load.start_time + k * dt);
    kick(k == n_time_steps ? 0.5 * dt : dt);
    ++report.iterations;
  }
  if (!report.failure.empty())
    return report;
  if (!admissible)
    report.failure = "a material point turned inside out";
  else if (const double distance = largest_distance_in_cells(); distance > most_cells_per_step)
    report.failure = fmt::format("a material point moved by {:.2g} of a cell", distance);
  report.converged = report.failure.empty();
  return report;
}

/// Sum over the particles of their mass times a quantity, over the mass of the nodes; zero at held dofs.
template <int dim> NodalVector ExplicitStep<dim>::project(const ParticleVectors& quantity) const
{
  const NodalVector nodal = exchange.make_nodal_vector();
  add_particle_momentum(context.soil.particles().arrays(), basis.stencils, quantity, nodal);
  exchange.sum_over_ranks(nodal);
  divide(nodal, context.stage.stepping.mass_scaling, inertia);
  return nodal;
}

template <int dim> void ExplicitStep<dim>::begin()
{
  const ParticleArrays& particles = context.soil.particles().arrays();
  start_velocity = project(particles.velocity);
  velocity = exchange.make_nodal_vector();
  increment = exchange.make_nodal_vector();
  force = exchange.make_nodal_vector();
  Kokkos::deep_copy(velocity, start_velocity);
  path = begin_path(particles, dim, basis.nodes.n_local());
  motion.reset();
  context.soil.contact().reset_multipliers(); // after a cut
  if (context.stage.rigid_bodies)
    motion.emplace(context.bodies, load.begins_stage);
}

/// At the material points' positions at the start of the step.
template <int dim> void ExplicitStep<dim>::find_body_force(const double time)
{
  if (context.body_force == nullptr || (has_body_force && !context.body_force->depends_on_time()))
    return;
  has_body_force = true; // on ranks without nodes, too: all of them ask, or none
  const ParticleSet<dim>& particles = context.soil.particles();
  body_force = exchange.make_nodal_vector();
  add_particle_momentum(particles.arrays(), basis.stencils,
                        context.body_force->evaluate(particles, time, basis.nodes.communicator), body_force);
  exchange.sum_over_ranks(body_force);
}

/// Unbalanced forces and trial state at the present increment and a time of the stage (s); false where the increment is
/// not admissible.
template <int dim> bool ExplicitStep<dim>::follow_forces(const double time)
{
  find_body_force(time);
  Kokkos::deep_copy(force, 0.);
  const unsigned long inverted = advance_stress_and_force<dim>(
      context.soil.particles().arrays(), basis.stencils, context.soil.materials(), increment, path, force, basis.cells);
  if (motion)
  {
    body_increments = motion->increments();
    add_point_forces(dim, context.soil.contact().evaluate(context.bodies, body_increments, increment), -1., force);
    context.soil.contact().follow_path();
  }
  else
    body_increments.assign(context.bodies.points.size(), Vector6::Zero());
  exchange.sum_over_ranks(force);
  KokkosBlas::axpby(load.gravity_factor, weight, -1., force);
  if (has_body_force)
    KokkosBlas::axpy(1., body_force, force);
  return sum_over_ranks(static_cast<long long>(inverted), basis.nodes.communicator) == 0;
}

/// Lets the unbalanced forces act for a time.
template <int dim> void ExplicitStep<dim>::kick(const double time)
{
  kick_nodes(velocity, force, inertia, time, context.stage.stepping.damping);
  if (!motion)
    return;
  const BodyLoads now = context.soil.contact().loads();
  for (std::size_t i = 0; i < now.size(); ++i)
    impulse[i] += time * now[i];
  motion->kick(now, time);
}

template <int dim> void ExplicitStep<dim>::drift(const double time) { KokkosBlas::axpy(time, velocity, increment); }

template <int dim> double ExplicitStep<dim>::largest_distance_in_cells() const
{
  const View<double* [3]> displacement = interpolate_to_particles(basis.stencils, increment);
  const auto host = copy_to_host(displacement);
  const LeafTable<dim>& table = context.soil.mesh().leaves();
  double largest = 0.;
  for (std::size_t p = 0; p < host.extent(0); ++p)
    for (unsigned int d = 0; d < dim; ++d)
      largest = std::max(largest, std::abs(host(p, d)) / table.leaves[context.soil.particles().leaves()[p]].size);
  return max_over_ranks(largest, basis.nodes.communicator);
}

/// At the start of the step.
template <int dim> NodalPlaces ExplicitStep<dim>::find_places() const
{
  const ParticleSet<dim>& particles = context.soil.particles();
  NodalPlaces places{exchange.make_nodal_vector(), exchange.make_nodal_vector(),
                     View<double*>("mass", basis.nodes.n_local()), inertia,
                     ParticleVectors("position", basis.stencils.n_particles)};
  const auto position = make_mirror(places.particles);
  for (std::size_t p = 0; p < position.extent(0); ++p)
    for (unsigned int d = 0; d < dim; ++d)
      position(p, d) = particles.positions()[p][d];
  Kokkos::deep_copy(places.particles, position);
  const auto node = make_mirror(places.node);
  for (std::size_t v = 0; v < basis.nodes.mesh_node.size(); ++v)
    for (unsigned int d = 0; d < dim; ++d)
      node(dim * v + d) = context.soil.mesh().leaves().node_position[basis.nodes.mesh_node[v]][d];
  Kokkos::deep_copy(places.node, node);
  // plain sums: the mass of the dynamics may be scaled, and has a least share where the basis is linear
  add_lumped_mass(particles.arrays(), basis.stencils, 0., places.mass);
  node_exchange.sum_over_ranks(places.mass);
  add_particle_momentum(particles.arrays(), basis.stencils, places.particles, places.centre);
  exchange.sum_over_ranks(places.centre);
  find_means<dim>(places.centre, places.mass);
  return places;
}

/// What of the particles' velocities v at the start no node sees: Q* Q v with Q = 1 - R P, where P projects to the
/// nodes and R back (unseen_velocity.h), and Q* is its transpose for the mass of the particles. Q leaves nothing of
/// motion that is linear in space, so where nothing is held, taking a share of this away keeps momentum and spin; and
/// it only ever takes energy.
template <int dim>
View<double* [3]> ExplicitStep<dim>::unseen_velocity() const {
  const ParticleArrays& particles = context.soil.particles().arrays();
  const NodalPlaces places = find_places();
  const ParticleVectors unseen("unseen velocity", basis.stencils.n_particles);
  Kokkos::deep_copy(unseen, particles.velocity);
  const NodalVector mean = exchange.make_nodal_vector(), seen = exchange.make_nodal_vector();
  add_particle_momentum(particles, basis.stencils, unseen, mean);
  exchange.sum_over_ranks(mean);
  find_means<dim>(mean, places.mass, inertia);
  take_seen_part<dim>(basis.stencils, places, mean, unseen);
  add_seen_part<dim>(particles, basis.stencils, places, unseen, seen);
  exchange.sum_over_ranks(seen);
  find_means<dim>(seen, places.mass, inertia);
  KokkosBlas::axpy(-1., interpolate_to_particles(basis.stencils, seen), unseen);
  return unseen;
}

template <int dim>
SoilIncrements ExplicitStep<dim>::soil_increments() const
{
  ParticleIncrements increments =
      interpolate_increments<dim>(context.soil.particles().arrays(), basis.stencils, increment, basis.cells);
  const NodalVector change = exchange.make_nodal_vector();
  Kokkos::deep_copy(change, velocity);
  KokkosBlas::axpy(-1., start_velocity, change);
  const ParticleVectors gained = interpolate_to_particles(basis.stencils, change), unseen = unseen_velocity();
  const ParticleVectors acceleration("acceleration", basis.stencils.n_particles); // the mean of the step
  KokkosBlas::axpby(1. / duration(), gained, 0., acceleration);
  const double taken = std::min(most_noise_taken, noise_taken * n_time_steps);
  Kokkos::parallel_for(
      "damp noise", Policy(0, gained.extent(0)), KOKKOS_LAMBDA(const std::size_t p) {
        for (int d = 0; d < dim; ++d)
          gained(p, d) -= taken * unseen(p, d);
      });
  increments.motion = ParticleMotion{gained, acceleration};
  return {increments, {}};
}

template <int dim> std::vector<Vector6> ExplicitStep<dim>::reactions() const
{
  BodyLoads mean = impulse;
  for (Vector6& body_load : mean)
    body_load /= duration();
  if (motion)
  {
    const std::vector<Vector6> rates = motion->momentum_rates();
    for (std::size_t i = 0; i < mean.size(); ++i)
      mean[i] -= rates[i];
  }
  return find_reactions(context, rigid_step(), body_increments, mean);
}

template <int dim> void ExplicitStep<dim>::move_bodies(RigidSystems& committed) const
{
  if (motion)
    motion->commit(committed, load.step_fraction);
  else
    commit_increments(committed, RigidStep(), body_increments);
}

template class ExplicitStep<2>;
template class ExplicitStep<3>;
} // namespace kedge
