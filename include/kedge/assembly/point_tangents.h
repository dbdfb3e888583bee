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
  /// det dF.
  KEDGE_FUNCTION PointDilation evaluate(const unsigned int p, const double J, SpatialTangent& tangent) const
  {
    double next_state[Laws::max_state]; // not needed here
    const StressUpdate update = update_stress(trial_frame<dim>(particles, cells.volume_factor, p),
                                              {particles.young(p), particles.cell_size(p), &particles.state(p, 0)},
                                              materials(particles.layer(p)), next_state, tangent, elastic_share);
    PointDilation dilation;
    if (!cells.empty())
      share_dilation(p, J, update.stress, tangent, dilation);
    return dilation;
  }

private:
  /// With F-bar the particle's volume change J* is what brings it to the pressure of its cell, pi, which acts on the
  /// nodes as J pi. With the moduli of the stress alone, c_ijkl = a_ijkl + tau_il delta_jk, q_ij = sum_m c_ijmm / dim,
  /// t = sum_i q_ii / dim, m_kl = sum_i c_iikl / dim - t delta_kl, p the mean stress and k = t - p + J* spring, the
  /// particle's part at a held pi is
  ///   a_ijkl - q_ij delta_kl - ((q_ij - t delta_ij) / k + delta_ij) m_kl + J pi delta_ij delta_kl - s delta_il
  ///   delta_jk, s = J pi - p.
  /// The rest belongs to the cell.
  KEDGE_FUNCTION void share_dilation(const unsigned int p, const double J, const SymmetricTensor& stress,
                                     SpatialTangent& tangent, PointDilation& dilation) const
  {
    const Eigen::Matrix3d tau = full_matrix(stress);
    double q[dim][dim], m[dim][dim], t = 0.;
    for (int i = 0; i < dim; ++i)
      for (int j = 0; j < dim; ++j)
      {
        q[i][j] = m[i][j] = tau(i, j) / dim;
        for (int k = 0; k < dim; ++k)
        {
          q[i][j] += tangent(i, j, k, k) / dim;
          m[i][j] += tangent(k, k, i, j) / dim;
        }
      }
    for (int i = 0; i < dim; ++i)
      t += q[i][i] / dim;
    const double mean = mean_stress<dim>(stress), acting = J * cells.pressure(p);
    double shared = J; // J*
    for (int i = 0; i < dim; ++i)
      shared *= cells.volume_factor(p);
    const double compliance = 1. / (std::fmax(t - mean, 0.) + shared * cells.spring(p));
    for (int i = 0; i < dim; ++i)
      m[i][i] -= t;
    for (int i = 0; i < dim; ++i)
      for (int j = 0; j < dim; ++j)
      {
        const double same = i == j ? 1. : 0., flow = compliance * (q[i][j] - same * t);
        for (int k = 0; k < dim; ++k)
        {
          for (int l = 0; l < dim; ++l)
            tangent(i, j, k, l) -= (flow + same) * m[k][l];
          tangent(i, j, k, k) += same * acting - q[i][j];
        }
        tangent(i, j, j, i) -= acting - mean;
        dilation.stress[3 * i + j] = shared * flow + same * J;
        dilation.volume[3 * i + j] = same * J + shared * compliance * m[i][j];
      }
    dilation.compliance = shared * shared * compliance;
  }
};
} // namespace kedge
