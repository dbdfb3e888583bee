// A material point under strain along z and stress across it.
#pragma once

#include "cases.h"

struct Element
{
  /// Under the isotropic stress `pressure` (Pa, negative in compression).
  Element(const Case& c, const double pressure)
      : material(kedge::make_material(c.parameters)),
        state(initial_state(c)),
        elastic_strain(material.elasticity(young).strain(Eigen::Vector3d::Constant(pressure))),
        stress(Eigen::Vector3d::Constant(pressure))
  {
  }

  /// Adds to the logarithmic strain along z and finds the equal strains along x and y by Newton, for the stress
  /// `lateral` (Pa) there.
  void strain_along_z(const double increment, const double lateral)
  {
    solve([&](const double across) { return Eigen::Vector3d(across, across, increment); }, [&](const kedge::Response& r)
          { return std::make_pair(r.stress[0] - lateral, r.tangent(0, 0) + r.tangent(0, 1)); });
  }

  /// Shears in the x-z plane, by `increment` of the engineering shear strain and at the mean stress `mean` of x and z;
  /// the strain along y stays.
  void shear(const double increment, const double mean)
  {
    solve([&](const double across) { return Eigen::Vector3d(across + 0.5 * increment, 0., across - 0.5 * increment); },
          [&](const kedge::Response& r)
          {
            const Eigen::Vector3d d = r.tangent.col(0) + r.tangent.col(2);
            return std::make_pair(0.5 * (r.stress[0] + r.stress[2]) - mean, 0.5 * (d[0] + d[2]));
          });
  }

  double shear_stress() const { return 0.5 * (stress[0] - stress[2]); }

  kedge::Material material;
  State state;
  double size = cell_size; ///< of the cell, m
  Eigen::Vector3d elastic_strain, stress;
  Eigen::Vector3d strain = Eigen::Vector3d::Zero(); ///< total, since the start

private:
  template <typename Strains, typename Residual> void solve(const Strains& strains, const Residual& residual)
  {
    double x = 0.;
    Answer answer;
    for (int i = 0; i < 30; ++i)
    {
      answer = respond((elastic_strain + strains(x)).eval(), state, material, size);
      const auto [rest, slope] = residual(answer);
      x -= rest / slope;
      if (std::abs(rest / slope) < 1e-17)
        break;
    }
    answer = respond((elastic_strain + strains(x)).eval(), state, material, size);
    strain += strains(x);
    elastic_strain = answer.elastic_strain;
    stress = answer.stress;
    state = answer.next;
  }
};
