// The longest stable time step of explicit dynamics.
#pragma once

#include <kedge/steps/step_basis.h>

namespace kedge
{
/// Below these times (s) central differences are stable: that of soil and contact springs, and of the soil alone.
struct StableStep
{
  double all = 0., soil = 0.;
};

/// Masses on the nodes, and how ranks add them up.
struct LumpedMass
{
  const NodalExchange &of_dofs, &of_nodes;
  View<double*> mass;  ///< per local node, scaled, kg
  NodalVector inertia; ///< the same per local dof; infinite where it is held or has no mass
};

/// Least part of its mass that a point gives a node.
double least_share(Basis basis);

/// 2 over the largest circular frequency. Where many time steps are to follow, the soil's is found to a few percent;
/// else its bound, for nothing, has to do. Collective.
template <int dim>
StableStep find_stable_step(const StepContext<dim>& context, const StepBasis& basis, const LumpedMass& lumped);
} // namespace kedge
