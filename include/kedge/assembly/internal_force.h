// The kernels over particles: stress, internal force, tangent, weight.
#pragma once

#include <array>
#include <kedge/assembly/nodal_exchange.h>
#include <kedge/basis/cell_groups.h>
#include <kedge/materials/material.h>
#include <kedge/particles/arrays.h>

namespace kedge
{
/// Computes every particle's trial state from the nodal increments (m) and adds its internal force (N) to `force`:
/// f_v += V0 tau grad_x S_v, grad_x S = dF^-T grad S (Charlton, Coombs & Augarde 2017). Returns the number of particles
/// of this rank whose increment is not admissible (det dF <= 0); they add no force. Here and below, `cells` turn F-bar
/// on: the particles of a cell then share its volume change and one pressure (volume_average.h).
template <int dim>
unsigned long update_stress_and_force(const ParticleArrays& particles, const StencilSet& stencils,
                                      const Materials& materials, const NodalVector& increment,
                                      const NodalVector& force, const CellGroups& cells = {});

/// Adds the consistent tangent d f / d increment (N/m) of all particles to `values`, laid out by `graph`, at the
/// increments of the last stress update; without F-bar, of the last deform() (deformation.h). For Newton's damping,
/// yielding particles get at least `elastic_share` of their elastic moduli in addition.
template <int dim>
void add_tangent(const ParticleArrays& particles, const StencilSet& stencils, const Materials& materials,
                 const NodeGraph& graph, const View<double*>& values, const CellGroups& cells = {},
                 double elastic_share = 0.);

/// Adds factor * m S_v g (N) to `force`.
template <int dim>
void add_weight(const ParticleArrays& particles, const StencilSet& stencils, const std::array<double, 3>& gravity,
                double factor, const NodalVector& force);

/// Sum over nodes of S_v x_v at every particle.
View<double* [3]> interpolate_to_particles(const StencilSet& stencils, const NodalVector& x);

/// Displacement and dF of every particle for given nodal increments; with F-bar dF as the last stress update, which
/// must be that of the same increments, has stretched it.
template <int dim>
ParticleIncrements interpolate_increments(const ParticleArrays& particles, const StencilSet& stencils,
                                          const NodalVector& increment, const CellGroups& cells = {});
} // namespace kedge
