// What area of a surface corners of a lattice of boxes stand for.
#include "../bodies/shapes.h"
#include <algorithm>
#include <gtest/gtest.h>
#include <kedge/base/communication.h>
#include <kedge/bodies/surface.h>
#include <kedge/contact/surface_areas.h>
#include <numeric>

using namespace kedge;

namespace
{
using Eigen::Vector3d;

constexpr double box_size = 0.1;

/// A body whose upper face, 2 m square (in the plane 2 m long), passes through the origin, turned about an axis; in the
/// plane that is y.
RigidSystems tilted(const Vector3d& axis, const double angle, const unsigned int dim, const double length = 2.)
{
  RigidSystems bodies;
  bodies.points.emplace_back();
  bodies.points[0].pose.rotation = Eigen::AngleAxisd(angle, axis.normalized());
  bodies.surfaces.push_back(
      {dim == 3 ? Surface(test::box({-0.5 * length, -1., -1.}, {0.5 * length, 1., 0.}))
                : Surface(extrude_outline({{{-1., -1.}}, {{1., -1.}}, {{1., 0.}}, {{-1., 0.}}}, "outline")),
       0});
  return bodies;
}

struct Neighbours
{
  std::vector<CarryingCorner> corners;
  std::vector<SoilBox> boxes;
};

/// Boxes whose centres lie up to four sizes above the plane, over the middle of the face, and those of their corners
/// that lie less than `near` above it or at most half a size below. Each rank has every second box, in turns.
Neighbours soil_above(const RigidSystems& bodies, const unsigned int dim, const double near, const double offset)
{
  const Pose& pose = bodies.points[0].pose;
  Neighbours soil;
  const int n = 12, rank = rank_of(MPI_COMM_WORLD), ranks = size_of(MPI_COMM_WORLD);
  int number = 0;
  for (int i = -n; i < n; ++i)
    for (int j = dim == 3 ? -n : 0; j < (dim == 3 ? n : 1); ++j)
      for (int k = -n; k < n; ++k)
      {
        const double half = 0.5 * box_size;
        const Vector3d x(i * box_size + half, dim == 3 ? j * box_size + half : 0., k * box_size + half + offset);
        const Vector3d seen = pose.to_body(x);
        if (seen[2] <= 0. || seen[2] > 4. * box_size || std::max(std::abs(seen[0]), std::abs(seen[1])) > 0.5)
          continue;
        if (number++ % ranks != rank)
          continue;
        soil.boxes.push_back({{x[0], x[1], x[2]}, {half, dim == 3 ? half : 0., half}});
        for (unsigned int corner = 0; corner < (1u << dim); ++corner)
        {
          Vector3d y = x + half * Vector3d(corner & 1u ? 1. : -1., 0., corner & 2u ? 1. : -1.);
          if (dim == 3)
            y[1] += corner & 4u ? half : -half;
          const double gap = pose.to_body(y)[2];
          if (gap < near && gap >= -0.5 * box_size)
            soil.corners.push_back(
                {{y[0], y[1], y[2]}, box_size, dim == 3 ? 0.25 * box_size * box_size : 0.5 * box_size});
        }
      }
  return soil;
}

double sum_of_shares(const RigidSystems& bodies, const Neighbours& soil, const unsigned int dim)
{
  const std::vector<double> area =
      share_area(bodies, bodies.surfaces[0], soil.corners, soil.boxes, dim, MPI_COMM_WORLD);
  EXPECT_EQ(area.size(), soil.corners.size());
  return sum_over_ranks(std::accumulate(area.begin(), area.end(), 0.), MPI_COMM_WORLD);
}
} // namespace

TEST(SurfaceAreas, AreThatOfTheFaceWhateverItsDirection)
{
  for (const unsigned int dim : {2u, 3u})
    for (const double angle : {0., 0.3, M_PI / 4.})
      for (const double offset : {0., 0.027})
      {
        const RigidSystems bodies = tilted(Vector3d::UnitY(), angle, dim);
        // the soil lies over a metre of the face, by a metre; its ends are those of boxes
        EXPECT_NEAR(sum_of_shares(bodies, soil_above(bodies, dim, 0.03, offset), dim), 1., 0.13)
            << dim << "-D, " << angle << ", " << offset;
      }
}

TEST(SurfaceAreas, OfAFaceObliqueToAllAxes)
{
  const RigidSystems bodies = tilted({1., -1., 0.}, std::acos(1. / std::sqrt(3.)), 3);
  EXPECT_NEAR(sum_of_shares(bodies, soil_above(bodies, 3, 0.03, 0.01), 3), 1., 0.2);
}

TEST(SurfaceAreas, DoNotDependOnHowManyCornersCarry)
{
  const RigidSystems bodies = tilted(Vector3d::UnitY(), M_PI / 4., 2);
  const double few = sum_of_shares(bodies, soil_above(bodies, 2, 0.02, 0.), 2),
               many = sum_of_shares(bodies, soil_above(bodies, 2, 0.09, 0.), 2);
  EXPECT_NEAR(few, many, 0.1);
}

TEST(SurfaceAreas, OfLongFacetsTakeNoLonger)
{
  const RigidSystems bodies = tilted(Vector3d::UnitY(), 0., 3, 2e5); // cut all along it would make 1e8 pieces
  EXPECT_NEAR(sum_of_shares(bodies, soil_above(bodies, 3, 0.03, 0.), 3), 1., 0.13);
}

TEST(SurfaceAreas, AreNoneWhereNoSoilIs)
{
  const RigidSystems bodies = tilted(Vector3d::UnitY(), 0., 3);
  Neighbours soil = soil_above(bodies, 3, 0.03, 0.);
  for (SoilBox& box : soil.boxes)
    box.x[2] += 0.3;
  EXPECT_EQ(sum_of_shares(bodies, soil, 3), 0.);
}

TEST(SurfaceAreas, OfTheLastCornerAreBounded)
{
  const RigidSystems bodies = tilted(Vector3d::UnitY(), 0., 2);
  Neighbours soil = soil_above(bodies, 2, 0.03, 0.);
  const bool has_one = rank_of(MPI_COMM_WORLD) == 0;
  soil.corners.erase(soil.corners.begin() + std::min<std::size_t>(soil.corners.size(), has_one), soil.corners.end());
  EXPECT_NEAR(sum_of_shares(bodies, soil, 2), 3. * 0.5 * box_size, 1e-12);
}
