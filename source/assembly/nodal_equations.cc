#include <kedge/assembly/nodal_equations.h>

namespace kedge
{
/// Where systems are solved iteratively, only the preconditioner needs a matrix.
template <int dim>
NodalEquations<dim>::NodalEquations(NodalParts parts_, const bool factorises_, const bool is_dynamic, Timings& timings_)
    : data(std::move(parts_)), factorises(factorises_), timings(timings_)
{
  dofs = std::make_unique<System>(dim, data.numbering,
                                  factorises ? all_couplings()
                                             : std::vector<NodeLists>{{data.elements.node_begin, data.elements.nodes}},
                                  data.constrained);
  if (!is_dynamic)
    return;
  std::vector<NodeLists> couplings{{data.stencils.pattern_node_begin, data.stencils.pattern_nodes}};
  if (data.ghost_faces.n_faces() > 0)
    couplings.push_back({data.ghost_faces.node_begin, data.ghost_faces.nodes});
  graph_of_mass = build_local_graph(dim, data.numbering, couplings);
}

/// Lists of nodes that the soil couples: each particle's or, with F-bar, each cell's, and those of ghost faces.
template <int dim> std::vector<NodeLists> NodalEquations<dim>::all_couplings() const
{
  std::vector<NodeLists> couplings{data.cells.empty()
                                       ? NodeLists{data.stencils.pattern_node_begin, data.stencils.pattern_nodes}
                                       : NodeLists{data.cells.node_begin, data.cells.nodes}};
  if (data.ghost_faces.n_faces() > 0)
    couplings.push_back({data.ghost_faces.node_begin, data.ghost_faces.nodes});
  return couplings;
}

template <int dim>
unsigned long NodalEquations<dim>::add_force(const NodalVector& increment, const NodalVector& force) const
{
  const unsigned long inverted =
      update_stress_and_force<dim>(data.particles, data.stencils, data.materials, increment, force, data.cells);
  add_ghost_force<dim>(data.ghost_faces, increment, force);
  if (newmark.is_dynamic())
    add_inertia_force(graph_of_mass, start, newmark, increment, force);
  return inverted;
}

template <int dim>
void NodalEquations<dim>::linearise(const NodalVector& increment, const PointForces& points, const double elastic_share)
{
  const auto scope = timings.measure("tangent");
  acting_points = gather_acting(points);
  damping = elastic_share;
  ghost_derivative = linearise_ghost<dim>(data.ghost_faces, increment);
  if (!factorises)
    force_derivative = linearise_force<dim>(data.particles, data.stencils, data.materials, data.cells, elastic_share,
                                            force_derivative);
}

template <int dim> void NodalEquations<dim>::add_product(const NodalVector& direction, const NodalVector& result) const
{
  add_linearised_force<dim>(data.stencils, data.cells, force_derivative, direction, result);
  add_linearised_ghost<dim>(data.ghost_faces, ghost_derivative, direction, result);
  add_point_products(dim, acting_points, -1., direction, result);
  if (newmark.is_dynamic())
    add_mass_times(graph_of_mass, start.mass, newmark.stiffness_factor(), direction, result);
}

/// What all matrices have besides the soil's stiffness, as far as their couplings hold it.
template <int dim> void NodalEquations<dim>::finish_matrix(System& into) const
{
  add_point_tangents(acting_points, -1., into.graph(), into.values());
  add_ghost_matrix<dim>(data.ghost_faces, ghost_derivative, into.graph(), into.values());
  if (newmark.is_dynamic())
    add_mass_matrix(graph_of_mass, start.mass, newmark.stiffness_factor(), into.graph(), into.values());
  into.finish_matrix();
}

template <int dim> Teuchos::RCP<TpetraMatrix> NodalEquations<dim>::assemble_near()
{
  const auto scope = timings.measure("preconditioner matrix");
  dofs->clear_matrix();
  add_element_stiffness<dim>(data.elements, data.cells, force_derivative, dofs->graph(), dofs->values());
  finish_matrix(*dofs);
  reinforce_diagonal(*dofs->matrix());
  return dofs->matrix();
}

template <int dim> Teuchos::RCP<TpetraMatrix> NodalEquations<dim>::assemble_whole()
{
  const auto scope = timings.measure("tangent");
  if (!factorises && !whole_system)
    whole_system = std::make_unique<System>(dim, data.numbering, all_couplings(), data.constrained);
  System& into = factorises ? *dofs : *whole_system;
  into.clear_matrix();
  add_tangent<dim>(data.particles, data.stencils, data.materials, into.graph(), into.values(), data.cells, damping);
  finish_matrix(into);
  return into.matrix();
}

template <int dim> LinearSystem NodalEquations<dim>::linear_system()
{
  LinearSystem linear;
  linear.product = Teuchos::rcp(new NodalOperator(*dofs, [this](const NodalVector& direction, const NodalVector& result)
                                                  { add_product(direction, result); }));
  linear.near_null_space = make_rigid_body_modes(dofs->graph().row_map, dim, data.position, data.constrained);
  linear.near = [this] { return assemble_near(); };
  linear.whole = [this] { return assemble_whole(); };
  return linear;
}

template class NodalEquations<2>;
template class NodalEquations<3>;
} // namespace kedge
