// The nonlinear problem of one step: what has to be zero, and its derivative.
#pragma once

#include <kedge/assembly/nodal_equations.h>
#include <kedge/steps/force_measure.h>
#include <kedge/steps/rigid_unknowns.h>
#include <kedge/steps/step_basis.h>

namespace kedge
{
/// Positions of the owned nodes (dim coordinates per node) and the size of the largest cell at each node, both in m.
struct NodePlaces
{
  std::vector<double> position, spacing;
};

/// An implicit step, static or dynamic. Fixed data: basis, numbering, sparsity, contact pairs.
template <int dim> class ImplicitStep : public TrialStep<dim>
{
public:
  /// Overlaps particles with cells, numbers the active nodes and sets up the sparsity. Collective.
  explicit ImplicitStep(const StepContext<dim>& context);

  /// Finds equilibrium, from the prediction where that is nearer to it than rest. Collective.
  NewtonReport solve(const StepLoad& load) override;

  SoilIncrements soil_increments() const override;
  /// Of the solution: the loads of the soil on the bodies. Collective.
  BodyLoads body_loads() const { return context.soil.contact().loads(); }
  const std::vector<Vector6>& rigid_increments() const { return body_increments; }
  std::vector<Vector6> reactions() const override;
  void move_bodies(RigidSystems& committed) const override;

  ResidualPlace find_residual() override;

  long long n_dofs() const override { return dim * basis.nodes.n_global; }
  double basis_bytes() const override { return basis.bytes(); }

private:
  struct Start
  {
    std::optional<NewtonStart> known; ///< if the increment's residual was evaluated last
    double at_rest = 0.;              ///< of NewtonHistory
  };

  RigidStep rigid_step() const;
  NodePlaces find_node_places() const;
  void weigh_bodies();
  double norm_of(const NodalVector& nodal) const;
  void find_body_force();
  void find_first_acceleration();
  Start choose_start(const NewtonProblem& newton);
  Prediction predict_next() const;
  void keep_unbalanced();
  double residual(const TpetraVector& x, TpetraVector& r);
  void renew_force_measure();
  std::vector<double> forces_on_bodies() const;
  bool carries_bodies(const TpetraVector& r) const;
  std::string refusal_of_leap() const;
  double measure(const TpetraVector& r) const;
  void add_given_forces(const NodalVector& force) const;
  void set_up_equations();
  LinearReport solve_linearised(const TpetraVector& x, const TpetraVector& r, TpetraVector& dx,
                                const NewtonSystem& how);
  void save_system(const TpetraVector& r, const TpetraVector& dx, const Border& border, const NewtonSystem& how);
  const System& system() const { return equations->system(); }

  StepContext<dim> context;
  StepBasis basis;
  std::unique_ptr<NodalEquations<dim>> equations;
  std::unique_ptr<RigidUnknowns> rigid_unknowns;
  LinearSolver linear_solver;
  unsigned int n_solved = 0; ///< linear systems
  Teuchos::RCP<TpetraVector> increment;
  NodalVector local_increment;
  NodalVector full_weight; ///< nodal weight of the soil under full gravity, N
  NodalVector body_force;  ///< of the material points, N, at the time of the residual; empty without one
  NodalVector first_body_force, last_body_force; ///< the same at both ends of the step
  NodalVector given_sizes;                       ///< sizes of weight, body force and what follows, N, in entry dim * v
  NodalVector momentum_sizes;                    ///< of the momentum that round-off leaves over a step
  Teuchos::RCP<TpetraVector> kept_unbalanced;    ///< N: what a step need not balance of its start's residual; or null
  double weight_norm = 0.;                       ///< N: what residuals are measured by where the input asks for it
  ForceMeasure force_measure;
  std::vector<double> system_weights; ///< N: of the free points in the system of each point
  std::vector<double> system_levers;  ///< m: the largest of theirs
  std::vector<double> body_levers;    ///< m: of each point
  Eigen::VectorXd body_scale;         ///< N, N m: what residuals of the free dofs are compared with
  StepLoad load;
  std::vector<Vector6> body_increments; ///< at the last evaluation, free dofs included
  PointForces acting_points;            ///< of contact, at the last evaluation
  RigidBalance balance;                 ///< at the last evaluation, where there are free dofs
};
} // namespace kedge
