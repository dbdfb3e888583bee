// What the nonlinear problems of a run leave to the next one.
#pragma once

namespace kedge
{
struct NewtonHistory
{
  double overshoots = 0.; ///< share of the problems so far whose first correction was too long; old ones count less
  double at_rest = 0.;    ///< convergence measure at x = 0 in the last problem or one before, which fades; 0: not known
};
} // namespace kedge
