// Bodies that begin on the soil's surface.
#pragma once

#include <kedge/soil/soil.h>

namespace kedge
{
/// Moves all bodies vertically by one amount so that their lowest surface point rests on the soil as it is now: on the
/// highest domain below the box around all surfaces, also outside the window. Soil that has settled under its weight
/// lies lower than it was drawn. False without soil there, where the bodies stay. Collective.
template <int dim> bool place_on_soil(RigidSystems& bodies, const Soil<dim>& soil);
} // namespace kedge
