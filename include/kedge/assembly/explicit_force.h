// The kernels of explicit dynamics: forces along a path of many small increments, lumped mass.
#pragma once

#include <kedge/assembly/internal_force.h>

namespace kedge
{
/// State of the particles within a step of many small increments. The stress follows these one by one; it does not
/// depend on the increment of the whole step alone. The laws' state variables are kept in the particles' trial state.
struct ParticlePath
{
  View<double* [6]> pulled_back;  ///< dF^-1 b dF^-T of the elastic b, which an elastic increment does not change
  View<double* [9]> deformation;  ///< dF since the start of the step, column by column; then its inverse
  View<double*> volume_change;    ///< J = det dF
  View<double*> increment, force; ///< nodal, packed_components() a node: m, N
};

/// Numbers a node in the path's nodal vectors: as many as fill a register, so that one instruction takes them all.
constexpr int packed_components(const int dim) { return dim == 3 ? 4 : dim; }

/// Starts a path at the committed state and copies this state to the trial state. `n_nodes`: those of this rank that
/// particles see, the first ones of the nodal vectors.
ParticlePath begin_path(const ParticleArrays& particles, unsigned int dim, std::size_t n_nodes);

/// Moves every particle to the given nodal increments since the start of the step (m), writes its trial state and adds
/// its internal force (N) to `force`. The plastic increments of a path add up. Returns the number of particles of this
/// rank whose increment is not admissible; they add no force, nor does their cell.
/// With F-bar the particles of a cell share the volume change simpler than those of share_pressure(), as increments are
/// small: dF is stretched by (Jbar / J)^(1/dim), Jbar the mean of J weighted by the integration volumes V, and the
/// cell's pressure sum(V p) / sum(V J) J acts on the nodes in place of each particle's own.
template <int dim>
unsigned long advance_stress_and_force(const ParticleArrays& particles, const StencilSet& stencils,
                                       const Materials& materials, const NodalVector& increment,
                                       const ParticlePath& path, const NodalVector& force,
                                       const CellGroups& cells = {});

/// Adds m max(S_v, least share) to the mass (kg) of every local node v with S_v > 0.
void add_lumped_mass(const ParticleArrays& particles, const StencilSet& stencils, double least_share,
                     const View<double*>& mass);
} // namespace kedge
