#include <kedge/parameters/section.h>
#include <kedge/solvers/parameters.h>

namespace kedge
{
using namespace schema;

Section<SolverParameters> solver_section()
{
  using P = SolverParameters;
  Section<P> section("Newton iterations, linear solver and ghost stabilisation");
  section.optional(
      "force tolerance", &P::force_tolerance, number("-", positive().below(1.)),
      "A step has converged when the share of the forces at a node that nothing balances, in the root mean "
      "square over all nodes, falls below this, and at no node exceeds fifty times this (free bodies: their "
      "unbalanced force over their own weight, load and inertia), and little is unbalanced compared with the load on "
      "each body: ten times this at the nodes that it loads, forty times this at all nodes");
  section.optional(
      "tolerance", [](P& parameters, const double value) { parameters.tolerance = value; },
      number("-", positive().below(1.)),
      "In place of \"force tolerance\", which then counts for the loads on bodies alone: a step has converged when the "
      "norm of the residual on the free degrees of freedom falls below this times the norm of the nodal weights and "
      "body forces of the soil (rigid degrees of freedom: the weight of the free bodies of their system). Large cells "
      "far away make this norm, so small cells need a small value");
  section.required("max newton iterations", &P::max_newton_iterations, count(Bounds().at_least(1)),
                   "Newton iterations before a step is cut to half; it is cut sooner if half of them, but at least 24, "
                   "in a row make "
                   "no progress");
  section.optional("max linear iterations", &P::max_linear_iterations, count(Bounds().at_least(1)),
                   "Krylov iterations per Newton iteration before the linear solver escalates");
  section.optional(
      "poor factor", &P::poor_factor, number("-", not_negative().at_most(1.)),
      "Cells filled below this share of their volume count as boundary cells; 0: no cell does. Resistances "
      "with 0 to 0.25 are within 0.4 % of each other for a strip plate in clay, 1.6 % for a wall; 0.5 moves "
      "a footing on sand by up to 13 % in a step, 0.75 by 35 %");
  section.optional(
      "ghost factor", &P::ghost_factor, maybe(number("1/m2", not_negative())),
      "Scale of the ghost stabilisation of the stiffness; its strength is this times the square of the cell size. "
      "Without the key the strength is 0.02 for cells of any size. It yields where the soil shears, so a strength of "
      "0.1 and 0.01 gives a strip plate in clay 12.3 and 12.2 s_u; less than 0.002 leaves slivers loose; 0: "
      "none");
  section.optional("ghost factor mass", &P::ghost_factor_mass, number("-", not_negative()),
                   "Scale of the ghost stabilisation of the mass in dynamic stages; 0: none");
  section.optional(
      "line search", &P::line_search, on_off(),
      "Line search along each Newton correction, and damped tangents after a correction that was shortened");
  section.optional("linear solver", &P::linear_solver,
                   choice<LinearSolverChoice>({{"auto", LinearSolverChoice::automatic},
                                               {"iterative", LinearSolverChoice::iterative},
                                               {"direct", LinearSolverChoice::direct}}),
                   "Multigrid-preconditioned GMRES, a factorisation, or whichever suits the size");
  section.optional(
      "reuse", &P::reuse, on_off(),
      "Keep the preconditioner from one Newton iteration to the next while that costs less than a new one");
  section.optional("minimum step fraction", &P::minimum_step_fraction, number("-", Bounds().at_least(1e-9).at_most(1.)),
                   "Smallest share of a step to which it may be cut; the run stops below it");
  return section;
}
} // namespace kedge
