// The linear systems of an implicit step: products with the tangent, the matrices of preconditioner and factorisation.
#include <kedge/assembly/internal_force.h>
#include <kedge/steps/implicit_step.h>

namespace kedge
{
namespace
{
/// Weights of the bodies per particle size: springs that hold free bodies under the full damping of Newton's method.
constexpr double holding_springs = 100.;
} // namespace

/// Lists of nodes that the soil couples: each particle's or, with F-bar, each cell's, and those of ghost faces.
template <int dim> std::vector<NodeLists> ImplicitStep<dim>::all_couplings() const
{
  std::vector<NodeLists> couplings{basis.cells.empty()
                                       ? NodeLists{basis.stencils.pattern_node_begin, basis.stencils.pattern_nodes}
                                       : NodeLists{basis.cells.node_begin, basis.cells.nodes}};
  if (basis.ghost_faces.n_faces() > 0)
    couplings.push_back({basis.ghost_faces.node_begin, basis.ghost_faces.nodes});
  return couplings;
}

/// Where systems are solved iteratively, only the preconditioner needs a matrix.
template <int dim> void ImplicitStep<dim>::set_up_systems(const std::vector<unsigned char>& constrained_dofs)
{
  constrained = constrained_dofs;
  factorises = linear_solver.prefers_direct(dim * basis.nodes.n_global);
  const NodeNumbering numbering = numbering_of(basis.nodes);
  system = std::make_unique<System>(
      dim, numbering,
      factorises ? all_couplings() : std::vector<NodeLists>{{basis.elements.node_begin, basis.elements.nodes}},
      constrained);
  if (context.stage.stepping.type == StageType::dynamic)
  {
    std::vector<NodeLists> couplings{{basis.stencils.pattern_node_begin, basis.stencils.pattern_nodes}};
    if (basis.ghost_faces.n_faces() > 0)
      couplings.push_back({basis.ghost_faces.node_begin, basis.ghost_faces.nodes});
    mass_graph = build_local_graph(dim, numbering, couplings);
  }
  LinearSystem linear;
  linear.product = Teuchos::rcp(new NodalOperator(
      *system, [this](const NodalVector& direction, const NodalVector& result) { add_product(direction, result); }));
  linear.near_null_space =
      make_rigid_body_modes(system->graph().row_map, dim, find_node_places().position, constrained);
  linear.near = [this] { return assemble_near(); };
  linear.whole = [this] { return assemble_whole(); };
  linear_solver.set_structure(linear);
}

/// Takes down the derivative of all forces at the last residual.
template <int dim> void ImplicitStep<dim>::linearise(const double elastic_share)
{
  const auto scope = context.timings.measure("tangent");
  damping = elastic_share;
  if (factorises)
    return;
  force_derivative = linearise_force<dim>(context.soil.particles().arrays(), basis.stencils, context.soil.materials(),
                                          basis.cells, elastic_share, force_derivative);
  ghost_derivative = linearise_ghost<dim>(basis.ghost_faces, local_increment);
  if (context.stage.rigid_bodies)
    contact_derivative = linearise_points(context.soil.contact().points_of_last_evaluation());
}

template <int dim> void ImplicitStep<dim>::add_product(const NodalVector& direction, const NodalVector& result) const
{
  add_linearised_force<dim>(basis.stencils, basis.cells, force_derivative, direction, result);
  add_linearised_ghost<dim>(basis.ghost_faces, ghost_derivative, direction, result);
  if (context.stage.rigid_bodies)
    add_linearised_points(dim, contact_derivative, -1., direction, result);
  if (load.newmark.is_dynamic())
    add_mass_times(mass_graph, motion.mass, load.newmark.stiffness_factor(), direction, result);
}

/// What all matrices have besides the soil's stiffness, as far as their couplings hold it.
template <int dim> void ImplicitStep<dim>::finish_matrix(System& into) const
{
  if (context.stage.rigid_bodies)
    add_point_tangents(context.soil.contact().points_of_last_evaluation(), -1., into.graph(), into.values());
  add_ghost_matrix<dim>(basis.ghost_faces, local_increment, into.graph(), into.values());
  if (load.newmark.is_dynamic())
    add_mass_matrix(mass_graph, motion.mass, load.newmark.stiffness_factor(), into.graph(), into.values());
  into.finish_matrix();
}

template <int dim> Teuchos::RCP<TpetraMatrix> ImplicitStep<dim>::assemble_near()
{
  const auto scope = context.timings.measure("preconditioner matrix");
  system->clear_matrix();
  add_element_stiffness<dim>(basis.elements, basis.cells, force_derivative, system->graph(), system->values());
  finish_matrix(*system);
  reinforce_diagonal(*system->matrix());
  return system->matrix();
}

template <int dim> Teuchos::RCP<TpetraMatrix> ImplicitStep<dim>::assemble_whole()
{
  const auto scope = context.timings.measure("tangent");
  if (!factorises && !whole_system)
    whole_system = std::make_unique<System>(dim, numbering_of(basis.nodes), all_couplings(), constrained);
  System& into = factorises ? *system : *whole_system;
  into.clear_matrix();
  add_tangent<dim>(context.soil.particles().arrays(), basis.stencils, context.soil.materials(), into.graph(),
                   into.values(), basis.cells, damping);
  finish_matrix(into);
  return into.matrix();
}

template <int dim>
LinearReport ImplicitStep<dim>::solve_linearised(const TpetraVector&, const TpetraVector& r, TpetraVector& dx,
                                                 const NewtonSystem& how)
{
  // the last residual was evaluated here, so the local increment and the contact's tangents are those of x
  linearise(how.damping);
  const auto scope = context.timings.measure("linear solver");
  Border border;
  if (!rigid_unknowns->empty())
  {
    border = rigid_unknowns->border(balance, context.soil.contact().coupling(context.bodies, body_increments),
                                    context.soil.contact().points_of_last_evaluation(), body_increments, *system);
    if (how.damping > 0. && !load.newmark.is_dynamic()) // a body that touches nothing yet sinks until the soil holds it
    {
      const double particle = context.soil.mesh().layout().finest_size / context.soil.parameters().points_per_axis;
      rigid_unknowns->hold(border, how.damping * holding_springs * body_weight / particle, body_lever);
    }
  }
  Eigen::VectorXd dy;
  const LinearReport report = linear_solver.solve(*rigid_unknowns->nodal(r), rigid_unknowns->rigid(r), border,
                                                  *rigid_unknowns->nodal(dx), dy, how.tolerance);
  rigid_unknowns->set_rigid(dx, dy);
  return report;
}

#define KEDGE_INSTANTIATE(dim)                                                                                         \
  template std::vector<NodeLists> ImplicitStep<dim>::all_couplings() const;                                            \
  template void ImplicitStep<dim>::set_up_systems(const std::vector<unsigned char>&);                                  \
  template void ImplicitStep<dim>::linearise(double);                                                                  \
  template void ImplicitStep<dim>::add_product(const NodalVector&, const NodalVector&) const;                          \
  template void ImplicitStep<dim>::finish_matrix(System&) const;                                                       \
  template Teuchos::RCP<TpetraMatrix> ImplicitStep<dim>::assemble_near();                                              \
  template Teuchos::RCP<TpetraMatrix> ImplicitStep<dim>::assemble_whole();                                             \
  template LinearReport ImplicitStep<dim>::solve_linearised(const TpetraVector&, const TpetraVector&, TpetraVector&,   \
                                                            const NewtonSystem&);
KEDGE_INSTANTIATE(2)
KEDGE_INSTANTIATE(3)
} // namespace kedge
