// The laws under test with typical numbers, their yield functions written anew, and random strains.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <kedge/materials/material.h>
#include <ostream>
#include <random>
#include <string>
#include <vector>

struct Case
{
  std::string name;
  kedge::MaterialParameters parameters;
};

inline std::ostream& operator<<(std::ostream& out, const Case& c) { return out << c.name; }

constexpr double young = 1e7;
constexpr double degree = 3.14159265358979324 / 180.;

inline Case make_case(const std::string& name, const kedge::MaterialType type, const double friction,
                      const double dilation, const double cohesion, const double poisson = 0.3)
{
  kedge::MaterialParameters p;
  p.type = type;
  p.young = young;
  p.poisson = poisson;
  p.yield_stress = 2e4;
  p.friction_angle = friction;
  p.dilation_angle = dilation;
  p.cohesion = cohesion;
  return {name, p};
}

inline std::vector<Case> frictional_cases()
{
  using Type = kedge::MaterialType;
  return {make_case("drucker_prager_isochoric", Type::drucker_prager, 30., 0., 5e3),
          make_case("drucker_prager_cohesionless", Type::drucker_prager, 35., 10., 0.),
          make_case("willam_warnke_isochoric", Type::willam_warnke, 32., 0., 1e3),
          make_case("willam_warnke_cohesionless", Type::willam_warnke, 40., 8., 0., 0.2),
          make_case("mohr_coulomb_isochoric", Type::mohr_coulomb, 30., 0., 5e3),
          make_case("mohr_coulomb_associated", Type::mohr_coulomb, 25., 25., 2e3),
          make_case("mohr_coulomb_cohesionless", Type::mohr_coulomb, 40., 10., 0., 0.2)};
}

inline std::vector<Case> plastic_cases()
{
  std::vector<Case> cases = frictional_cases();
  cases.push_back(make_case("von_mises", kedge::MaterialType::von_mises, 0., 0., 0.));
  cases.push_back(make_case("tresca", kedge::MaterialType::mohr_coulomb, 0., 0., 1e4));
  return cases;
}

inline std::vector<Case> all_cases()
{
  std::vector<Case> cases = plastic_cases();
  cases.push_back(make_case("elastic", kedge::MaterialType::elastic, 0., 0., 0.));
  return cases;
}

inline std::string case_name(const testing::TestParamInfo<Case>& info) { return info.param.name; }

inline double cohesion_of(const Case& c) { return std::max(c.parameters.cohesion, 1e-7 * young); }

/// Yield function in Pa of shear strength, by the textbook's formulas for angles and invariants.
inline double yield_function(const Case& c, const Eigen::Vector3d& stress)
{
  const double sine = std::sin(c.parameters.friction_angle * degree);
  const double cosine = std::cos(c.parameters.friction_angle * degree);
  const Eigen::Vector3d deviator = (stress.array() - stress.mean()).matrix();
  const double rho = deviator.norm(), xi = stress.sum() / std::sqrt(3.);
  const double cohesion = cohesion_of(c);
  switch (c.parameters.type)
  {
    case kedge::MaterialType::von_mises:
      return std::sqrt(1.5) * rho - c.parameters.yield_stress;
    case kedge::MaterialType::drucker_prager: // q - M p - q_0 of triaxial compression
      return std::sqrt(1.5) * rho + (6. * sine * stress.mean() - 6. * cohesion * cosine) / (3. - sine);
    case kedge::MaterialType::willam_warnke:
    {
      const double e = (3. - sine) / (3. + sine);
      const double cos3 = rho > 0. ? 3. * std::sqrt(6.) * deviator.prod() / (rho * rho * rho) : 1.;
      const double theta = std::acos(std::clamp(cos3, -1., 1.)) / 3.;
      const double a = 4. * (1. - e * e) * std::pow(std::cos(theta), 2), w = 2. * e - 1.;
      const double radius =
          (2. * (1. - e * e) * std::cos(theta) + w * std::sqrt(a + 5. * e * e - 4. * e)) / (a + w * w);
      return rho - radius * (std::sqrt(3.) * cohesion - sine / cosine * xi);
    }
    case kedge::MaterialType::mohr_coulomb:
    {
      const double high = stress.maxCoeff(), low = stress.minCoeff();
      return (high - low) + (high + low) * sine - 2. * cohesion * cosine;
    }
    default:
      return -1.;
  }
}

class RandomStrain
{
public:
  explicit RandomStrain(const unsigned int seed) : generator(seed) {}

  double uniform(const double low, const double high)
  {
    return std::uniform_real_distribution<double>(low, high)(generator);
  }

  /// Between 10^low and 10^high, evenly in the logarithm.
  double magnitude(const double low, const double high) { return std::pow(10., uniform(low, high)); }

  /// Principal strains with a random part of pressure or tension.
  Eigen::Vector3d principal(const double size)
  {
    const double mean = uniform(-1.5, 0.7);
    return size * Eigen::Vector3d(mean + uniform(-1., 1.), mean + uniform(-1., 1.), mean + uniform(-1., 1.));
  }

  kedge::SymmetricTensor symmetric(const double size)
  {
    kedge::SymmetricTensor s;
    for (int i = 0; i < 6; ++i)
      s[i] = size * uniform(-1., 1.);
    return s;
  }

  Eigen::Matrix3d matrix(const double size)
  {
    Eigen::Matrix3d m;
    for (int i = 0; i < 9; ++i)
      m(i / 3, i % 3) = size * uniform(-1., 1.);
    return m;
  }

  Eigen::Matrix3d rotation()
  {
    return Eigen::Quaterniond(uniform(-1., 1.), uniform(-1., 1.), uniform(-1., 1.), uniform(-1., 1.))
        .normalized()
        .toRotationMatrix();
  }

private:
  std::mt19937 generator;
};
