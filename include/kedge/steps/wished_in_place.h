// The start of bodies that take the place of soil.
#pragma once

#include <kedge/steps/step_basis.h>

namespace kedge
{
/// Corners that are inside a body take their depth for the surface, and the bodies carry what the soil has carried that
/// they replace: contact forces that balance stress and weight of the rest as far as pressure and friction can. Without
/// them soil without cohesion falls apart before it has moved as far as the springs need. Where gravity grows from zero
/// nothing is carried yet. Collective.
template <int dim> void replace_soil(const StepContext<dim>& context, const StepBasis& basis);
} // namespace kedge
