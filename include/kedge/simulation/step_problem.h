// The nonlinear problem of one step: what has to be zero, and its derivative.
#pragma once

#include <kedge/assembly/ghost.h>
#include <kedge/assembly/inertia.h>
#include <kedge/assembly/system.h>
#include <kedge/base/report.h>
#include <kedge/basis/active_nodes.h>
#include <kedge/contact/contact.h>
#include <kedge/particles/particle_set.h>
#include <kedge/simulation/input.h>
#include <kedge/simulation/prediction.h>
#include <kedge/simulation/rigid_unknowns.h>
#include <kedge/solvers/newton.h>

namespace kedge
{
/// Fixed data of a step: basis, numbering, sparsity, contact pairs. Solving it for a body increment and a load leaves
/// the trial state in the particle arrays and the contact; nothing committed changes.
template <int dim> class StepProblem
{
public:
  struct Load
  {
    double gravity_factor = 1.;
    double step_fraction = 1.;            ///< of a requested step
    Newmark newmark;                      ///< with a dt of 0 in static stages
    bool starts_at_rest = false;          ///< the first acceleration follows from the forces, not from the particles
    bool begins_stage = false;            ///< those of the bodies are not known: other dofs may have become free
    std::vector<Vector6> body_increments; ///< prescribed, per rigid point, of the whole (possibly cut) step
  };

  /// Overlaps particles with cells, numbers the active nodes and sets up the sparsity. Collective.
  StepProblem(const Input& input, const Stage& stage, const BackgroundMesh<dim>& mesh, ParticleSet<dim>& particles,
              const Materials& materials, const RigidSystems& bodies, Contact<dim>& contact, Timings& timings);

  /// Finds equilibrium, from the prediction where that is nearer to it than rest. Collective.
  NewtonReport solve(const Load& load, const Prediction& prediction);
  /// The solution as a prediction for the next step.
  Prediction predict_next() const;

  /// Of the solution: displacement and dF of every particle, and the loads of the soil on the bodies. Collective.
  ParticleIncrements particle_increments() const;
  BodyLoads body_loads() const { return contact.loads(bodies, body_increments); }
  /// Of the solution: how all rigid points move, and what their conditions exert on them. Collective.
  const std::vector<Vector6>& rigid_increments() const { return body_increments; }
  std::vector<Vector6> reactions() const;
  /// The step as the rigid points see it.
  RigidStep rigid_step() const;

  long long n_dofs() const { return dim * nodes.n_global; }
  /// Bytes that the basis of this rank's particles takes.
  double basis_bytes() const;

private:
  void number_nodes();
  std::vector<unsigned char> find_constrained_dofs() const;
  NodePlaces find_node_places() const;
  void find_contact_pairs();
  void weigh_bodies();
  void find_first_acceleration();
  void start_from(const NewtonProblem& newton, const Prediction& prediction);
  double residual(const TpetraVector& x, TpetraVector& r);
  LinearReport solve_linearised(const TpetraVector& x, const TpetraVector& r, TpetraVector& dx, double tolerance);

  const Input& input;
  const Stage& stage;
  const BackgroundMesh<dim>& mesh;
  ParticleSet<dim>& particles;
  const Materials& materials;
  const RigidSystems& bodies;
  Contact<dim>& contact;
  Timings& timings;

  ActiveNodes nodes;
  StencilSet stencils;
  CellGroups cells; ///< of F-bar; empty without it
  GhostFaces ghost_faces;
  NodalMotion motion; ///< at the start of the step; empty in static stages
  std::unique_ptr<System> system;
  std::unique_ptr<RigidUnknowns> rigid_unknowns;
  LinearSolver linear_solver;
  Teuchos::RCP<TpetraVector> increment;
  NodalVector local_increment;
  NodalVector full_weight; ///< nodal weight of the soil under full gravity, N
  double weight_norm = 0.;
  double body_weight = 0., body_lever = 1.; ///< N, m: what residuals of free bodies are measured by
  Load load;
  std::vector<Vector6> body_increments; ///< at the last evaluation, free dofs included
  RigidBalance balance;                 ///< at the last evaluation, where there are free dofs
};
} // namespace kedge
