// The consistent spatial tangent of an isotropic law in principal Hencky strains.
#pragma once

#include <kedge/materials/response.h>

namespace kedge
{
/// The moduli a_ijkl with which the nodal force f_ai = V0 tau_ij G_aj, G_a = grad_x S_a on the current configuration,
/// changes: d f_ai = V0 G_aj a_ijkl G_bl d u_bk. All 81 numbers (Pa), stored as value[l][j][i][k]: position
/// ((l*3 + j)*3 + i)*3 + k, so that the contraction with a node's gradient is three long vectors added.
struct SpatialTangent
{
  double value[81];

  KEDGE_FUNCTION double operator()(const int i, const int j, const int k, const int l) const
  {
    return value[((l * 3 + j) * 3 + i) * 3 + k];
  }

  /// T_ijk = a_ijkl G_l, stored as contracted[(j*3 + i)*3 + k].
  KEDGE_FUNCTION void contract(const double (&gradient)[3], double (&contracted)[27]) const
  {
    for (int n = 0; n < 27; ++n)
      contracted[n] = value[n] * gradient[0] + value[27 + n] * gradient[1] + value[54 + n] * gradient[2];
  }
};

/// (strain_i - strain_j) / (b_i - b_j) for eigenvalues b of a left Cauchy-Green tensor and strain = ln(b) / 2. Equal
/// artanh(h) / (h (b_i + b_j)) with h = (b_i - b_j) / (b_i + b_j): its series where h is small.
KEDGE_FUNCTION double logarithmic_chord(const double strain_i, const double strain_j, const double b_i,
                                        const double b_j)
{
  const double sum = b_i + b_j, difference = b_i - b_j;
  if (std::fabs(difference) > 1e-2 * sum)
    return (strain_i - strain_j) / difference;
  const double h = difference / sum, h2 = h * h;
  return (1. + h2 * (1. / 3. + h2 * (1. / 5. + h2 * (1. / 7.)))) / sum;
}

/// The moduli in the principal frame of the trial left Cauchy-Green tensor, where only 21 entries differ from zero
/// (Pa).
struct PrincipalTangent
{
  double direct[3][3];  ///< a_mmnn
  double same[3][3];    ///< a_mnmn, m != n
  double swapped[3][3]; ///< a_mnnm, m != n
  double stress[3];     ///< tau_m
};

/// a_ijkl = 1/2 (D : L : B)_ijkl - tau_il delta_jk (de Souza Neto, Peric & Owen 2008, ch. 14). With D_mn being d tau_m
/// / d strain_n and g_mn = (tau_m - tau_n) / (b_m - b_n):
///   a_mmnn = D_mn - tau_m delta_mn,  a_mnmn = g_mn b_n,  a_mnnm = g_mn b_m - tau_m  (m != n).
/// The response's residual stiffness is added as that fraction of the elastic law's D and g.
KEDGE_FUNCTION PrincipalTangent principal_tangent(const Response& response, const HenckyElasticity& elasticity,
                                                  const Eigen::Vector3d& trial_strain, const Eigen::Vector3d& b)
{
  const double residual_lame = response.residual_stiffness * elasticity.lame;
  const double residual_shear = response.residual_stiffness * 2. * elasticity.shear;
  PrincipalTangent tangent;
  for (int m = 0; m < 3; ++m)
    for (int n = 0; n < 3; ++n)
      tangent.direct[m][n] = response.tangent(m, n) + residual_lame;
  for (int m = 0; m < 3; ++m)
  {
    tangent.stress[m] = response.stress[m];
    tangent.direct[m][m] += residual_shear - response.stress[m];
    tangent.same[m][m] = tangent.swapped[m][m] = 0.;
    const int n = m == 2 ? 0 : m + 1;
    const double g = (response.shear_stiffness[m] + residual_shear) *
                     logarithmic_chord(trial_strain[m], trial_strain[n], b[m], b[n]);
    tangent.same[m][n] = g * b[n];
    tangent.same[n][m] = g * b[m];
    tangent.swapped[m][n] = g * b[m] - response.stress[m];
    tangent.swapped[n][m] = g * b[n] - response.stress[n];
  }
  return tangent;
}

/// All moduli on the axes of space; the columns of q are the directions of the principal frame.
KEDGE_FUNCTION SpatialTangent turn(const PrincipalTangent& moduli, const Eigen::Matrix3d& q)
{
  const auto& [direct, same, swapped, stress] = moduli;

  // Turned in two halves: (i, k) through the products of directions, then j and l one after the other.
  double product[3][3][9]; // product[p][r][ik] = Q_ip Q_kr
  for (int p = 0; p < 3; ++p)
    for (int r = 0; r < 3; ++r)
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
          product[p][r][i * 3 + k] = q(i, p) * q(k, r);

  double half[3][3][9]; // half[r][p][ik] = a_ipkr: i, k global, j = p and l = r principal
  for (int r = 0; r < 3; ++r)
    for (int p = 0; p < 3; ++p)
      if (p == r)
      {
        const int s = (p + 1) % 3, t = (p + 2) % 3;
        for (int n = 0; n < 9; ++n)
          half[r][p][n] =
              direct[p][p] * product[p][p][n] + same[s][p] * product[s][s][n] + same[t][p] * product[t][t][n];
      }
      else
        for (int n = 0; n < 9; ++n)
          half[r][p][n] = direct[p][r] * product[p][r][n] + swapped[r][p] * product[r][p][n];

  double turned[3][27]; // turned[r][j*9 + ik]
  for (int r = 0; r < 3; ++r)
    for (int j = 0; j < 3; ++j)
      for (int n = 0; n < 9; ++n)
        turned[r][j * 9 + n] = q(j, 0) * half[r][0][n] + q(j, 1) * half[r][1][n] + q(j, 2) * half[r][2][n];

  SpatialTangent tangent;
  for (int l = 0; l < 3; ++l)
    for (int n = 0; n < 27; ++n)
      tangent.value[l * 27 + n] = q(l, 0) * turned[0][n] + q(l, 1) * turned[1][n] + q(l, 2) * turned[2][n];
  return tangent;
}
} // namespace kedge
