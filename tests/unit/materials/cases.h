// The laws under test with typical numbers, their yield functions written anew, and random strains and states.
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

  double operator[](const kedge::LawKey& key) const { return parameters.constants[key]; }
  template <typename Law> bool is() const { return parameters.law == kedge::law_index<Law>; }
};

inline std::ostream& operator<<(std::ostream& out, const Case& c) { return out << c.name; }

constexpr double young = 1e7, cell_size = 0.25;
constexpr double degree = 3.14159265358979324 / 180.;

template <typename Law>
Case make_case(const std::string& name, const std::map<std::string, double>& constants = {}, const double poisson = 0.3)
{
  kedge::MaterialParameters p;
  p.law = kedge::law_index<Law>;
  p.young = young;
  p.poisson = poisson;
  p.constants.values = constants;
  return {name, p};
}

template <typename Law>
Case frictional_case(const std::string& name, const double friction, const double dilation, const double cohesion,
                     const double poisson = 0.3)
{
  return make_case<Law>(name, {{"friction angle", friction}, {"dilation angle", dilation}, {"cohesion", cohesion}},
                        poisson);
}

template <typename Law>
Case softening_case(const std::string& name, const double friction, const double dilation, const double cohesion,
                    const double critical_friction, const double critical_dilation)
{
  Case c = frictional_case<Law>(name, friction, dilation, cohesion);
  c.parameters.constants.values["critical friction angle"] = critical_friction;
  c.parameters.constants.values["critical dilation angle"] = critical_dilation;
  c.parameters.constants.values["softening strain"] = 4.;
  c.parameters.constants.values["shear band width"] = 0.1;
  return c;
}

struct State
{
  double value[kedge::Laws::max_state] = {};
};

/// A response with the state after it.
struct Answer : kedge::Response
{
  State next;
};

