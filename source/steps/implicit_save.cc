// Writes a linear system of Newton's method to a file, to be computed again elsewhere (kedge-replay).
#include <kedge/base/communication.h>
#include <kedge/base/failure.h>
#include <kedge/replay/saved_step.h>
#include <kedge/steps/implicit_step.h>

namespace kedge
{
/// With the residual r of the last evaluation and the solution that was found.
template <int dim>
void ImplicitStep<dim>::save_system(const TpetraVector& r, const TpetraVector& dx, const Border& border,
                                    const NewtonSystem& how)
{
  const bool is_dynamic = load.newmark.is_dynamic();
  SavedStep saved;
  saved.dim = dim;
  saved.n_ranks = size_of(basis.nodes.communicator);
  saved.parts = equations->parts();
  saved.is_dynamic = is_dynamic;
  saved.newmark = load.newmark;
  saved.motion = equations->motion();
  saved.increment = local_increment;
  if (context.stage.rigid_bodies)
  {
    const Contact<dim>& contact = context.soil.contact();
    saved.contact = save_contact(contact.arrays_of_last_evaluation(), contact.motions_of_last_evaluation(),
                                 contact.keeps_multipliers(), rigid_unknowns->rates(body_increments));
  }
  saved.elastic_share = how.damping;
  saved.tolerance = how.tolerance;
  saved.residual = values_of(*rigid_unknowns->nodal(r));
  saved.solution = values_of(*rigid_unknowns->nodal(dx));
  if (!border.empty())
  {
    saved.columns = values_of(*border.columns);
    saved.rows = values_of(*border.rows);
    saved.corner.assign(border.corner.data(), border.corner.data() + border.corner.size());
    const Eigen::VectorXd side = rigid_unknowns->rigid(r);
    saved.rigid_side.assign(side.data(), side.data() + side.size());
  }

  // Forces that do not follow from the increment.
  const NodalVector given = equations->system().make_nodal_vector();
  add_given_forces(given);
  TpetraVector other(equations->system().graph().row_map);
  equations->system().collect(given, other);
  if (!kept_unbalanced.is_null())
    other.update(-1., *rigid_unknowns->nodal(*kept_unbalanced), 1.);
  saved.other = upload(values_of(other), "other forces");

  // The derivative as it is applied in large systems: small ones are factorised without it.
  NodalEquations<dim> applied(saved.parts, false, is_dynamic, context.timings);
  applied.set_motion(saved.motion);
  applied.set_newmark(load.newmark);
  applied.add_force(local_increment, applied.system().make_nodal_vector());
  applied.linearise(local_increment, acting_points, how.damping);
  TpetraVector product(applied.system().graph().row_map);
  applied.linear_system().product->apply(*rigid_unknowns->nodal(dx), product);
  saved.product = values_of(product);

  agree(basis.nodes.communicator, [&] { write_step(saved, rank_file(context.saves->path, basis.nodes.communicator)); });
  context.saves->is_done = true;
}

template void ImplicitStep<2>::save_system(const TpetraVector&, const TpetraVector&, const Border&,
                                           const NewtonSystem&);
template void ImplicitStep<3>::save_system(const TpetraVector&, const TpetraVector&, const Border&,
                                           const NewtonSystem&);
} // namespace kedge
