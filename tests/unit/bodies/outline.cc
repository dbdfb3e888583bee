// Prisms with the outlines of bodies in plane strain.
#include "shapes.h"
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <kedge/base/exceptions.h>

namespace kedge
{
namespace
{
using Eigen::Vector3d;

TEST(Outline, EitherDirectionGivesTheSamePrism)
{
  const TriangleMesh left = extrude_outline({{0., 0.}, {2., 0.}, {2., 1.}, {0., 1.}}, "outline");
  const TriangleMesh right = extrude_outline({{0., 1.}, {2., 1.}, {2., 0.}, {0., 0.}}, "outline");
  EXPECT_NEAR(mass_properties(left).volume, mass_properties(right).volume, 1e-12);
  const ClosestPoint above = Surface(left).closest_point({1., 0., 1.5});
  EXPECT_NEAR(above.gap, 0.5, 1e-15);
  EXPECT_NEAR((above.normal - Vector3d::UnitZ()).norm(), 0., 1e-15);
}

/// Round-off makes corners of both kinds of the points along a slanted side.
TEST(Outline, SlantedSidesMayHaveManyPoints)
{
  const std::vector<std::vector<Eigen::Vector2d>> shapes{
      {{0., 0.}, {1., 0.}, {0.3, 0.9}},
      {{0., 0.}, {2., 0.}, {2., 1.}, {1., 1.}, {1., 2.}, {0., 2.}},
      {{0., 0.}, {3., 0.}, {3., 2.}, {2., 2.}, {2., 1.}, {1., 1.}, {1., 2.}, {0., 2.}}};
  for (const auto& corners : shapes)
    for (int turn = 0; turn < 40 * 6; ++turn)
    {
      const int degrees = 9 * (turn / 6), parts = turn % 6 + 1;
      const Eigen::Rotation2Dd turned(degrees * M_PI / 180.);
      std::vector<std::array<double, 2>> outline;
      for (std::size_t i = 0; i < corners.size(); ++i)
        for (int k = 0; k < parts; ++k)
        {
          const double along = static_cast<double>(k) / parts;
          const Eigen::Vector2d x = turned * ((1. - along) * corners[i] + along * corners[(i + 1) % corners.size()]) +
                                    Eigen::Vector2d(1.7, 3.1);
          outline.push_back({x[0], x[1]});
        }
      ASSERT_NO_THROW(extrude_outline(outline, "outline")) << degrees << " degrees, " << parts << " parts";
    }
}

TEST(Outline, QueriesInThePlaneStayInThePlane)
{
  const Surface surface(test::angle_section());
  test::RandomPoints random(-1., 3.);
  for (int i = 0; i < 1000; ++i)
  {
    Vector3d x = random();
    x[1] = 0.;
    const ClosestPoint closest = surface.closest_point(x);
    EXPECT_NEAR(closest.point[1], 0., 1e-14);
    EXPECT_NEAR(closest.normal[1], 0., 1e-12);
  }
}

TEST(Outline, RoundedConvexCornersTouchBothSides)
{
  // The corner at [1, 1] is concave and stays.
  const std::vector<std::array<double, 2>> angle = {{0., 0.}, {2., 0.}, {2., 1.}, {1., 1.}, {1., 2.}, {0., 2.}};
  const double r = 0.25;
  for (const bool reversed : {false, true})
  {
    std::vector<std::array<double, 2>> outline = angle;
    if (reversed)
      std::reverse(outline.begin(), outline.end());
    const auto rounded = round_outline(outline, r, "outline");
    EXPECT_EQ(rounded.size(), 5u * 5u + 1u); // a quarter turn has four chords
    EXPECT_EQ(std::count(rounded.begin(), rounded.end(), angle[3]), 1);
    for (const auto& x : rounded)
      if (x[0] < r && x[1] < r)
      {
        EXPECT_NEAR(std::hypot(x[0] - r, x[1] - r), r, 1e-14);
      }
    // Each corner loses the square of r less a quarter of a regular polygon of 16 sides.
    const TriangleMesh mesh = extrude_outline(rounded, "outline");
    const double lost = 5. * r * r * (1. - 2. * std::sin(M_PI / 8.));
    EXPECT_NEAR(mass_properties(mesh).volume / 16., 3. - lost, 1e-12);
    EXPECT_NEAR(sharpest_corner_radius(rounded), r, 0.02 * r);
  }
}

TEST(Outline, ArcsMayUseUpWholeSides)
{
  const auto rounded = round_outline({{0., 0.}, {2., 0.}, {2., 2.}, {0., 2.}}, 1., "outline");
  EXPECT_EQ(rounded.size(), 16u);
  for (const auto& x : rounded)
    EXPECT_NEAR(std::hypot(x[0] - 1., x[1] - 1.), 1., 1e-14);
  EXPECT_EQ(round_outline({{0., 0.}, {1., 0.}, {0., 1.}}, 0., "outline").size(), 3u);
  EXPECT_THROW(round_outline({{0., 0.}, {1., 0.}, {0., 1.}, {0., 0.}}, 0.1, "outline"), InputError);
}

TEST(Outline, SidesTooShortForTheirArcsAreRefused)
{
  try
  {
    round_outline({{0., 0.}, {4., 0.}, {4., 1.}, {0., 1.}}, 0.6, "rigid bodies[0].outline[1]");
    FAIL();
  }
  catch (const InputError& error)
  {
    EXPECT_EQ(error.path, "rigid bodies[0].outline[1].edge radius");
    EXPECT_NE(std::string(error.what()).find("from [4, 0] to [4, 1], 1 m long, is too short"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("at most 0.5"), std::string::npos);
  }
}

TEST(Outline, BadOutlinesAreRefused)
{
  EXPECT_THROW(extrude_outline({{0., 0.}, {1., 0.}}, "outline"), InputError);
  EXPECT_THROW(extrude_outline({{0., 0.}, {1., 0.}, {1., 0.}, {1., 1.}}, "outline"), InputError);
  EXPECT_THROW(extrude_outline({{0., 0.}, {1., 0.}, {1., 1e-12}, {1., 1.}}, "outline"), InputError);
  EXPECT_THROW(extrude_outline({{0., 0.}, {1., 1.}, {1., 0.}, {0., 1.}}, "outline"), InputError);
  EXPECT_THROW(extrude_outline({{0., 0.}, {1., 0.}, {2., 0.}}, "outline"), InputError);
  // a corner on another side, a corner on another corner, a side that folds back
  EXPECT_THROW(extrude_outline({{0., 0.}, {2., 0.}, {2., 1.}, {1., 0.}, {0., 1.}}, "outline"), InputError);
  EXPECT_THROW(extrude_outline({{0., 0.}, {1., 1.}, {2., 0.}, {2., 2.}, {1., 1.}, {0., 2.}}, "outline"), InputError);
  EXPECT_THROW(extrude_outline({{0., 0.}, {2., 0.}, {1., 0.}, {1., 1.}}, "outline"), InputError);
}
} // namespace
} // namespace kedge
