#include "time_loop.h"
#include <fmt/format.h>
#include <kedge/base/exceptions.h>
#include <kedge/base/failure.h>
#include <kedge/simulation/failure_hint.h>
#include <kedge/simulation/step_load.h>

// What a run does where a step fails.

namespace kedge
{
/// Where even the smallest step fails: the forces that nothing balances at its start come first. False where that fails
/// too, has been done before this very step, or has no place.
template <int dim> bool Simulation<dim>::bring_into_balance(const Clock& clock)
{
  if (stage->stepping.type != StageType::static_ || balanced_step == step_number)
    return false;
  balanced_step = step_number;
  const auto attempt = [this](const StepLoad& load)
  {
    forget_motion();
    try
    {
      if (!step)
        prepare_step();
      const bool converged = step->solve(load).converged;
      if (converged)
        commit_step();
      return converged;
    }
    catch (const SolverError&) // the failure of the step itself is what the run ends with
    {
      rethrow_if_alone("step");
      return false;
    }
  };
  const bool balanced = balance_in_parts(clock, *stage, bodies, attempt);
  forget_motion();
  if (balanced)
    log.report().line(fmt::format("step {}: the soil was brought into balance before the load goes on", step_number));
  return balanced;
}

/// The state that a run which ends has reached.
template <int dim> void Simulation<dim>::save_what_is_there(const Clock& clock)
{
  if (log.steps_in_stage() == 0)
    return;
  write_or_warn("last output", [&] { write_output(clock, clock.steps_done(), true); });
  write_or_warn("last restart file", [&] { save_failed_state(clock); });
  write_or_warn("end of output", [&] { finish_output(); });
}

template <int dim> void Simulation<dim>::give_up(const Clock& clock, const NewtonReport& newton)
{
  save_what_is_there(clock);
  ResidualPlace residual;
  if (step && !newton.residuals.empty())
    residual = step->find_residual();
  end_stage();
  throw SolverError(describe_failure(input, stage_number, clock, newton, residual), newton.residuals);
}

template bool Simulation<2>::bring_into_balance(const Clock&);
template void Simulation<2>::save_what_is_there(const Clock&);
template void Simulation<2>::give_up(const Clock&, const NewtonReport&);
template bool Simulation<3>::bring_into_balance(const Clock&);
template void Simulation<3>::save_what_is_there(const Clock&);
template void Simulation<3>::give_up(const Clock&, const NewtonReport&);
} // namespace kedge
