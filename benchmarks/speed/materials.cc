// Time of one stress update, with and without its tangent, for each law in its plastic range.
#include <benchmark/benchmark.h>
#include <kedge/materials/material.h>
#include <random>
#include <vector>

using namespace kedge;

namespace
{
struct Point
{
  Eigen::Matrix3d increment;
  SymmetricTensor b;
};

/// Points under pressure, sheared enough that about three in four yield in the frictional laws.
std::vector<Point> sheared_points()
{
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> random(-1., 1.);
  std::vector<Point> points(1024);
  for (Point& point : points)
  {
    SymmetricTensor strain;
    for (int i = 0; i < 6; ++i)
      strain[i] = 5e-3 * (random(generator) - (i < 3 ? 0.8 : 0.));
    point.b = left_cauchy_green(strain);
    for (int i = 0; i < 9; ++i)
      point.increment(i / 3, i % 3) = (i % 4 == 0 ? 1. : 0.) + 3e-3 * random(generator);
  }
  return points;
}

Material material_of(const unsigned int law, const LawConstants& more = {})
{
  MaterialParameters parameters;
  parameters.law = law;
  parameters.poisson = 0.3;
  parameters.constants = more;
  parameters.constants.values.insert({{"yield stress", 2e4},
                                      {"undrained strength", 1e4},
                                      {"friction angle", 35.},
                                      {"dilation angle", 5.},
                                      {"cohesion", 1e3}});
  return make_material(parameters);
}

LawConstants remoulding() { return {{{"remoulded ratio", 0.3}, {"remoulding strain", 10.}}}; }
LawConstants hardening() { return {{{"hardening modulus", 1e5}}}; }
LawConstants softening()
{
  return {{{"critical friction angle", 30.}, {"critical dilation angle", 0.}, {"softening strain", 0.1}}};
}

void stress(benchmark::State& state, const Material& material)
{
  const std::vector<Point> points = sheared_points();
  double memory[Laws::max_state], next[Laws::max_state];
  initialise_state(material, {1., 0.}, memory);
  std::size_t n = 0;
  for (auto _ : state)
  {
    const Point& point = points[n++ % points.size()];
    benchmark::DoNotOptimize(update_stress(point.increment, point.b, {1e7, 0.25, memory}, material, next));
  }
}

void stress_and_tangent(benchmark::State& state, const Material& material)
{
  const std::vector<Point> points = sheared_points();
  double memory[Laws::max_state], next[Laws::max_state];
  initialise_state(material, {1., 0.}, memory);
  SpatialTangent tangent;
  std::size_t n = 0;
  for (auto _ : state)
  {
    const Point& point = points[n++ % points.size()];
    benchmark::DoNotOptimize(update_stress(point.increment, point.b, {1e7, 0.25, memory}, material, next, tangent));
    benchmark::DoNotOptimize(tangent);
  }
}

void principal_frame_alone(benchmark::State& state)
{
  const std::vector<Point> points = sheared_points();
  std::size_t n = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(principal_frame(points[n++ % points.size()].b));
}

void spatial_tangent_alone(benchmark::State& state)
{
  const std::vector<Point> points = sheared_points();
  const HenckyElasticity elasticity = material_of(law_index<Elastic>).elasticity(1e7);
  const PrincipalFrame frame = principal_frame(points[0].b);
  const Eigen::Vector3d strain = 0.5 * frame.values.array().log().matrix();
  const Response response = elastic_response<true>(strain, elasticity);
  for (auto _ : state)
    benchmark::DoNotOptimize(turn(principal_tangent(response, elasticity, strain, frame.values), frame.directions));
}
} // namespace

BENCHMARK(principal_frame_alone);
BENCHMARK(spatial_tangent_alone);
BENCHMARK_CAPTURE(stress, elastic, material_of(law_index<Elastic>));
BENCHMARK_CAPTURE(stress, von_mises, material_of(law_index<VonMises>));
BENCHMARK_CAPTURE(stress, von_mises_hardening, material_of(law_index<VonMises>, hardening()));
BENCHMARK_CAPTURE(stress, clay, material_of(law_index<Clay>));
BENCHMARK_CAPTURE(stress, clay_remoulding, material_of(law_index<Clay>, remoulding()));
BENCHMARK_CAPTURE(stress, drucker_prager, material_of(law_index<DruckerPrager>));
BENCHMARK_CAPTURE(stress, drucker_prager_softening, material_of(law_index<DruckerPrager>, softening()));
BENCHMARK_CAPTURE(stress, willam_warnke, material_of(law_index<WillamWarnke>));
BENCHMARK_CAPTURE(stress, mohr_coulomb, material_of(law_index<MohrCoulomb>));
BENCHMARK_CAPTURE(stress, mohr_coulomb_softening, material_of(law_index<MohrCoulomb>, softening()));
BENCHMARK_CAPTURE(stress_and_tangent, elastic, material_of(law_index<Elastic>));
BENCHMARK_CAPTURE(stress_and_tangent, von_mises, material_of(law_index<VonMises>));
BENCHMARK_CAPTURE(stress_and_tangent, von_mises_hardening, material_of(law_index<VonMises>, hardening()));
BENCHMARK_CAPTURE(stress_and_tangent, clay, material_of(law_index<Clay>));
BENCHMARK_CAPTURE(stress_and_tangent, clay_remoulding, material_of(law_index<Clay>, remoulding()));
BENCHMARK_CAPTURE(stress_and_tangent, drucker_prager, material_of(law_index<DruckerPrager>));
BENCHMARK_CAPTURE(stress_and_tangent, drucker_prager_softening, material_of(law_index<DruckerPrager>, softening()));
BENCHMARK_CAPTURE(stress_and_tangent, willam_warnke, material_of(law_index<WillamWarnke>));
BENCHMARK_CAPTURE(stress_and_tangent, mohr_coulomb, material_of(law_index<MohrCoulomb>));
BENCHMARK_CAPTURE(stress_and_tangent, mohr_coulomb_softening, material_of(law_index<MohrCoulomb>, softening()));
