// F-bar avoids volumetric locking: particles take the volume change of their cell (de Souza Neto et al. 1996,
// doi 10.1016/0020-7683(95)00259-6; Coombs et al. 2018, doi 10.1016/j.cma.2018.01.010), and the nodal forces are those
// that do the work of this volume change: only the cell's mean pressure acts on the nodes (Simo, Taylor & Pister 1985,
// doi 10.1016/0045-7825(85)90033-7).
#pragma once

#include <kedge/assembly/internal_force.h>

namespace kedge
{
/// Factor (Jbar / J)^(1/dim) that stretches dF of every particle: J = det dF, and Jbar is the mean of J over the
/// particles of its cell, weighted by V0. A particle with J <= 0 counts in no mean and keeps its dF. Empty if `cells`
/// is.
template <int dim>
View<double*> find_volume_factors(const ParticleArrays& particles, const StencilSet& stencils, const CellGroups& cells,
                                  const NodalVector& increment);

/// What must be added to the dim normal components of the Kirchhoff stress of every particle (Pa) so that its nodal
/// forces do the work of the shared volume change: J sum(V p) / sum(V J) - p over the particles of its cell, p the mean
/// of these components and V the integration volume. Reads the trial stress of the same increment. Zero for a particle
/// with J <= 0; empty if `cells` is.
template <int dim>
View<double*> find_pressure_shifts(const ParticleArrays& particles, const StencilSet& stencils, const CellGroups& cells,
                                   const NodalVector& increment);

/// Adds the internal force (N) of the trial stress with these shifts.
template <int dim>
void add_force_of_shared_pressure(const ParticleArrays& particles, const StencilSet& stencils, const CellGroups& cells,
                                  const NodalVector& increment, const NodalVector& force);

/// Brings the mean stress of every particle in soil that flows half of the distance nearer to that of its cell, trial
/// stress and strain alike. Differences within a cell act on no node, so nothing else would take them away, and they
/// would travel.
void relax_pressure(const ParticleArrays& particles, const StencilSet& stencils, const CellGroups& cells,
                    const Materials& materials);

/// How a particle's stress, less its mean, and its mean stress answer to dilation, Pa.
struct DilationModuli
{
  View<double* [9]> stress; ///< change of stress per dilation of the cell, less its mean; row-major, dim x dim used
  View<double* [9]>
      pressure;       ///< change of the mean stress with the displacement gradient at a held dilation of the cell
  View<double*> bulk; ///< change of the mean stress per dilation of the cell
};

/// Adds the part of the tangent that comes from the mean dilation and pressure of the cells, with h = dF^-T grad S,
/// v = sum_p V J h, W = sum_p V J, Q = sum_p V stress h, R = sum_p V pressure h, s = sum_p V (bulk - p):
/// K_ab += sum over cells of (Q_a (x) v_b + v_a (x) R_b + (s / W) v_a (x) v_b) / W.
template <int dim>
void add_mean_dilation(const ParticleArrays& particles, const StencilSet& stencils, const CellGroups& cells,
                       const NodalVector& increment, const DilationModuli& moduli, const NodeGraph& graph,
                       const View<double*>& values);
} // namespace kedge