template <bool with_tangent = true>
Answer respond(const Eigen::Vector3d& trial_strain, const State& state, const kedge::Material& material,
               const double cell = cell_size)
{
  State next = state;
  const kedge::MaterialPoint point{young, cell, state.value};
  return {kedge::respond<with_tangent>(trial_strain, point, material, next.value), next};
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

inline double least_cohesion(const Case& c) { return std::max(c[kedge::law_keys::cohesion], 1e-7 * young); }

/// The sine of an angle that falls from `peak` to `critical`, where that is given.
inline double sine_now(const Case& c, const kedge::LawKey& peak, const kedge::LawKey& critical, const State& state)
{
  using namespace kedge::law_keys;
  if (!c.parameters.constants.has(softening_strain))
    return std::sin(c[peak] * degree);
  const double last = std::sin((c.parameters.constants.has(critical) ? c[critical] : c[peak]) * degree);
  const double strain = c[softening_strain] * c[shear_band_width] / cell_size;
  return last + (std::sin(c[peak] * degree) - last) * std::exp(-3. * state.value[0] / strain);
}
inline double friction_now(const Case& c, const State& state)
{
  return sine_now(c, kedge::law_keys::friction_angle, kedge::law_keys::critical_friction_angle, state);
}
inline double dilation_now(const Case& c, const State& state)
{
  return sine_now(c, kedge::law_keys::dilation_angle, kedge::law_keys::critical_dilation_angle, state);
}

inline Eigen::Vector3d deviator_of(const Eigen::Vector3d& v) { return (v.array() - v.mean()).matrix(); }

/// What the tests know of a law. One without it does not compile.
/// - cases(): materials with the law.
/// - yield(): yield function in Pa of shear strength, by the textbook's formulas for angles and invariants.
/// - random_state(): a state that the law may have.
/// - plastic_shear(): the part of the state that accumulates, and what one unit of Response::plastic_increment adds.
/// - volume(): that a plastic strain should bring, for the sine of the dilation angle.
template <typename Law> struct UnderTest;

struct IsochoricUnderTest
{
  static double volume(const Eigen::Vector3d&, double) { return 0.; }
};

template <> struct UnderTest<kedge::Elastic> : IsochoricUnderTest
{
  static std::vector<Case> cases() { return {make_case<kedge::Elastic>("elastic")}; }
  static double yield(const Case&, const Eigen::Vector3d&, const State&) { return -1.; }
  static State random_state(const Case&, RandomStrain&) { return {}; }
};

template <> struct UnderTest<kedge::VonMises> : IsochoricUnderTest
{
  static std::vector<Case> cases()
  {
    return {make_case<kedge::VonMises>("von_mises", {{"yield stress", 2e4}}),
            make_case<kedge::VonMises>("von_mises_hardening", {{"yield stress", 2e4}, {"hardening modulus", 2e6}})};
  }
  static double yield(const Case& c, const Eigen::Vector3d& stress, const State& state)
  {
    return std::sqrt(1.5) * deviator_of(stress).norm() - c[kedge::law_keys::yield_stress] -
           c[kedge::law_keys::hardening_modulus] * state.value[0];
  }
  static State random_state(const Case&, RandomStrain& random) { return {{random.uniform(0., 0.01)}}; }
  static constexpr unsigned int accumulated = 0;
  static constexpr double per_increment = 1.;
};

template <> struct UnderTest<kedge::Clay> : IsochoricUnderTest
{
  static std::vector<Case> cases()
  {
    return {
        make_case<kedge::Clay>("clay", {{"undrained strength", 1e4}}),
        make_case<kedge::Clay>("clay_remoulding",
                               {{"undrained strength", 1e4}, {"remoulded ratio", 0.3}, {"remoulding strain", 0.5}})};
  }
  static double yield(const Case& c, const Eigen::Vector3d& stress, const State& state)
  {
    const double delta = c[kedge::law_keys::remoulded_ratio];
    const double left = delta < 1. ? std::exp(-3. * state.value[1] / c[kedge::law_keys::remoulding_strain]) : 1.;
    return deviator_of(stress).norm() / std::sqrt(2.) - state.value[0] * (delta + (1. - delta) * left);
  }
  static State random_state(const Case&, RandomStrain& random)
  {
    return {{random.uniform(5e3, 2e4), random.uniform(0., 1.)}};
  }
  static constexpr unsigned int accumulated = 1;
  static constexpr double per_increment = 1.7320508075688772;
};

struct SofteningUnderTest
{
  static State random_state(const Case&, RandomStrain& random) { return {{random.uniform(0., 2.)}}; }
  static constexpr unsigned int accumulated = 0;
  static constexpr double per_increment = 1.7320508075688772;
};

template <> struct UnderTest<kedge::DruckerPrager> : SofteningUnderTest
{
  static std::vector<Case> cases()
  {
    using Law = kedge::DruckerPrager;
    return {frictional_case<Law>("drucker_prager_isochoric", 30., 0., 5e3),
            frictional_case<Law>("drucker_prager_cohesionless", 35., 10., 0.),
            softening_case<Law>("drucker_prager_softening", 40., 12., 1e3, 32., 0.)};
  }
  /// q - M p - q_0 of triaxial compression.
  static double yield(const Case& c, const Eigen::Vector3d& stress, const State& state)
  {
    const double sine = friction_now(c, state), cosine = std::sqrt(1. - sine * sine);
    return std::sqrt(1.5) * deviator_of(stress).norm() +
           (6. * sine * stress.mean() - 6. * least_cohesion(c) * cosine) / (3. - sine);
  }
  static double volume(const Eigen::Vector3d& plastic, const double sine)
  {
    return std::sqrt(3.) * deviator_of(plastic).norm() * 2. * std::sqrt(2.) * sine / (3. - sine);
  }
};

template <> struct UnderTest<kedge::WillamWarnke>
{
  static std::vector<Case> cases()
  {
    using Law = kedge::WillamWarnke;
    return {frictional_case<Law>("willam_warnke_isochoric", 32., 0., 1e3),
            frictional_case<Law>("willam_warnke_cohesionless", 40., 8., 0., 0.2)};
  }
  static double yield(const Case& c, const Eigen::Vector3d& stress, const State& state)
  {
    const double sine = friction_now(c, state), cosine = std::sqrt(1. - sine * sine);
    const Eigen::Vector3d deviator = deviator_of(stress);
    const double rho = deviator.norm(), xi = stress.sum() / std::sqrt(3.);
    const double e = (3. - sine) / (3. + sine);
    const double cos3 = rho > 0. ? 3. * std::sqrt(6.) * deviator.prod() / (rho * rho * rho) : 1.;
    const double theta = std::acos(std::clamp(cos3, -1., 1.)) / 3.;
    const double a = 4. * (1. - e * e) * std::pow(std::cos(theta), 2), w = 2. * e - 1.;
    const double radius = (2. * (1. - e * e) * std::cos(theta) + w * std::sqrt(a + 5. * e * e - 4. * e)) / (a + w * w);
    return rho - radius * (std::sqrt(3.) * least_cohesion(c) - sine / cosine * xi);
  }
  static State random_state(const Case&, RandomStrain&) { return {}; }
  static double volume(const Eigen::Vector3d& plastic, const double sine)
  {
    return std::sqrt(3.) * deviator_of(plastic).norm() * sine / std::sqrt(1. - sine * sine);
  }
};

template <> struct UnderTest<kedge::MohrCoulomb> : SofteningUnderTest
{
  static std::vector<Case> cases()
  {
    using Law = kedge::MohrCoulomb;
    return {frictional_case<Law>("mohr_coulomb_isochoric", 30., 0., 5e3),
            frictional_case<Law>("mohr_coulomb_associated", 25., 25., 2e3),
            frictional_case<Law>("mohr_coulomb_cohesionless", 40., 10., 0., 0.2),
            frictional_case<Law>("tresca", 0., 0., 1e4),
            softening_case<Law>("mohr_coulomb_softening", 40., 12., 0., 32., 0.),
            softening_case<Law>("mohr_coulomb_softening_cohesive", 35., 30., 4e3, 30., 0.)};
  }
  static double yield(const Case& c, const Eigen::Vector3d& stress, const State& state)
  {
    const double sine = friction_now(c, state), cosine = std::sqrt(1. - sine * sine);
    const double high = stress.maxCoeff(), low = stress.minCoeff();
    return (high - low) + (high + low) * sine - 2. * least_cohesion(c) * cosine;
  }
  /// Strains of both signs: the sum of all multipliers is half of the 1-norm.
  static double volume(const Eigen::Vector3d& plastic, const double sine) { return sine * plastic.lpNorm<1>(); }
};

inline std::vector<Case> all_cases()
{
  std::vector<Case> cases;
  kedge::Laws::for_each(
      [&](const auto tag)
      {
        for (const Case& c : UnderTest<typename decltype(tag)::type>::cases())
          cases.push_back(c);
      });
  return cases;
}

/// Those for which a condition holds.
template <typename Condition> std::vector<Case> cases_where(const Condition& condition)
{
  std::vector<Case> cases;
  for (const Case& c : all_cases())
    if (condition(c))
      cases.push_back(c);
  return cases;
}
inline bool is_frictional(const Case& c) { return c[kedge::law_keys::friction_angle] > 0.; }
inline std::vector<Case> plastic_cases()
{
  return cases_where([](const Case& c) { return !c.is<kedge::Elastic>(); });
}
inline std::vector<Case> frictional_cases() { return cases_where(is_frictional); }
inline std::vector<Case> remembering_cases()
{
  return cases_where([](const Case& c) { return kedge::make_material(c.parameters).n_state > 0; });
}

inline std::string case_name(const testing::TestParamInfo<Case>& info) { return info.param.name; }

inline double yield_function(const Case& c, const Eigen::Vector3d& stress, const State& state)
{
  double value = 0.;
  kedge::Laws::visit(c.parameters.law,
                     [&](const auto tag) { value = UnderTest<typename decltype(tag)::type>::yield(c, stress, state); });
  return value;
}

inline double plastic_volume(const Case& c, const Eigen::Vector3d& plastic, const State& state)
{
  double value = 0.;
  kedge::Laws::visit(c.parameters.law, [&](const auto tag)
                     { value = UnderTest<typename decltype(tag)::type>::volume(plastic, dilation_now(c, state)); });
  return value;
}

/// A state that the case may have, zero where it has no memory.
inline State random_state(const Case& c, RandomStrain& random)
{
  State state;
  if (kedge::make_material(c.parameters).n_state > 0)
    kedge::Laws::visit(c.parameters.law, [&](const auto tag)
                       { state = UnderTest<typename decltype(tag)::type>::random_state(c, random); });
  return state;
}

/// The state of a new point 2 m below the surface.
inline State initial_state(const Case& c)
{
  State state;
  kedge::initialise_state(kedge::make_material(c.parameters), {2., 4e4}, state.value);
  return state;
}
