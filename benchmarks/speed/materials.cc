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

Material material_of(const MaterialType type)
{
  MaterialParameters parameters;
  parameters.type = type;
  parameters.poisson = 0.3;
  parameters.yield_stress = 2e4;
  parameters.friction_angle = 35.;
  parameters.dilation_angle = 5.;
  parameters.cohesion = 1e3;
  return make_material(parameters);
}

void stress(benchmark::State& state, const MaterialType type)
{
  const std::vector<Point> points = sheared_points();
  const Material material = material_of(type);
  std::size_t n = 0;
  for (auto _ : state)
  {
    const Point& point = points[n++ % points.size()];
    benchmark::DoNotOptimize(update_stress(point.increment, point.b, 1e7, material));
  }
}

void stress_and_tangent(benchmark::State& state, const MaterialType type)
{
  const std::vector<Point> points = sheared_points();
  const Material material = material_of(type);
  SpatialTangent tangent;
  std::size_t n = 0;
  for (auto _ : state)
  {
    const Point& point = points[n++ % points.size()];
    benchmark::DoNotOptimize(update_stress(point.increment, point.b, 1e7, material, tangent));
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
  const HenckyElasticity elasticity = material_of(MaterialType::elastic).elasticity(1e7);
  const PrincipalFrame frame = principal_frame(points[0].b);
  const Eigen::Vector3d strain = 0.5 * frame.values.array().log().matrix();
  const Response response = elastic_response<true>(strain, elasticity);
  for (auto _ : state)
    benchmark::DoNotOptimize(spatial_tangent(response, elasticity, strain, frame));
}
} // namespace

BENCHMARK(principal_frame_alone);
BENCHMARK(spatial_tangent_alone);
BENCHMARK_CAPTURE(stress, elastic, MaterialType::elastic);
BENCHMARK_CAPTURE(stress, von_mises, MaterialType::von_mises);
BENCHMARK_CAPTURE(stress, drucker_prager, MaterialType::drucker_prager);
BENCHMARK_CAPTURE(stress, willam_warnke, MaterialType::willam_warnke);
BENCHMARK_CAPTURE(stress, mohr_coulomb, MaterialType::mohr_coulomb);
BENCHMARK_CAPTURE(stress_and_tangent, elastic, MaterialType::elastic);
BENCHMARK_CAPTURE(stress_and_tangent, von_mises, MaterialType::von_mises);
BENCHMARK_CAPTURE(stress_and_tangent, drucker_prager, MaterialType::drucker_prager);
BENCHMARK_CAPTURE(stress_and_tangent, willam_warnke, MaterialType::willam_warnke);
BENCHMARK_CAPTURE(stress_and_tangent, mohr_coulomb, MaterialType::mohr_coulomb);
