// F-bar avoids volumetric locking: particles take the volume change of their cell (de Souza Neto et al. 1996,
// doi 10.1016/0020-7683(95)00259-6; Coombs et al. 2018, doi 10.1016/j.cma.2018.01.010).
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

/// Adds the part of the tangent that comes from the mean dilation of the cells:
/// K_ab += sum over cells of (sum_p V0 q h_a) (x) (sum_p V0 J h_b) / (sum_p V0 J), h = dF^-T grad S.
/// q_ij = moduli(p, 3 i + j) (Pa) is the change of a particle's stress per relative change of the cell's volume.
template <int dim>
void add_mean_dilation(const ParticleArrays& particles, const StencilSet& stencils, const CellGroups& cells,
                       const NodalVector& increment, const View<double* [9]>& moduli, const NodeGraph& graph,
                       const View<double*>& values);
} // namespace kedge
