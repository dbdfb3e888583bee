// F-bar avoids volumetric locking: particles share the volume change of their cell (de Souza Neto et al. 1996,
// doi 10.1016/0020-7683(95)00259-6; Coombs et al. 2018, doi 10.1016/j.cma.2018.01.010), and the nodal forces are those
// that do the work of this volume change: only the cell's pressure acts on the nodes (Simo, Taylor & Pister 1985,
// doi 10.1016/0045-7825(85)90033-7).
#pragma once

#include <kedge/assembly/internal_force.h>

namespace kedge
{
/// Mean of the dim normal components of a Kirchhoff stress, Pa.
template <int dim> KEDGE_FUNCTION double mean_stress(const SymmetricTensor& stress)
{
  double sum = 0.;
  for (int i = 0; i < dim; ++i)
    sum += stress[i];
  return sum / dim;
}

/// The stress with `mean` in place of the mean of its dim normal components.
template <int dim> KEDGE_FUNCTION SymmetricTensor with_mean_stress(SymmetricTensor stress, const double mean)
{
  const double shift = mean - mean_stress<dim>(stress);
  for (int i = 0; i < dim; ++i)
    stress[i] += shift;
  return stress;
}

/// Distributes the volume change of every cell over its particles such that they come to one pressure. With J = det dF
/// of a particle, V its integration volume and p the mean of the dim normal components of its Kirchhoff stress, the
/// volume changes J* that the laws see keep the cell's volume and have p one pressure pi,
///   sum V J* = sum V J,  p(J*) / J* - o + spring (ln J* - ln Jbar) = pi,
/// o the particle's distance from the cell's mean at the start of the step, so soil at rest keeps its gradients, and
/// Jbar = sum V J / sum V. The spring, a thousandth of the elastic modulus, gives an answer where particles are at the
/// apex, whose pressure does not depend on their volume. This is a mixed formulation with a constant pressure in each
/// cell whose unknowns are eliminated at once: soil that dilates is not softened at those particles of a cell that
/// dilate most, as it is where they share J itself.
/// Follows deform(). Newton's method, exact in few iterations where the law is piecewise linear. Writes the factors (J*
/// / J)^(1/dim), which stretch dF, and pi to the cells. Where a particle has J <= 0, or no pressure is found, nothing
/// is shared.
template <int dim>
void share_pressure(const ParticleArrays& particles, const StencilSet& stencils, const CellGroups& cells,
                    const Materials& materials);

/// Brings the mean stress of every particle in soil that flows half of the distance nearer to that of its cell, trial
/// stress and strain alike. Differences within a cell act on no node, so nothing else would take them away, and they
/// would travel.
void relax_pressure(const ParticleArrays& particles, const StencilSet& stencils, const CellGroups& cells,
                    const Materials& materials);

/// The spring of share_pressure() over the elastic modulus.
constexpr double least_dilation_modulus = 1e-3;

/// How a particle and its cell's pressure depend on each other. Stress and volume are diagonal in the principal frame
/// of the trial, dim numbers used.
struct PointDilation
{
  double stress[3];  ///< change of the acting stress per pressure of the cell
  double volume[3];  ///< change of volume at a held pressure with the displacement gradient
  double compliance; ///< change of volume per pressure of the cell, 1/Pa
};

/// The same for all particles, on the axes of space.
struct DilationModuli
{
  View<double*[6]> stress, volume;
  View<double*> compliance;
};

/// Adds the part of the tangent that comes from the pressure of the cells at the increment of the last deform(), with h
/// = dF^-T grad S: K_ab += sum over cells of Q_a (x) R_b / sum_p V compliance - spring / W v_a (x) v_b, Q = sum_p V
/// stress h, R = sum_p V volume h, v = sum_p V J h, W = sum_p V J.
template <int dim>
void add_mean_dilation(const ParticleArrays& particles, const StencilSet& stencils, const CellGroups& cells,
                       const DilationModuli& moduli, const NodeGraph& graph, const View<double*>& values);
} // namespace kedge
