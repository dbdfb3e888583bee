// The stress update of several points at once, without tangents, in the lanes of vector registers.
#pragma once

#include <kedge/materials/material.h>
#include <kedge/materials/principal_frames.h>

namespace kedge
{
/// Deformation gradients of several points, column by column.
template <int width> struct DeformationLanes
{
  double f[9][width];

  KEDGE_FUNCTION Eigen::Matrix3d matrix_of(const int l) const
  {
    Eigen::Matrix3d matrix;
    for (int i = 0; i < 9; ++i)
      matrix(i % 3, i / 3) = f[i][l];
    return matrix;
  }

  KOKKOS_FORCEINLINE_FUNCTION void push_forward(const double (&b)[6][width], double (&pushed)[6][width]) const
  {
    for (int l = 0; l < width; ++l)
    {
      SymmetricTensor own;
      for (int i = 0; i < 6; ++i)
        own[i] = b[i][l];
      own = kedge::push_forward(matrix_of(l), own);
      for (int i = 0; i < 6; ++i)
        pushed[i][l] = own[i];
    }
  }

  KOKKOS_FORCEINLINE_FUNCTION void invert()
  {
    for (int l = 0; l < width; ++l)
    {
      const Eigen::Matrix3d inverted = inverse(matrix_of(l));
      for (int i = 0; i < 9; ++i)
        f[i][l] = inverted(i % 3, i / 3);
    }
  }
};

/// What laws answer to several points, number by number. Mohr-Coulomb's fixed planes answer to all of them in vectors,
/// other laws to one after the other.
template <int width> struct StressLanes
{
  PrincipalFrames<width> trial; ///< of the trial b
  MaterialPoint point[width];
  const Material* material[width];
  double* next_state[width];
  bool admissible[width]; ///< where laws are to answer; respond() clears it where a principal value is not positive
  // the answers, as in Response
  double stress[3][width], elastic_strain[3][width], plastic_increment[width];
  Status status[width];

  /// Asks the laws, after trial.find_strains(). What is left in lanes that are not admissible has no meaning, and their
  /// state variables stay as they are.
  KEDGE_FUNCTION void respond()
  {
    bool planes = true;
    for (int l = 0; l < width; ++l)
    {
      admissible[l] = admissible[l] && trial.values[0][l] > 0. && trial.values[1][l] > 0. && trial.values[2][l] > 0.;
      planes = planes && material[l]->law == law_index<MohrCoulomb> &&
               material[l]->laws.template get<MohrCoulomb>().is_fixed();
    }
    if (planes)
      return_to_planes();
    else
      for (int l = 0; l < width; ++l)
        if (admissible[l])
          set(l, kedge::respond<false>(trial.strain_of(l), point[l], *material[l], next_state[l]));
  }

  /// b = exp(2 eps_e) of the answers.
  KEDGE_FUNCTION void find_left_cauchy_green(double (&b)[6][width]) const
  {
    double values[3][width];
    for (int i = 0; i < 3; ++i)
      map_lanes(elastic_strain[i], values[i], [](const auto& strain) { return (2. * strain).exp(); });
    trial.turn(values, b);
  }

private:
  KEDGE_FUNCTION void return_to_planes()
  {
    double lame[width], shear[width], sin_phi[width], cos_phi[width], sin_psi[width], cohesion[width], number[width];
    for (int l = 0; l < width; ++l)
    {
      const HenckyElasticity elasticity = material[l]->elasticity(point[l].young);
      const MohrPlanes planes = material[l]->laws.template get<MohrCoulomb>().planes(point[l].young);
      lame[l] = elasticity.lame;
      shear[l] = elasticity.shear;
      sin_phi[l] = planes.sin_phi;
      cos_phi[l] = planes.cos_phi;
      sin_psi[l] = planes.sin_psi;
      cohesion[l] = planes.cohesion;
    }
    for (int l = 0; l < width; ++l)
    {
      const MohrPlanes planes = {sin_phi[l], cos_phi[l], sin_psi[l], cohesion[l]};
      const MohrPlanes::Return found =
          planes.find_return({trial.strains[0][l], trial.strains[1][l], trial.strains[2][l]}, {lame[l], shear[l]});
      for (int i = 0; i < 3; ++i)
      {
        stress[i][l] = found.stress[i];
        elastic_strain[i][l] = found.elastic_strain[i];
      }
      plastic_increment[l] = found.plastic_increment;
      number[l] = found.status;
    }
    for (int l = 0; l < width; ++l)
      status[l] = static_cast<Status>(static_cast<int>(number[l]));
  }

  KEDGE_FUNCTION void set(const int l, const Response& answer)
  {
    for (int i = 0; i < 3; ++i)
    {
      stress[i][l] = answer.stress[i];
      elastic_strain[i][l] = answer.elastic_strain[i];
    }
    plastic_increment[l] = answer.plastic_increment;
    status[l] = answer.status;
  }
};
} // namespace kedge
