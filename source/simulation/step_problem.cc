#include <cmath>
#include <kedge/base/communication.h>
#include <kedge/basis/ghost_faces.h>
#include <kedge/simulation/step_problem.h>

namespace kedge
{
namespace
{
constexpr unsigned int max_augmentations = 20;

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
} // namespace

template <int dim>
StepProblem<dim>::StepProblem(const Input& input_, const Stage& stage_, const BackgroundMesh<dim>& mesh_,
                              ParticleSet<dim>& particles_, const Materials& materials_, const RigidSystems& bodies_,
                              Contact<dim>& contact_, Timings& timings_)
    : input(input_),
      stage(stage_),
      mesh(mesh_),
      particles(particles_),
      materials(materials_),
      bodies(bodies_),
      contact(contact_),
      timings(timings_),
      linear_solver(input_.solver, dim)
{
  number_nodes();
  if (stage.rigid_bodies)
    find_contact_pairs();

  const auto scope = timings.measure("sparsity");
  const std::vector<unsigned char> constrained = find_constrained_dofs();
  std::vector<NodeLists> couplings{cells.empty() ? NodeLists{stencils.pattern_node_begin, stencils.pattern_nodes}
                                                 : NodeLists{cells.node_begin, cells.nodes}};
  if (ghost_faces.n_faces() > 0)
    couplings.push_back({ghost_faces.node_begin, ghost_faces.nodes});
  system = std::make_unique<System>(
      dim, NodeNumbering{nodes.communicator, nodes.n_owned, nodes.global, nodes.ghost_begin}, couplings, constrained);

  const NodePlaces places = find_node_places();
  linear_solver.set_structure(
      system->matrix(), make_rigid_body_modes(system->graph().row_map, dim, places.position, constrained), places);

  rigid_unknowns = std::make_unique<RigidUnknowns>(bodies, stage.rigid_bodies, system->graph().row_map);
  weigh_bodies();
  increment = Teuchos::rcp(new TpetraVector(rigid_unknowns->map()));
  full_weight = system->make_nodal_vector();
  add_weight<dim>(particles.arrays(), stencils, input.gravity, 1., full_weight);
  TpetraVector weight(system->graph().row_map);
  system->collect(full_weight, weight);
  weight_norm = weight.norm2();

  if (stage.stepping.type == StageType::dynamic)
    motion = project_motion(particles.arrays(), stencils, ghost_faces, stage.stepping.lumped_mass, *system);
}

template <int dim> void StepProblem<dim>::number_nodes()
{
  const auto scope = timings.measure("basis");
  HostStencils host = build_stencils<dim>(mesh.leaves(), particles.positions(), particles.half_widths(),
                                          particles.leaves(), input.basis == Basis::mpm);
  std::vector<unsigned char> used(mesh.leaves().node_ids.size(), 0);
  for (const unsigned int node : host.pattern_nodes)
    used[node] = 1;
  HostGhostFaces faces;
  if (input.solver.ghost_factor > 0. || input.solver.ghost_factor_mass > 0.)
  {
    const std::vector<LeafContent> contents = find_leaf_contents<dim>(
        mesh.leaves(), particles.positions(), particles.half_widths(), download(particles.arrays().young),
        download(particles.arrays().mass), input.solver.poor_factor, mesh.triangulation().get_communicator());
    faces = find_ghost_faces<dim>(mesh.leaves(), contents, {input.solver.ghost_factor, input.solver.ghost_factor_mass});
    for (const unsigned int node : faces.nodes)
      used[node] = 1; // active already, but perhaps only through other ranks' particles
  }
  nodes = number_active_nodes<dim>(mesh.leaves(), used, mesh.triangulation().get_communicator());
  stencils = upload_stencils<dim>(std::move(host), nodes.number);
  if (input.material_points.f_bar)
    cells = group_by_cell(stencils, particles.leaves());
  ghost_faces = upload_ghost_faces(std::move(faces), nodes.number);
}

template <int dim> std::vector<unsigned char> StepProblem<dim>::find_constrained_dofs() const
{
  const LeafTable<dim>& table = mesh.leaves();
  std::vector<unsigned char> constrained(static_cast<std::size_t>(dim) * nodes.n_local(), 0);
  for (unsigned int v = 0; v < nodes.n_local(); ++v)
    for (unsigned int axis = 0; axis < dim; ++axis)
      for (const bool upper : {false, true})
      {
        const double face = upper ? table.upper_end(axis) : table.lower_end(axis);
        if (std::abs(table.node_position[nodes.mesh_node[v]][axis] - face) > 1e-9 * table.base_size)
          continue;
        const FaceCondition condition = upper
                                            ? stage.track.max[axis].type.value_or(stage.boundary_conditions.max[axis])
                                            : stage.track.min[axis].type.value_or(stage.boundary_conditions.min[axis]);
        for (unsigned int d = 0; d < dim; ++d)
          if (condition == FaceCondition::fixed || (condition == FaceCondition::roller && d == axis))
            constrained[dim * v + d] = 1;
      }
  return constrained;
}

template <int dim> NodePlaces StepProblem<dim>::find_node_places() const
{
  const LeafTable<dim>& table = mesh.leaves();
  std::vector<double> spacing(table.node_ids.size(), 0.);
  for (const auto& leaf : table.leaves)
    for (unsigned int i = leaf.node_begin; i < leaf.node_begin + leaf.n_nodes; ++i)
      spacing[table.nodes[i]] = std::max(spacing[table.nodes[i]], leaf.size);
  NodePlaces places;
  for (unsigned int v = 0; v < nodes.n_owned; ++v)
  {
    for (const double x : table.node_position[nodes.mesh_node[v]])
      places.position.push_back(x);
    places.spacing.push_back(spacing[nodes.mesh_node[v]]);
  }
  return places;
}

template <int dim> void StepProblem<dim>::find_contact_pairs()
{
  const auto scope = timings.measure("contact search");
  double reach = 0.;
  const auto box = world_bounds(bodies);
  const double lever = bodies.surfaces.empty() ? 0. : (box[1] - box[0]).norm();
  const RigidStep whole = rigid_step();
  for (const RigidPoint& point : bodies.points)
  {
    const bool moves_freely = point.n_free_dofs() > 0;
    const Vector6 expected = point.prescribed_increment(1.) + (moves_freely ? whole.dt : 0.) * point.velocity;
    double way = expected.head<3>().norm() + expected.tail<3>().norm() * lever;
    if (moves_freely) // it may speed up
      way = 2. * way + whole.gravity.norm() * whole.dt * whole.dt;
    reach = std::max(reach, way);
  }
  const std::vector<double> volume = download(particles.arrays().initial_volume);
  const std::vector<double> young = download(particles.arrays().young);
  contact.find_pairs(bodies, mesh.leaves(),
                     {particles.positions(), particles.half_widths(), particles.ids(), volume, young}, nodes.number,
                     reach);
}

template <int dim> void StepProblem<dim>::weigh_bodies()
{
  const double g = Eigen::Map<const Eigen::Vector3d>(input.gravity.data()).norm();
  for (const RigidPoint& point : bodies.points)
    body_weight += point.mass * g;
  if (!bodies.surfaces.empty())
    body_lever = 0.5 * (world_bounds(bodies)[1] - world_bounds(bodies)[0]).norm();
}

template <int dim> RigidStep StepProblem<dim>::rigid_step() const
{
  RigidStep step;
  step.gravity = load.gravity_factor * to_world_axes(input.gravity, dim);
  step.fraction = load.step_fraction;
  step.beta = load.begins_stage ? 0.5 : stage.stepping.beta; // as RigidStep advises
  step.gamma = load.begins_stage ? 1. : stage.stepping.gamma;
  if (stage.stepping.type == StageType::dynamic)
    step.dt = load.step_fraction * stage.stepping.dt;
  return step;
}

template <int dim> std::vector<Vector6> StepProblem<dim>::reactions() const
{
  if (!stage.rigid_bodies)
  {
    std::vector<Vector6> result(bodies.points.size(), Vector6::Zero());
    for (std::size_t i = 0; i < result.size(); ++i)
      result[i].template head<3>() = -bodies.points[i].mass * rigid_step().gravity;
    return result;
  }
  return rigid_reactions(bodies, rigid_balance(bodies, rigid_step(), body_increments, body_loads()), body_increments);
}

template <int dim> NewtonReport StepProblem<dim>::solve(const Load& load_, const Prediction& prediction)
{
  load = load_;
  if (load.newmark.is_dynamic() && load.starts_at_rest)
    find_first_acceleration();
  NewtonProblem problem;
  problem.residual = [this](const TpetraVector& x, TpetraVector& r) { return residual(x, r); };
  problem.solve = [this](const TpetraVector& x, const TpetraVector& r, TpetraVector& dx, const double tolerance)
  { return solve_linearised(x, r, dx, tolerance); };
  contact.reset_multipliers();
  start_from(problem, prediction);
  NewtonReport report = solve_newton(problem, *increment, input.solver);
  for (unsigned int round = 0; report.converged && contact.excess() > 1.; ++round)
  {
    if (round == max_augmentations)
    {
      report.converged = false;
      report.failure = "contacts still penetrate after " + std::to_string(round) + " rounds of multipliers";
      break;
    }
    contact.augment();
    append(report, solve_newton(problem, *increment, input.solver));
  }
  return report;
}

/// From the forces that nothing balances as the stage begins: a block that is let go falls from its first step on.
template <int dim> void StepProblem<dim>::find_first_acceleration()
{
  const Load first = load;
  load.newmark.dt = 0.;
  for (Vector6& increment : load.body_increments)
    increment.setZero();
  TpetraVector force(increment->getMap());
  increment->putScalar(0.);
  residual(*increment, force);
  force.scale(-1.);
  set_mass_matrix(motion.mass, *system); // after a cut the matrix is Newton's
  motion.acceleration = divide_by_mass(*rigid_unknowns->nodal(force), *system);
  load = first;
}

template <int dim> void StepProblem<dim>::start_from(const NewtonProblem& newton, const Prediction& prediction)
{
  increment->putScalar(0.);
  rigid_unknowns->set_rigid(*increment, rigid_unknowns->pick(start_increments(bodies, rigid_step())));
  if (prediction.empty())
    return;
  TpetraVector guess(increment->getMap()), r(increment->getMap());
  {
    auto view = guess.getLocalViewHost(Tpetra::Access::OverwriteAll);
    for (unsigned int v = 0; v < nodes.n_owned; ++v)
      for (unsigned int d = 0; d < dim; ++d)
        view(dim * v + d, 0) = load.step_fraction * prediction[dim * nodes.mesh_node[v] + d];
  }
  system->zero_constrained(*rigid_unknowns->nodal(guess));
  rigid_unknowns->set_rigid(guess, rigid_unknowns->pick(predicted_increments(bodies, rigid_step())));
  const double at_rest = newton.residual(*increment, r);
  if (newton.residual(guess, r) < at_rest)
    Tpetra::deep_copy(*increment, guess);
}

template <int dim> Prediction StepProblem<dim>::predict_next() const
{
  const auto local = Kokkos::create_mirror_view_and_copy(Kokkos::HostSpace(), local_increment);
  Prediction prediction(dim * mesh.leaves().node_ids.size(), 0.);
  for (unsigned int v = 0; v < nodes.n_local(); ++v)
    for (unsigned int d = 0; d < dim; ++d)
      prediction[dim * nodes.mesh_node[v] + d] = local(dim * v + d) / load.step_fraction;
  return prediction;
}

template <int dim> double StepProblem<dim>::residual(const TpetraVector& x, TpetraVector& r)
{
  const auto scope = timings.measure("residual");
  local_increment = system->spread(*rigid_unknowns->nodal(x));
  body_increments = rigid_unknowns->fill(load.body_increments, rigid_unknowns->rigid(x));
  const NodalVector force = system->make_nodal_vector();
  const unsigned long inverted =
      update_stress_and_force<dim>(particles.arrays(), stencils, materials, local_increment, force, cells);
  const double factor = load.gravity_factor;
  const NodalVector weight = full_weight;
  Kokkos::parallel_for(
      "weight", Kokkos::RangePolicy<ExecutionSpace>(0, force.extent(0)),
      KOKKOS_LAMBDA(const std::size_t i) { force(i) -= factor * weight(i); });
  if (stage.rigid_bodies)
  {
    const auto host = Kokkos::create_mirror_view_and_copy(Kokkos::HostSpace(), local_increment);
    add_point_forces(dim, contact.evaluate(bodies, body_increments, host.data()), -1., force);
  }
  add_ghost_force<dim>(ghost_faces, ghost_faces.stiffness, local_increment, force);
  if (load.newmark.is_dynamic())
    add_inertia_force(system->graph(), motion, load.newmark, local_increment, force);
  const auto nodal_residual = rigid_unknowns->nodal(r);
  system->collect(force, *nodal_residual);
  system->zero_constrained(*nodal_residual);
  if (sum_over_ranks(static_cast<long long>(inverted), nodes.communicator) > 0)
    return INFINITY;
  const double soil = nodal_residual->norm2() / weight_norm;
  if (rigid_unknowns->empty())
    return soil;
  balance = rigid_balance(bodies, rigid_step(), body_increments, body_loads());
  rigid_unknowns->set_rigid(r, balance.residual);
  return std::max(soil, rigid_unknowns->measure(balance.residual, body_weight, body_lever));
}

template <int dim>
LinearReport StepProblem<dim>::solve_linearised(const TpetraVector&, const TpetraVector& r, TpetraVector& dx,
                                                const double tolerance)
{
  // the last residual was evaluated here, so the local increment and the contact's tangents are those of x
  {
    const auto scope = timings.measure("tangent");
    system->clear_matrix();
    add_tangent<dim>(particles.arrays(), stencils, materials, local_increment, system->graph(), system->values(),
                     cells);
    if (stage.rigid_bodies)
      add_point_tangents(contact.points_of_last_evaluation(), -1., system->graph(), system->values());
    add_ghost_matrix<dim>(ghost_faces, ghost_faces.stiffness, system->graph(), system->values());
    if (load.newmark.is_dynamic())
      add_mass_matrix(system->graph(), motion.mass, load.newmark.stiffness_factor(), system->values());
    system->finish_matrix();
  }
  const auto scope = timings.measure("linear solver");
  Border border;
  if (!rigid_unknowns->empty())
    border = rigid_unknowns->border(balance, contact.coupling(bodies, body_increments),
                                    contact.points_of_last_evaluation(), body_increments, *system);
  Eigen::VectorXd dy;
  const LinearReport report = linear_solver.solve(*rigid_unknowns->nodal(r), rigid_unknowns->rigid(r), border,
                                                  *rigid_unknowns->nodal(dx), dy, tolerance);
  rigid_unknowns->set_rigid(dx, dy);
  return report;
}

template <int dim> ParticleIncrements StepProblem<dim>::particle_increments() const
{
  ParticleIncrements increments = interpolate_increments<dim>(particles.arrays(), stencils, local_increment, cells);
  if (load.newmark.is_dynamic())
    increments.motion = particle_motion(stencils, motion, load.newmark, local_increment);
  return increments;
}

template <int dim> double StepProblem<dim>::basis_bytes() const
{
  return double(stencils.value.span() + stencils.gradient.span()) * sizeof(double) +
         double(stencils.pattern_nodes.span() + stencils.pattern_particles.span() + cells.nodes.span()) *
             sizeof(unsigned int) +
         stencils.n_particles * (sizeof(unsigned int) + sizeof(std::size_t));
}

template class StepProblem<2>;
template class StepProblem<3>;
} // namespace kedge
