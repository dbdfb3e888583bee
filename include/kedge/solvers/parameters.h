// What the input says about the solvers.
#pragma once

#include <optional>

namespace kedge::schema
{
template <typename T> class Section;
}

namespace kedge
{
enum class LinearSolverChoice
{
  automatic,
  iterative,
  direct
};

struct SolverParameters
{
  double tolerance = 0.;         ///< norm of the residual over that of the soil's weight; 0: forces are the measure
  double force_tolerance = 3e-4; ///< unbalanced over acting forces, by node (steps/force_measure.h)
  unsigned int max_newton_iterations = 20;
  unsigned int max_linear_iterations = 100;
  double poor_factor = 0.25;
  std::optional<double> ghost_factor; ///< 1/m2; without one the stabilisation is as strong at every level of the mesh
  double ghost_factor_mass = 0.;
  bool line_search = true;
  LinearSolverChoice linear_solver = LinearSolverChoice::automatic;
  bool reuse = true;                         ///< keep the preconditioner while that is cheaper than a new one
  double minimum_step_fraction = 1. / 4096.; ///< smallest cut of a step

  bool measures_by_weight() const { return tolerance > 0.; }
  /// Of the measure that counts.
  double target() const { return measures_by_weight() ? tolerance : force_tolerance; }
};

/// Keys of "solver".
schema::Section<SolverParameters> solver_section();
} // namespace kedge
