// The moduli of single particles, with what F-bar makes of them.
#pragma once

#include <kedge/assembly/deformation.h>
#include <kedge/assembly/volume_average.h>

namespace kedge
{
/// Evaluates the tangents of particles at the increment of the last stress update.
template <int dim> struct PointTangents
{
  ParticleArrays particles;
  StencilSet stencils;
  Materials materials;
  CellGroups cells;     ///< empty without F-bar
  double elastic_share; ///< of their elastic moduli that yielding particles have at least

  /// Writes the particle's own moduli to `tangent`; what belongs to its cell is returned, unset without F-bar. `J` is
  /// det dF. Both in the principal frame of the trial.
  KEDGE_FUNCTION PointDilation evaluate(const unsigned int p, const double J, PrincipalTangent& tangent) const
  {
    double next_state[Laws::max_state]; // not needed here
    update_stress(trial_frame<dim>(particles, cells.volume_factor, p),
                  {particles.young(p), particles.cell_size(p), &particles.state(p, 0)}, materials(particles.layer(p)),
                  next_state, tangent, elastic_share);
    PointDilation dilation;
    if (!cells.empty())
      share_dilation(p, J, tangent, dilation);
    return dilation;
  }

private:
  /// With F-bar the particle's volume change J* is what brings it to the pressure of its cell, pi, which acts on the
  /// nodes as J pi. With the moduli of the stress alone, c_ijkl = a_ijkl + tau_il delta_jk, q_m = sum_n c_mmnn / dim,
  /// t = sum_m q_m / dim, r_n = sum_m c_mmnn / dim - t, p the mean stress and k = t - p + J* spring, the particle's
  /// part at a held pi is
  ///   a_ijkl + J pi delta_ij delta_kl - s delta_il delta_jk, s = J pi - p,
  /// and in a_mmnn less q_m + ((q_m - t) / k + 1) r_n. The rest belongs to the cell.
  KEDGE_FUNCTION void share_dilation(const unsigned int p, const double J, PrincipalTangent& tangent,
                                     PointDilation& dilation) const
  {
    double q[dim], r[dim], t = 0., mean = 0.;
    for (int m = 0; m < dim; ++m)
    {
      q[m] = r[m] = tangent.stress[m] / dim;
      mean += tangent.stress[m] / dim;
    }
    for (int m = 0; m < dim; ++m)
      for (int n = 0; n < dim; ++n)
      {
        q[m] += tangent.direct[m][n] / dim;
        r[n] += tangent.direct[m][n] / dim;
      }
    for (int m = 0; m < dim; ++m)
      t += q[m] / dim;
    const double acting = J * cells.pressure(p);
    double shared = J; // J*
    for (int i = 0; i < dim; ++i)
      shared *= cells.volume_factor(p);
    dilation.compliance = 1. / (std::fmax(t - mean, 0.) + shared * cells.spring(p));
    for (int m = 0; m < dim; ++m)
      r[m] -= t;
    for (int m = 0; m < dim; ++m)
    {
      const double flow = dilation.compliance * (q[m] - t);
      for (int n = 0; n < dim; ++n)
      {
        tangent.direct[m][n] += acting - q[m] - (flow + 1.) * r[n];
        tangent.swapped[m][n] -= m == n ? 0. : acting - mean;
      }
      tangent.direct[m][m] -= acting - mean;
      dilation.stress[m] = shared * flow + J;
      dilation.volume[m] = shared * dilation.compliance * r[m] + J;
    }
    dilation.compliance *= shared * shared;
  }
};
} // namespace kedge
