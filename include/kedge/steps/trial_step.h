// One step of a stage, whatever its method: what it is given, what it answers.
#pragma once

#include <kedge/assembly/internal_force.h>
#include <kedge/base/report.h>
#include <kedge/bodies/rigid_balance.h>
#include <kedge/particles/expressions.h>
#include <kedge/soil/soil.h>
#include <kedge/solvers/newton.h>
#include <kedge/solvers/parameters.h>
#include <kedge/steps/stage.h>
#include <kedge/time/newmark.h>

namespace kedge
{
/// A linear system of Newton's method that is to be written to a file (replay/saved_step.h).
struct SystemToSave
{
  std::string path;
  unsigned int iteration = 1; ///< of the step, from 1
  bool is_done = false;
};

/// What a step works on. It reads the committed state and leaves its trial state in the particles' arrays and in the
/// contact.
template <int dim> struct StepContext
{
  const std::array<double, 3>& gravity; ///< m/s2; in 2-D [x, z]
  Basis basis;
  const SolverParameters& solver;
  const Stage& stage;
  Soil<dim>& soil;
  const RigidSystems& bodies; ///< at the start of the step
  Timings& timings;
  const BodyForce<dim>* body_force = nullptr; ///< on the soil beside gravity, or none
  bool replaces_soil = false;                 ///< the bodies have just taken the place of soil (wished in place)
  SystemToSave* saves = nullptr;              ///< or none
};

/// What acts during a step.
struct StepLoad
{
  double gravity_factor = 1.;
  double start_time = 0., end_time = 0.; ///< of the step in its stage: s, or a fraction of the load
  double step_fraction = 1.;             ///< of a requested step
  double share_balanced = 1.;            ///< of the forces that nothing balances at the start (static steps)
  Newmark newmark;                       ///< with a dt of 0 in static and explicit stages
  NewtonHistory history;                 ///< of the steps before
  bool begins_stage = false;             ///< accelerations follow from the forces: other dofs may have become free
  std::vector<Vector6> body_increments;  ///< prescribed, per rigid point, of the whole (possibly cut) step
};

/// Where a step is farthest from balance, and what surrounds it: the points within a cell's size along every axis.
struct ResidualPlace
{
  std::vector<double> position; ///< of the node, dim coordinates, m; empty: nothing is known
  double cell_size = 0.;        ///< m
  double share = 0.;            ///< of the forces at the node that is not balanced
  double gap = 0.;              ///< to the nearest body, m; infinite beyond three cells
  double filled = 0.;           ///< share of that neighbourhood that soil takes
  double yielding = 0.;         ///< share of its points that yield in the step
  double unstressed = 0.;       ///< share of its points that carry next to no stress
  bool bodies_dominate = false; ///< free bodies are farther from balance than any node
};

/// A step can be solved again for another load (a shorter one after a cut); nothing committed changes.
template <int dim> class TrialStep
{
public:
  virtual ~TrialStep() = default;

  /// Goes from the committed state to the end of the step. Collective.
  virtual NewtonReport solve(const StepLoad& load) = 0;
  /// Of the solution: what it does to the soil, for Soil::commit. Collective.
  virtual SoilIncrements soil_increments() const = 0;
  /// Of the solution: what the conditions of all rigid points exert on them. Collective.
  virtual std::vector<Vector6> reactions() const = 0;
  /// Takes the points that the step started from to its end.
  virtual void move_bodies(RigidSystems& committed) const = 0;

  /// Of the last solve(), which failed. Collective.
  virtual ResidualPlace find_residual() { return {}; }

  virtual long long n_dofs() const = 0;
  /// Bytes that the basis of this rank's particles takes.
  virtual double basis_bytes() const = 0;
};
} // namespace kedge
