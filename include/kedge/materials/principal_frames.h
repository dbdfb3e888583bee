// The principal frames of several tensors at once, in the lanes of vector registers.
#pragma once

#include <kedge/materials/hencky.h>

namespace kedge
{
/// So many points find their frames and stresses together, on the host in the lanes of two of the longest vector
/// registers: one computes while the other waits for its last result.
constexpr int points_together = device_is_host ? 16 : 1;

// a false alarm of GCC 12 about its own AVX-512 intrinsics, bug 105593
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
/// to = function(from), the function being one of Eigen's, which takes logarithms and exponentials in vectors.
template <int width, typename Function>
KEDGE_FUNCTION void map_lanes(const double (&from)[width], double (&to)[width], const Function& function)
{
  using Numbers = Eigen::Array<double, width, 1>;
  const Eigen::Map<const Numbers> argument(from);
  Eigen::Map<Numbers> result(to);
  result = function(argument);
}
#pragma GCC diagnostic pop

/// Several tensors and their frames, number by number, which is the layout of vector registers.
template <int width> struct PrincipalFrames
{
  double tensor[6][width], values[3][width], directions[3][3][width], strains[3][width];

  KEDGE_FUNCTION void find()
  {
    for (int l = 0; l < width; ++l)
      set(l, principal_frame_of({tensor[0][l], tensor[1][l], tensor[2][l], tensor[3][l], tensor[4][l], tensor[5][l]}));
  }

  /// Of left Cauchy-Green tensors, after find(): their principal logarithmic strains. Logarithms of numbers that are
  /// not positive are no numbers.
  KEDGE_FUNCTION void find_strains()
  {
    for (int i = 0; i < 3; ++i)
      map_lanes(values[i], strains[i], [](const auto& value) { return 0.5 * value.log(); });
  }

  KEDGE_FUNCTION Eigen::Vector3d strain_of(const int l) const
  {
    return Eigen::Vector3d(strains[0][l], strains[1][l], strains[2][l]);
  }

  /// The tensors of the same directions with these principal values.
  KOKKOS_FORCEINLINE_FUNCTION void turn(const double (&principal)[3][width], double (&result)[6][width]) const
  {
    for (int l = 0; l < width; ++l)
    {
      Eigen::Matrix3d axes;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          axes(i, j) = directions[i][j][l];
      const SymmetricTensor s =
          from_principal(Eigen::Vector3d(principal[0][l], principal[1][l], principal[2][l]), axes);
      for (int i = 0; i < 6; ++i)
        result[i][l] = s[i];
    }
  }

  KEDGE_FUNCTION void set(const int l, const SymmetricTensor& s)
  {
    for (int i = 0; i < 6; ++i)
      tensor[i][l] = s[i];
  }

  KEDGE_FUNCTION SymmetricTensor tensor_of(const int l) const
  {
    SymmetricTensor s;
    for (int i = 0; i < 6; ++i)
      s[i] = tensor[i][l];
    return s;
  }

  KEDGE_FUNCTION void set(const int l, const PrincipalFrame& frame)
  {
    for (int i = 0; i < 3; ++i)
    {
      values[i][l] = frame.values[i];
      for (int j = 0; j < 3; ++j)
        directions[i][j][l] = frame.directions(i, j);
    }
  }

  KEDGE_FUNCTION PrincipalFrame frame_of(const int l) const
  {
    PrincipalFrame frame;
    for (int i = 0; i < 3; ++i)
    {
      frame.values[i] = values[i][l];
      for (int j = 0; j < 3; ++j)
        frame.directions(i, j) = directions[i][j][l];
    }
    return frame;
  }
};
} // namespace kedge
