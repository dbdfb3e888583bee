// Tensors of a point. Results are built number by number, so that loops over several points become vector instructions.
#pragma once

#include <Eigen/Core>
#include <kedge/base/kokkos.h>

namespace kedge
{
/// Symmetric tensor, ordered xx yy zz xy yz xz; shears are tensor components, not engineering ones.
using SymmetricTensor = Eigen::Matrix<double, 6, 1>;

KEDGE_FUNCTION Eigen::Matrix3d full_matrix(const SymmetricTensor& s)
{
  Eigen::Matrix3d m;
  m(0, 0) = s[0];
  m(1, 1) = s[1];
  m(2, 2) = s[2];
  m(0, 1) = m(1, 0) = s[3];
  m(1, 2) = m(2, 1) = s[4];
  m(0, 2) = m(2, 0) = s[5];
  return m;
}

KEDGE_FUNCTION double determinant(const Eigen::Matrix3d& f)
{
  return f(0, 0) * (f(1, 1) * f(2, 2) - f(1, 2) * f(2, 1)) - f(0, 1) * (f(1, 0) * f(2, 2) - f(1, 2) * f(2, 0)) +
         f(0, 2) * (f(1, 0) * f(2, 1) - f(1, 1) * f(2, 0));
}

KEDGE_FUNCTION Eigen::Matrix3d inverse(const Eigen::Matrix3d& f)
{
  Eigen::Matrix3d c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
    {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      c(j, i) = f(i1, j1) * f(i2, j2) - f(i1, j2) * f(i2, j1);
    }
  const double scale = 1. / (f(0, 0) * c(0, 0) + f(0, 1) * c(1, 0) + f(0, 2) * c(2, 0));
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      c(j, i) *= scale;
  return c;
}

/// f b f^T.
KEDGE_FUNCTION SymmetricTensor push_forward(const Eigen::Matrix3d& f, const SymmetricTensor& b)
{
  double fb[3][3];
  for (int i = 0; i < 3; ++i)
  {
    fb[i][0] = f(i, 0) * b[0] + f(i, 1) * b[3] + f(i, 2) * b[5];
    fb[i][1] = f(i, 0) * b[3] + f(i, 1) * b[1] + f(i, 2) * b[4];
    fb[i][2] = f(i, 0) * b[5] + f(i, 1) * b[4] + f(i, 2) * b[2];
  }
  const auto entry = [&](const int i, const int j)
  { return fb[i][0] * f(j, 0) + fb[i][1] * f(j, 1) + fb[i][2] * f(j, 2); };
  SymmetricTensor pushed;
  pushed[0] = entry(0, 0);
  pushed[1] = entry(1, 1);
  pushed[2] = entry(2, 2);
  pushed[3] = entry(0, 1);
  pushed[4] = entry(1, 2);
  pushed[5] = entry(0, 2);
  return pushed;
}

/// Sum over m of values[m] n_m n_m^T, with n_m the columns of `directions`. Inline, so that loops over lanes become
/// vectors.
KOKKOS_FORCEINLINE_FUNCTION SymmetricTensor from_principal(const Eigen::Vector3d& values,
                                                           const Eigen::Matrix3d& directions)
{
  const auto entry = [&](const int i, const int j)
  {
    double sum = 0.;
    for (int m = 0; m < 3; ++m)
      sum += values[m] * directions(i, m) * directions(j, m);
    return sum;
  };
  SymmetricTensor s;
  s[0] = entry(0, 0);
  s[1] = entry(1, 1);
  s[2] = entry(2, 2);
  s[3] = entry(0, 1);
  s[4] = entry(1, 2);
  s[5] = entry(0, 2);
  return s;
}
} // namespace kedge
