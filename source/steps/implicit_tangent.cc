// The linear systems of an implicit step.
#include <kedge/steps/implicit_step.h>

namespace kedge
{
namespace
{
/// Weights of the bodies per particle size: springs that hold free bodies under the full damping of Newton's method.
constexpr double holding_springs = 100.;
} // namespace

template <int dim> void ImplicitStep<dim>::set_up_equations()
{
  const NodalParts parts{context.soil.particles().arrays(),
                         context.soil.materials(),
                         basis.stencils,
                         basis.cells,
                         basis.elements,
                         basis.ghost_faces,
                         numbering_of(basis.nodes),
                         find_node_places().position,
                         find_constrained_dofs(context, basis.nodes)};
  equations = std::make_unique<NodalEquations<dim>>(parts, linear_solver.prefers_direct(dim * basis.nodes.n_global),
                                                    context.stage.stepping.type == StageType::dynamic, context.timings);
  linear_solver.set_structure(equations->linear_system());
}

template <int dim>
LinearReport ImplicitStep<dim>::solve_linearised(const TpetraVector&, const TpetraVector& r, TpetraVector& dx,
                                                 const NewtonSystem& how)
{
  // the last residual was evaluated here, so the local increment and the contact's tangents are those of x
  equations->linearise(local_increment, acting_points, how.damping);
  const auto scope = context.timings.measure("linear solver");
  Border border;
  if (!rigid_unknowns->empty())
  {
    border = rigid_unknowns->border(balance, context.soil.contact(), body_increments, system());
    if (how.damping > 0. && !load.newmark.is_dynamic()) // a body that touches nothing yet sinks until the soil holds it
    {
      const double particle = context.soil.mesh().layout().finest_size / context.soil.parameters().points_per_axis;
      rigid_unknowns->hold(border, how.damping * holding_springs / particle, system_weights, system_levers);
    }
  }
  Eigen::VectorXd dy;
  const LinearReport report = linear_solver.solve(*rigid_unknowns->nodal(r), rigid_unknowns->rigid(r), border,
                                                  *rigid_unknowns->nodal(dx), dy, how.tolerance);
  rigid_unknowns->set_rigid(dx, dy);
  if (++n_solved; context.saves != nullptr && context.saves->iteration == n_solved && !context.saves->is_done)
    save_system(r, dx, border, how);
  return report;
}

#define KEDGE_INSTANTIATE(dim)                                                                                         \
  template void ImplicitStep<dim>::set_up_equations();                                                                 \
  template LinearReport ImplicitStep<dim>::solve_linearised(const TpetraVector&, const TpetraVector&, TpetraVector&,   \
                                                            const NewtonSystem&);
KEDGE_INSTANTIATE(2)
KEDGE_INSTANTIATE(3)
} // namespace kedge
