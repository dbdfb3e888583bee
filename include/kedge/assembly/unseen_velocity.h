// The part of the particles' velocities that no node sees.
#pragma once

#include <kedge/assembly/nodal_exchange.h>
#include <kedge/basis/stencil.h>
#include <kedge/particles/arrays.h>

namespace kedge
{
/// Where the values of a projection to the nodes belong to. At the edge of the soil a node's mean over its particles is
/// not that of a field at the node, but at the particles' centre of mass; a held dof has its value at the node itself.
struct NodalPlaces
{
  NodalVector centre, node;    ///< dim coordinates of every local node, m
  View<double*> mass;          ///< of every local node: sum over particles of m S, kg
  NodalVector inertia;         ///< of every local dof; infinite where it is held
  View<double* [3]> particles; ///< positions of the particles, m
};

/// Projected fields at the particles, R v = sum over nodes of r_v(p) value_v: the weights r_v = S_v + c.grad S_v are
/// such that a field that is linear in space comes out as it is, at edges and in cells of any filling. Where the places
/// of a particle's nodes do not allow that, the weights are zero. In the first dim components.
///
/// quantity -= R nodal; where the weights are zero, quantity = 0.
template <int dim>
void take_seen_part(const StencilSet& stencils, const NodalPlaces& places, const NodalVector& nodal,
                    const View<double* [3]>& quantity);

/// The transpose, nodal += sum over particles of m r_v quantity, kg times its unit.
template <int dim>
void add_seen_part(const ParticleArrays& particles, const StencilSet& stencils, const NodalPlaces& places,
                   const View<double* [3]>& quantity, const NodalVector& nodal);
} // namespace kedge
