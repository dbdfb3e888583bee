// The derivative of the internal force at one point of Newton's method, held by particle: products with vectors, and
// a sparse approximation of it for preconditioners.
#pragma once

#include <kedge/assembly/internal_force.h>
#include <kedge/assembly/lanes.h>
#include <kedge/basis/elements.h>

namespace kedge
{
/// With the gradient H_kn = sum over nodes of d_vk grad_n S_v of a change d of the increments, the flux w_im that the
/// moduli of a particle make of it adds w_im grad_m S_v to the force at node v (PrincipalModuli). With F-bar the
/// particles of a cell share a pressure, which depends on sums over the cell (CellModuli). Single precision: linear
/// systems are solved to 1e-8 at most, residuals stay double.
struct LinearisedForce
{
  Rows<float> moduli;   ///< by particle: PrincipalModuli
  Rows<float> cell;     ///< by particle: CellModuli; empty without F-bar
  View<float*> modulus; ///< by cell: 1 over the sum of its particles' compliances, Pa/m3; 0 in cells of one
  View<float*> spring;  ///< by cell: F-bar's spring over the cell's volume, Pa/m3; so too
  Rows<double> stress;  ///< workspace: s_mn of the particles of a cell, of all cells where threads share the work
};

/// Finds the derivative at the increments of the last stress update. For Newton's damping, yielding particles get at
/// least `elastic_share` of their elastic moduli in addition. `previous` lends its memory.
template <int dim>
LinearisedForce linearise_force(const ParticleArrays& particles, const StencilSet& stencils, const Materials& materials,
                                const CellGroups& cells, double elastic_share, LinearisedForce previous = {});

/// Adds the derivative times `direction` (m) to `force` (N).
template <int dim>
void add_linearised_force(const StencilSet& stencils, const CellGroups& cells, const LinearisedForce& derivative,
                          const NodalVector& direction, const NodalVector& force);

/// Adds the stiffness of finite elements (N/m) with the mean moduli of the soil in them to `values`. It couples the
/// nodes of each leaf only and is that of the particles for linear fields. For others it is stiffer, as it has no
/// averages over boxes.
template <int dim>
void add_element_stiffness(const Elements& elements, const CellGroups& cells, const LinearisedForce& derivative,
                           const NodeGraph& graph, const View<double*>& values);
} // namespace kedge
