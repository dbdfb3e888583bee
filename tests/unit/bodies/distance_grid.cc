#include "shapes.h"
#include <gtest/gtest.h>
#include <kedge/bodies/distance_grid.h>
#include <random>

using namespace kedge;

TEST(DistanceGrid, BoundsTheDistanceFromBelow)
{
  const auto from_sphere = [](const Eigen::Vector3d& x) { return x.norm() - 0.6; };
  const Eigen::Vector3d lower(-1., -1., -0.5), upper(1., 1., 2.);
  const DistanceGrid whole(lower, upper, 8000, from_sphere);
  const DistanceCells grid = whole.cells();
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> share(0., 1.);
  double loosest = 0.;
  for (unsigned int i = 0; i < 20000; ++i)
  {
    Eigen::Vector3d x;
    for (int d = 0; d < 3; ++d)
      x[d] = lower[d] + share(generator) * (upper[d] - lower[d]);
    const double exact = std::max(0., from_sphere(x)), bound = grid.least_distance(x);
    ASSERT_LE(bound, exact);
    loosest = std::max(loosest, exact - bound);
  }
  EXPECT_LT(loosest, 0.2); // cells of 0.108 m: twice half a diagonal
  EXPECT_EQ(grid.least_distance({0., 0., 3.}), 0.);
  EXPECT_EQ(grid.least_distance(Eigen::Vector3d::Constant(std::nan(""))), 0.);
}

/// The same answers before and after the grid is set up, which takes thousands of queries.
TEST(Surface, AnswersTheSameHoweverOftenItIsAsked)
{
  const Surface surface(test::angle_section());
  const auto [lower, upper] = surface.bounds();
  std::mt19937 generator(2);
  std::uniform_real_distribution<double> share(-0.1, 1.1), within(0., 0.2);
  unsigned int n_far = 0;
  for (unsigned int i = 0; i < 60000; ++i)
  {
    Eigen::Vector3d x;
    for (int d = 0; d < 3; ++d)
      x[d] = lower[d] + share(generator) * (upper[d] - lower[d]);
    const double distance = within(generator) * (upper - lower).norm();
    const ClosestPoint expected = surface.closest_point(x);
    const auto found = surface.closest_point_within(x, distance);
    ASSERT_EQ(found.has_value(), expected.gap <= distance) << i;
    ASSERT_EQ(surface.is_within(x, distance), expected.gap <= distance) << i;
    if (found)
    {
      ASSERT_EQ(found->gap, expected.gap);
    }
    else
      ++n_far;
  }
  EXPECT_GT(n_far, 1000u);
}
