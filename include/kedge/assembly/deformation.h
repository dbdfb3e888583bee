// Deformation of the particles in a trial, found once for all that needs it.
#pragma once

#include <kedge/assembly/kernels.h>

namespace kedge
{
/// Writes dF of the nodal increment (dim per local node, m) and the principal frame of dF b dF^T to the particles'
/// trial_deformation and trial_frame. The values of the frame are zero where det dF <= 0 or is not a number; with
/// dim = 2, direction 2 is across the plane.
template <int dim>
void deform(const ParticleArrays& particles, const StencilSet& stencils, const View<double*>& increment);

/// Principal frame of the trial b of particle p, as deform() has left it, with the volume change of F-bar: that of dF
/// stretched by the factor of the particle. Without factors it is that of dF.
template <int dim>
KEDGE_FUNCTION PrincipalFrame trial_frame(const ParticleArrays& particles, const View<double*>& factor,
                                          const unsigned int p)
{
  PrincipalFrame frame;
  for (int i = 0; i < 3; ++i)
    frame.values[i] = particles.trial_frame(p, i);
  for (int i = 0; i < 9; ++i)
    frame.directions(i % 3, i / 3) = particles.trial_frame(p, 3 + i);
  if (factor.extent(0) > 0)
    for (int i = 0; i < dim; ++i)
      frame.values[i] *= factor(p) * factor(p);
  return frame;
}
} // namespace kedge
