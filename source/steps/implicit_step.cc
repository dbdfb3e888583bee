#include <KokkosBlas1_axpby.hpp>
#include <KokkosBlas1_scal.hpp>
#include <cmath>
#include <kedge/assembly/force_sizes.h>
#include <kedge/assembly/volume_average.h>
#include <kedge/base/communication.h>
#include <kedge/base/exceptions.h>
#include <kedge/steps/implicit_step.h>
#include <kedge/steps/wished_in_place.h>

namespace kedge
{
namespace
{
constexpr unsigned int max_augmentations = 20;

/// Share of the measure at rest in a step before, below which a guess is taken without a look at rest, and what is kept
/// of that measure from step to step. Where bodies move on, guesses leave 7e-2 to 3e-4 of it.
constexpr double much_better = 0.1, kept_of_rest = 0.8;

/// Measure below which a dynamic step does without any correction. What it leaves unbalanced is lost to the steps after
/// it: a small force that each of them may neglect would never move anything. So only round-off may be left.
constexpr double at_rest_in_motion = 1e-10;

/// Of the momentum over the time step: what counts as a force where no other acts, as in soil that drifts, and what is
/// round-off, of which the tolerance must not ask less.
constexpr double far_above_round_off = 1e-10, round_off = 1e-14;

/// One solution after another of the same step.
void append(NewtonReport& report, const NewtonReport& next)
{
  report.converged = next.converged;
  report.failure = next.failure;
  report.iterations += next.iterations;
  report.krylov_iterations += next.krylov_iterations;
  report.escalations += next.escalations;
  report.residuals.insert(report.residuals.end(), next.residuals.begin(), next.residuals.end());
}

/// Uzawa's step over the springs' stiffness. Where inertia or soil is stiffer than the springs by far, as in short time
/// steps, multipliers grow too slowly with a step of one.
double next_augmentation(const double factor, const double left)
{
  return left > 1. ? std::max(1., 0.25 * factor) : left > 0.5 ? 2. * factor : factor;
}

/// By particle, in the first component: g and the larger of two accelerations. A function of its own, for nvcc refuses
/// kernels in private ones of a class.
template <int dim>
View<double* [3]> sizes_of_accelerations(const double g, const View<double* [3]>& first, const View<double* [3]>& last)
{
  const View<double* [3]> size("size of forces", first.extent(0));
  Kokkos::parallel_for(
      "size of forces", Kokkos::RangePolicy<ExecutionSpace>(0, size.extent(0)), KOKKOS_LAMBDA(const std::size_t p) {
        double before = 0., after = 0.;
        for (int d = 0; d < dim; ++d)
        {
          before += first(p, d) * first(p, d);
          after += last(p, d) * last(p, d);
        }
        size(p, 0) = g + std::sqrt(std::fmax(before, after));
      });
  return size;
}
} // namespace

template <int dim>
ImplicitStep<dim>::ImplicitStep(const StepContext<dim>& context_)
    : context(context_),
      basis(make_step_basis(context, ghost_factors(context.solver), true)),
      linear_solver(context_.solver, dim)
{
  if (context.stage.rigid_bodies)
    find_contact_pairs(context, basis.nodes, rigid_step());
  if (context.replaces_soil)
    replace_soil(context, basis);

  const auto scope = context.timings.measure("sparsity");
  set_up_equations();
  rigid_unknowns =
      std::make_unique<RigidUnknowns>(context.bodies, context.stage.rigid_bodies, system().graph().row_map);
  weigh_bodies();
  increment = Teuchos::rcp(new TpetraVector(rigid_unknowns->map()));
  full_weight = system().make_nodal_vector();
  add_weight<dim>(context.soil.particles().arrays(), basis.stencils, context.gravity, 1., full_weight);
  weight_norm = norm_of(full_weight);
  given_sizes = system().make_nodal_vector();
  momentum_sizes = system().make_nodal_vector();
  add_force_sizes(dim, full_weight, given_sizes);
  force_measure = ForceMeasure(dim, basis.nodes.communicator, find_node_places().spacing);

  const SteppingParameters& stepping = context.stage.stepping;
  if (stepping.type != StageType::dynamic)
    return;
  const ParticleArrays& particles = context.soil.particles().arrays();
  equations->set_motion(project_motion(particles, basis.stencils, basis.ghost_faces, stepping.lumped_mass,
                                       Newmark{stepping.beta, stepping.gamma}.needs_start_acceleration(),
                                       equations->mass_graph(), system()));
  const NodalVector drift = system().make_nodal_vector();
  add_particle_momentum(particles, basis.stencils, particles.velocity, drift);
  const double counts = std::max(far_above_round_off, round_off / context.solver.force_tolerance);
  KokkosBlas::scal(drift, counts / stepping.dt, drift);
  add_force_sizes(dim, drift, momentum_sizes);
  KokkosBlas::axpy(1., momentum_sizes, given_sizes);
}

/// Over all ranks, N.
template <int dim> double ImplicitStep<dim>::norm_of(const NodalVector& nodal) const
{
  TpetraVector owned(system().graph().row_map);
  system().collect(nodal, owned);
  return owned.norm2();
}

template <int dim> NodePlaces ImplicitStep<dim>::find_node_places() const
{
  const LeafTable<dim>& table = context.soil.mesh().leaves();
  std::vector<double> spacing(table.node_ids.size(), 0.);
  for (const auto& leaf : table.leaves)
    for (unsigned int i = leaf.node_begin; i < leaf.node_begin + leaf.n_nodes; ++i)
      spacing[table.nodes[i]] = std::max(spacing[table.nodes[i]], leaf.size);
  NodePlaces places;
  for (unsigned int v = 0; v < basis.nodes.n_owned; ++v)
  {
    for (const double x : table.node_position[basis.nodes.mesh_node[v]])
      places.position.push_back(x);
    places.spacing.push_back(spacing[basis.nodes.mesh_node[v]]);
  }
  return places;
}

template <int dim> void ImplicitStep<dim>::weigh_bodies()
{
  const double g = Eigen::Map<const Eigen::Vector3d>(context.gravity.data()).norm();
  const std::vector<SystemSize> sizes = sizes_of_systems(context.bodies, dim);
  double all = 0.; // where a system has no mass
  for (const RigidPoint& point : context.bodies.points)
    all += point.mass;
  for (std::size_t i = 0; i < context.bodies.points.size(); ++i)
  {
    const SystemSize& size = sizes[system_of(context.bodies, i)];
    system_weights.push_back(g * (size.free_mass > 0. ? size.free_mass : all));
    system_levers.push_back(size.lever > 0. ? size.lever : 1.);
  }
  body_levers = levers_of_points(context.bodies, dim);
  body_scale = rigid_unknowns->scale(system_weights, system_levers);
}

template <int dim> RigidStep ImplicitStep<dim>::rigid_step() const
{
  RigidStep step;
  step.gravity = load.gravity_factor * to_world_axes(context.gravity, dim);
  step.fraction = load.step_fraction;
  step.beta = load.begins_stage ? 0.5 : context.stage.stepping.beta; // as RigidStep advises
  step.gamma = load.begins_stage ? 1. : context.stage.stepping.gamma;
  if (context.stage.stepping.type == StageType::dynamic)
    step.dt = load.step_fraction * context.stage.stepping.dt;
  return step;
}

template <int dim> std::vector<Vector6> ImplicitStep<dim>::reactions() const
{
  return find_reactions(context, rigid_step(), body_increments,
                        context.stage.rigid_bodies ? body_loads() : BodyLoads());
}

template <int dim> NewtonReport ImplicitStep<dim>::solve(const StepLoad& load_)
{
  load = load_;
  equations->set_newmark(load.newmark);
  context.soil.contact().reset_multipliers(); // after a cut
  find_body_force();
  if (load.newmark.is_dynamic() && load.begins_stage)
    find_first_acceleration();
  body_force = last_body_force;
  NewtonProblem problem;
  problem.residual = [this](const TpetraVector& x, TpetraVector& r) { return residual(x, r); };
  if (!context.solver.measures_by_weight())
    problem.renew_measure = [this](const TpetraVector& r)
    {
      renew_force_measure();
      return measure(r);
    };
  problem.solve = [this](const TpetraVector& x, const TpetraVector& r, TpetraVector& dx, const NewtonSystem& how)
  { return solve_linearised(x, r, dx, how); };
  problem.suffices = [this](const TpetraVector& r) { return carries_bodies(r); };
  if (load.newmark.is_dynamic())
    problem.solved_at_start = at_rest_in_motion;
  keep_unbalanced();
  const Start start = choose_start(problem);
  NewtonReport report = solve_newton(problem, *increment, context.solver, start.known, load.history);
  report.history.at_rest = start.at_rest;
  double factor = 1., excess = context.soil.contact().excess();
  for (unsigned int round = 0; report.converged && excess > 1.; ++round)
  {
    if (round == max_augmentations)
    {
      report.converged = false;
      report.failure = "contacts still penetrate after " + std::to_string(round) + " rounds of multipliers";
      break;
    }
    context.soil.contact().augment(factor);
    problem.solved_at_start = INFINITY;
    append(report, solve_newton(problem, *increment, context.solver));
    const double before = excess;
    excess = context.soil.contact().excess();
    factor = next_augmentation(factor, excess / before);
  }
  if (report.converged)
  {
    report.failure = refusal_of_leap();
    report.converged = report.failure.empty();
  }
  return report;
}

/// With the measure of residuals: the nodal sums of the material points' weight and body force, of their sizes, so that
/// opposite ones do not cancel. A body force may pass through zero or end: the larger of its values at both ends of the
/// step counts. What "tolerance" measures by is, in dynamic stages, at least the force that would stop the soil within
/// the stage.
template <int dim> void ImplicitStep<dim>::find_body_force()
{
  if (context.body_force == nullptr)
    return;
  const ParticleSet<dim>& points = context.soil.particles();
  const ParticleArrays& particles = points.arrays();
  const auto evaluate = [&](const double time)
  { return context.body_force->evaluate(points, time, basis.nodes.communicator); };
  const View<double* [3]> first = evaluate(load.start_time);
  const View<double* [3]> last = context.body_force->depends_on_time() ? evaluate(load.end_time) : first;
  const double g = Eigen::Map<const Eigen::Vector3d>(context.gravity.data()).norm();
  const View<double* [3]> size = sizes_of_accelerations<dim>(g, first, last);

  const auto at_nodes = [&](const View<double* [3]>& quantity)
  {
    const NodalVector result = system().make_nodal_vector();
    add_particle_momentum(particles, basis.stencils, quantity, result);
    return result;
  };
  first_body_force = at_nodes(first);
  last_body_force = at_nodes(last);
  body_force = first_body_force;
  const NodalVector nodal_size = at_nodes(size);
  Kokkos::deep_copy(given_sizes, momentum_sizes);
  add_force_sizes(dim, nodal_size, given_sizes);
  weight_norm = norm_of(nodal_size);
  if (load.newmark.is_dynamic())
    weight_norm = std::max(weight_norm, norm_of(at_nodes(particles.velocity)) / context.stage.stepping.final_time);
  if (weight_norm == 0. && context.solver.measures_by_weight())
    throw SolverError("neither gravity nor the body force acts on the soil in this step, but residuals are compared "
                      "with them");
}

/// From the forces that nothing balances as the stage begins: a block that is let go falls from its first step on.
template <int dim> void ImplicitStep<dim>::find_first_acceleration()
{
  const StepLoad first = load;
  load.newmark.dt = 0.;
  equations->set_newmark(load.newmark);
  for (Vector6& increment : load.body_increments)
    increment.setZero();
  TpetraVector force(increment->getMap());
  increment->putScalar(0.);
  residual(*increment, force);
  force.scale(-1.);
  NodalMotion motion = equations->motion();
  motion.acceleration = find_accelerations(*rigid_unknowns->nodal(force), equations->mass_graph(), motion.mass,
                                           system(), context.solver.ghost_factor_mass > 0.);
  equations->set_motion(motion);
  load = first;
  equations->set_newmark(load.newmark);
}

/// The share of the forces at rest, before the load of the step, that it leaves as they are.
template <int dim> void ImplicitStep<dim>::keep_unbalanced()
{
  kept_unbalanced = Teuchos::null;
  if (load.share_balanced >= 1.)
    return;
  const Teuchos::RCP<TpetraVector> start = Teuchos::rcp(new TpetraVector(increment->getMap()));
  increment->putScalar(0.);
  residual(*increment, *start);
  start->scale(1. - load.share_balanced);
  kept_unbalanced = start;
}

/// A guess that is much better than rest was in a step before is taken as it is. What is remembered of rest fades, so
/// that rest is looked at now and then.
template <int dim> typename ImplicitStep<dim>::Start ImplicitStep<dim>::choose_start(const NewtonProblem& newton)
{
  const Prediction& prediction = context.soil.prediction();
  increment->putScalar(0.);
  rigid_unknowns->set_rigid(*increment, rigid_unknowns->pick(start_increments(context.bodies, rigid_step())));
  if (!prediction)
    return {};
  TpetraVector guess(increment->getMap()), r(increment->getMap());
  {
    auto view = guess.getLocalViewHost(Tpetra::Access::OverwriteAll);
    for (unsigned int v = 0; v < basis.nodes.n_owned; ++v)
      for (unsigned int d = 0; d < dim; ++d)
        view(dim * v + d, 0) = load.step_fraction * (*prediction)[dim * basis.nodes.mesh_node[v] + d];
  }
  system().zero_constrained(*rigid_unknowns->nodal(guess));
  rigid_unknowns->set_rigid(guess, rigid_unknowns->pick(predicted_increments(context.bodies, rigid_step())));
  double at_guess = INFINITY, at_rest = kept_of_rest * load.history.at_rest;
  if (load.history.at_rest > 0.)
    at_guess = newton.residual(guess, r);
  if (!(at_guess < much_better * load.history.at_rest))
  {
    const double measured = newton.residual(*increment, r);
    at_rest = std::isfinite(measured) ? measured : 0.;
    at_guess = newton.residual(guess, r);
    if (!(at_guess < measured))
      return {{}, at_rest};
  }
  Tpetra::deep_copy(*increment, guess);
  return {NewtonStart{r, at_guess}, at_rest};
}

/// The solution as a guess for the next step.
template <int dim> Prediction ImplicitStep<dim>::predict_next() const
{
  const auto local = copy_to_host(local_increment);
  std::vector<double> prediction(dim * context.soil.mesh().leaves().node_ids.size(), 0.);
  for (unsigned int v = 0; v < basis.nodes.n_local(); ++v)
    for (unsigned int d = 0; d < dim; ++d)
      prediction[dim * basis.nodes.mesh_node[v] + d] = local(dim * v + d) / load.step_fraction;
  return prediction;
}

/// Forces that do not follow from the increment.
template <int dim> void ImplicitStep<dim>::add_given_forces(const NodalVector& force) const
{
  KokkosBlas::axpy(-load.gravity_factor, full_weight, force);
  if (body_force.extent(0) > 0)
    KokkosBlas::axpy(-1., body_force, force);
}

template <int dim> double ImplicitStep<dim>::residual(const TpetraVector& x, TpetraVector& r)
{
  const auto scope = context.timings.measure("residual");
  local_increment = system().spread(*rigid_unknowns->nodal(x));
  body_increments = rigid_unknowns->fill(load.body_increments, rigid_unknowns->rigid(x));
  const NodalVector force = system().make_nodal_vector();
  const unsigned long inverted = equations->add_force(local_increment, force);
  add_given_forces(force);
  if (context.stage.rigid_bodies)
  {
    acting_points = context.soil.contact().evaluate(context.bodies, body_increments, local_increment);
    add_point_forces(dim, acting_points, -1., force);
  }
  const auto nodal_residual = rigid_unknowns->nodal(r);
  system().collect(force, *nodal_residual);
  system().zero_constrained(*nodal_residual);
  if (!kept_unbalanced.is_null())
    nodal_residual->update(-1., *rigid_unknowns->nodal(*kept_unbalanced), 1.);
  if (sum_over_ranks(static_cast<long long>(inverted), basis.nodes.communicator) > 0)
    return INFINITY;
  if (!rigid_unknowns->empty())
  {
    balance = rigid_balance(context.bodies, rigid_step(), body_increments, body_loads());
    rigid_unknowns->set_rigid(r, balance.residual);
  }
  if (force_measure.is_zero() && !context.solver.measures_by_weight())
    renew_force_measure();
  return measure(r);
}

template <int dim> void ImplicitStep<dim>::move_bodies(RigidSystems& committed) const
{
  commit_increments(committed, context.stage.rigid_bodies ? rigid_step() : RigidStep(), body_increments);
}

template <int dim> SoilIncrements ImplicitStep<dim>::soil_increments() const
{
  if (!basis.cells.empty())
    relax_pressure(context.soil.particles().arrays(), basis.stencils, basis.cells, context.soil.materials());
  ParticleIncrements increments =
      interpolate_increments<dim>(context.soil.particles().arrays(), basis.stencils, local_increment, basis.cells);
  if (load.newmark.is_dynamic())
    increments.motion = particle_motion(basis.stencils, equations->motion(), load.newmark, local_increment);
  return {increments, predict_next()};
}

template class ImplicitStep<2>;
template class ImplicitStep<3>;
} // namespace kedge
