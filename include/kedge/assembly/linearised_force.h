// The derivative of the internal force at one point of Newton's method, held by particle: products with vectors, and
// a sparse approximation of it for preconditioners.
#pragma once

#include <kedge/assembly/internal_force.h>
#include <kedge/assembly/lanes.h>
#include <kedge/basis/elements.h>

namespace kedge
{
/// With the gradient H_kn = sum over nodes of d_vk grad_n S_v of a change d of the increments, the flux
/// w_im = A_imkn H_kn adds w_im grad_m S_v to the force at node v; A (N m) contains the integration volume and dF^-1.
/// With F-bar the particles of a cell have the flux s_im c sum(r H) - g v_im sum(v H) in addition, the sums over the
/// cell. Single precision: linear systems are solved to 1e-8 at most, residuals stay double. Rows fill SIMD
/// registers (Lanes); their idle lanes are zero.
struct LinearisedForce
{
  Rows<float> moduli;   ///< by particle: A_imkn in row (n dim + k) dim + m
  Rows<float> cell;     ///< by particle: s_im, v_im in rows m, dim + m; r_kn, v_kn in rows k of two more sets; or empty
  View<float*> modulus; ///< by cell: c, 1 over the sum of its particles' compliances, Pa/m3; 0 in cells of one
  View<float*> spring;  ///< by cell: g, Pa/m3; so too
  Rows<double> flux;    ///< workspace by particle: w_im in row m
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
