// How rigid bodies couple with the soil through contact: columns and rows that border the nodal matrix.
#pragma once

#include <kedge/assembly/system.h>
#include <kedge/contact_forces/evaluation.h>
#include <kedge/solvers/border.h>

namespace kedge
{
/// Velocity and spin (world axes) of a rigid point while an unknown of it grows by one per second.
struct RigidRate
{
  unsigned int point;
  Vector6 direction;
};

/// Columns (derivatives of internal less contact forces by the rigid unknowns) and rows (of the bodies' balance by the
/// nodal displacements) at the last evaluation of contact; no corner. Collective.
Border contact_border(const ContactArrays& contact, const SurfaceMotions& surfaces, const std::vector<RigidRate>& rates,
                      const System& system);
} // namespace kedge
