// Bodies that pass through each other.
#include "rigid_fixtures.h"
#include "shapes.h"
#include <kedge/bodies/passage.h>

namespace kedge
{
namespace
{
using namespace test;
using Eigen::Vector3d;

/// Unit cubes or squares in systems of their own, at these positions of their lower corners.
RigidSystems squares_at(const std::vector<double>& x, const unsigned int dim)
{
  RigidSystems systems;
  for (const double left : x)
  {
    systems.first_point.push_back(systems.points.size());
    systems.points.emplace_back(point_at({left, 0., 0.}, true), std::array<double, 3>{}, dim);
    systems.surfaces.push_back(
        {Surface(dim == 3 ? box(Vector3d::Zero(), Vector3d::Ones())
                          : extrude_outline({{{0., 0.}}, {{1., 0.}}, {{1., 1.}}, {{0., 1.}}}, "outline")),
         static_cast<unsigned int>(systems.points.size() - 1)});
  }
  return systems;
}

TEST(Passage, IsFoundOnceBodiesOverlap)
{
  for (const unsigned int dim : {2u, 3u})
  {
    RigidSystems systems = squares_at({0., 1., 5.}, dim); // the first two lie against each other
    const PassageWatch watch(systems, dim);
    EXPECT_FALSE(watch.find(systems));
    systems.points[2].pose.position[0] = 1.99;
    systems.points[2].pose.position[2] = 0.3;
    const auto through = watch.find(systems);
    ASSERT_TRUE(through) << dim;
    EXPECT_EQ(*through, std::make_pair(1u, 2u));
  }
}

TEST(Passage, IsMeantWhereBodiesOverlapFromTheStart)
{
  RigidSystems systems = squares_at({0., 0.5}, 2);
  const PassageWatch watch(systems, 2);
  systems.points[1].pose.position[0] = 0.6;
  EXPECT_FALSE(watch.find(systems));
}
} // namespace
} // namespace kedge
