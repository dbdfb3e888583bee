// Soil and bodies with what a step needs beside them.
#pragma once

#include "../soil_fixture.h"
#include <kedge/steps/implicit_step.h>

namespace kedge::test
{
template <int dim> struct StepFixture : SoilFixture<dim>
{
  using SoilFixture<dim>::SoilFixture;

  StepContext<dim> context() { return {gravity, Basis::gimp, solver, stage, this->soil, bodies, timings}; }

  /// Makes the solution of a step the state from which the next one starts.
  void commit(const TrialStep<dim>& step)
  {
    const SoilIncrements increments = step.soil_increments();
    step.move_bodies(bodies);
    this->soil.commit(increments, stage.rigid_bodies ? &bodies : nullptr);
    this->soil.forget_prediction();
  }

  static SolverParameters tight()
  {
    SolverParameters parameters;
    parameters.tolerance = 1e-6; // of the weight
    return parameters;
  }

  std::array<double, 3> gravity{};
  SolverParameters solver = tight();
  Stage stage;
  RigidSystems bodies;
  Timings timings;
};
} // namespace kedge::test
