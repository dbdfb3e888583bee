// A step of explicit dynamics: central differences on the nodes while the basis stands still.
#pragma once

#include <kedge/assembly/explicit_force.h>
#include <kedge/assembly/unseen_velocity.h>
#include <kedge/bodies/explicit_motion.h>
#include <kedge/steps/stable_step.h>
#include <optional>

namespace kedge
{
/// A basis step: many small time steps (velocity Verlet, that is central differences) with lumped mass, whose motion
/// refers to the mesh at its start as an implicit step's does. Positions and velocities belong to the same time at both
/// ends: were the velocities half a step late, handing them to the particles and back would feed energy to short waves.
/// The material points move, and the basis is set up anew, once it is over: total Lagrangian within the step, updated
/// Lagrangian from step to step (de Vaucorbeil, Nguyen & Hutchinson 2020, doi 10.1016/j.cma.2019.112783, keep the first
/// reference for good). Bodies move as prescribed, or by the loads of the soil and their weight (ExplicitMotion); the
/// scaling of the soil's inertia leaves theirs alone.
template <int dim> class ExplicitStep : public TrialStep<dim>
{
public:
  /// Overlaps particles with cells, numbers the active nodes and finds the stable time step. Collective.
  explicit ExplicitStep(const StepContext<dim>& context);

  /// Fails where a material point turns inside out or moves by more than three quarters of its cell. Collective.
  NewtonReport solve(const StepLoad& load) override;

  SoilIncrements soil_increments() const override;
  /// Means over the step of inertia and loads; joints as at its end.
  std::vector<Vector6> reactions() const override;
  void move_bodies(RigidSystems& committed) const override;

  long long n_dofs() const override { return dim * basis.nodes.n_global; }
  double basis_bytes() const override { return basis.bytes(); }

  const StableStep& stable_step() const { return stable; }

private:
  void lump_mass();
  RigidStep rigid_step() const;
  double duration() const; ///< of the step, s
  Eigen::Vector3d gravity() const;
  void begin();
  NodalVector project(const View<double* [3]>& quantity) const;
  NodalPlaces find_places() const;
  View<double* [3]> unseen_velocity() const;
  void find_body_force(double time);
  bool follow_forces(double time);
  void kick(double time);
  void drift(double time);
  double largest_distance_in_cells() const;

  StepContext<dim> context;
  StepBasis basis;
  NodalExchange exchange, node_exchange; ///< of dofs, and of one number per node
  View<double*> mass;                    ///< per local node, scaled, kg
  NodalVector inertia;                   ///< the same per local dof; infinite where it is held or has no mass
  NodalVector weight;                    ///< of all ranks, under full gravity, N
  NodalVector body_force;                ///< of all ranks, at the last time step, N
  bool has_body_force = false;           ///< whether it was found
  StableStep stable;
  unsigned int n_time_steps = 0; ///< of the last step

  StepLoad load;
  NodalVector start_velocity, velocity, increment, force; ///< m/s, m/s, m, N; all ranks' force
  ParticlePath path;
  std::optional<ExplicitMotion> motion; ///< of the bodies, in stages that have them
  std::vector<Vector6> body_increments; ///< up to the last evaluation
  BodyLoads impulse;                    ///< of the soil on the bodies since the start of the step, N s
};
} // namespace kedge
