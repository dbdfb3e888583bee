// The derivative of a particle's stress as products read it: in the principal frame of its trial.
#pragma once

#include <kedge/assembly/lanes.h>
#include <kedge/assembly/point_tangents.h>

namespace kedge
{
/// Moduli of a particle with its integration volume V (N m), held in single precision as sets of dim rows of Lanes.
/// With the principal directions e_m, moved back to the start of the step by f_m = dF^-1 e_m, a gradient H of a change
/// of the increments is h_mn = e_m H f_n; moduli give the change s_mn of the stress, and the flux w_im = sum of e_ri
/// s_rc f_cm is what nodal forces come from. Isotropic laws have 21 moduli in that frame instead of 81 on the axes of
/// space.
template <int dim> class PrincipalModuli
{
public:
  using Row = typename Lanes<dim>::Type;
  static constexpr int lanes = Lanes<dim>::size, size = 5 * dim * lanes;

  KEDGE_FUNCTION explicit PrincipalModuli(const float* held_) : held(held_) {}

  /// Writes what this class reads.
  KEDGE_FUNCTION static void store(const PrincipalTangent& tangent, const double volume,
                                   const Eigen::Matrix3d& directions, const Eigen::Matrix3d& to_start, float* const to)
  {
    const Eigen::Matrix3d moved = to_start * directions;
    for (int m = 0; m < dim; ++m)
      for (int n = 0; n < lanes; ++n)
      {
        const bool used = n < dim;
        to[place(direction, m) + n] = used ? directions(n, m) : 0.;
        to[place(moved_back, m) + n] = used ? moved(m, n) : 0.;
        to[place(same, m) + n] = used ? volume * tangent.same[m][n] : 0.;
        to[place(swapped, m) + n] = used ? volume * tangent.swapped[n][m] : 0.;
        to[place(direct, m) + n] = used ? volume * tangent.direct[n][m] : 0.;
      }
  }

  /// h from H; rows of H and h are in lanes.
  KEDGE_FUNCTION void turn_gradient(const Row (&H)[dim], Row (&h)[dim]) const
  {
    for (int m = 0; m < dim; ++m)
    {
      const Row e = row(direction, m);
      Row of_direction = e[0] * H[0];
      for (int k = 1; k < dim; ++k)
        of_direction += e[k] * H[k];
      h[m] = of_direction[0] * row(moved_back, 0);
      for (int n = 1; n < dim; ++n)
        h[m] += of_direction[n] * row(moved_back, n);
    }
  }

  /// s from h, entry by entry: rows that are put together in memory would wait for their entries.
  KEDGE_FUNCTION void change_stress(const Row (&h)[dim], double (&s)[dim][dim]) const
  {
    Row normal = h[0][0] * row(direct, 0), of_same[dim], of_swapped[dim];
    for (int n = 1; n < dim; ++n)
      normal += h[n][n] * row(direct, n);
    for (int m = 0; m < dim; ++m)
    {
      of_same[m] = h[m] * row(same, m);
      of_swapped[m] = h[m] * row(swapped, m);
    }
    for (int m = 0; m < dim; ++m)
      for (int n = 0; n < dim; ++n)
        s[m][n] = m == n ? normal[m] : of_same[m][n] + of_swapped[n][m];
  }

  /// w from s.
  KEDGE_FUNCTION void turn_stress(const double (&s)[dim][dim], Row (&w)[dim]) const
  {
    Row of_direction[dim];
    for (int c = 0; c < dim; ++c)
    {
      of_direction[c] = s[0][c] * row(direction, 0);
      for (int r = 1; r < dim; ++r)
        of_direction[c] += s[r][c] * row(direction, r);
    }
    for (int m = 0; m < dim; ++m)
    {
      const Row f = row(moved_back, m);
      w[m] = f[0] * of_direction[0];
      for (int c = 1; c < dim; ++c)
        w[m] += f[c] * of_direction[c];
    }
  }

  /// Adds `factor` times A_imkn, the flux w_im of the gradient that is 1 for component k along axis n, to row (n dim +
  /// k) dim + m of `to`, for all n.
  KEDGE_FUNCTION void add_moduli(const int k, const double factor, double* const to) const
  {
    Row part[dim][dim]; // [c][d] of A = sum over c, d of f_cm f_dn part_cd, in lanes over i
    for (int c = 0; c < dim; ++c)
      for (int d = 0; d < dim; ++d)
      {
        const double along = factor * held[place(direction, d) + k];
        part[c][d] = along * held[place(direct, d) + c] * row(direction, c);
        if (c != d)
          part[c][d] += factor * held[place(direction, c) + k] * held[place(swapped, c) + d] * row(direction, d);
      }
    for (int r = 0; r < dim; ++r)
    {
      const Row e = factor * held[place(direction, r) + k] * row(direction, r), of_r = row(same, r);
      for (int c = 0; c < dim; ++c)
        part[c][c] += of_r[c] * e; // none for c = r
    }
    for (int n = 0; n < dim; ++n)
    {
      const Row f = row(moved_back, n);
      Row sum[dim];
      for (int c = 0; c < dim; ++c)
      {
        sum[c] = f[0] * part[c][0];
        for (int d = 1; d < dim; ++d)
          sum[c] += f[d] * part[c][d];
      }
      for (int m = 0; m < dim; ++m)
      {
        const Row of_m = row(moved_back, m);
        Eigen::Map<Row> moduli(to + ((n * dim + k) * dim + m) * lanes);
        Row total = moduli + of_m[0] * sum[0];
        for (int c = 1; c < dim; ++c)
          total += of_m[c] * sum[c];
        moduli = total;
      }
    }
  }

  /// Component m of f_r times e_r.
  KEDGE_FUNCTION Row dyad(const int r, const int m) const
  {
    return double(held[place(moved_back, m) + r]) * row(direction, r);
  }

private:
  /// Rows of `direction` are e_m, those of `moved_back` component m of all f_n; over n, those of `same` hold a_mnmn,
  /// those of `swapped` a_nmmn and those of `direct` a_nnmm.
  enum Set
  {
    direction,
    moved_back,
    same,
    swapped,
    direct
  };

  KEDGE_FUNCTION static constexpr int place(const Set set, const int m) { return (set * dim + m) * lanes; }
  /// A GPU reads it in one piece.
  KEDGE_FUNCTION Row row(const Set set, const int m) const
  {
    return Lanes<dim>::read(
        static_cast<const float*>(__builtin_assume_aligned(held + place(set, m), lanes * sizeof(float))));
  }

  const float* held;
};

/// What F-bar has of a particle in its cell, in single precision, in the same frame: sums over a cell's particles make
/// the change of its volume at a held pressure and that of its volume, which change the stress of them all.
template <int dim> class CellModuli
{
public:
  using Row = typename Lanes<dim>::Type;
  static constexpr int size = 8;

  KEDGE_FUNCTION explicit CellModuli(const float* held_) : held(held_) {}

  /// `volume` is the integration volume V, J = det dF.
  KEDGE_FUNCTION static void store(const PointDilation& dilation, const double volume, const double J, float* const to)
  {
    for (int m = 0; m < 3; ++m)
    {
      to[m] = m < dim ? volume * dilation.stress[m] : 0.;
      to[4 + m] = m < dim ? volume * dilation.volume[m] : 0.;
    }
    to[3] = volume * J;
    to[7] = 0.;
  }

  KEDGE_FUNCTION double stress(const int m) const { return held[m]; }
  KEDGE_FUNCTION double dilation(const int m) const { return held[4 + m]; }
  /// V J
  KEDGE_FUNCTION double volume() const { return held[3]; }

  KEDGE_FUNCTION double change_of_dilation(const Row (&h)[dim]) const
  {
    double sum = 0.;
    for (int m = 0; m < dim; ++m)
      sum += dilation(m) * h[m][m];
    return sum;
  }
  KEDGE_FUNCTION double change_of_volume(const Row (&h)[dim]) const
  {
    double sum = 0.;
    for (int m = 0; m < dim; ++m)
      sum += h[m][m];
    return volume() * sum;
  }

private:
  const float* held;
};
} // namespace kedge
