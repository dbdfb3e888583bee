// The planes of the moving window: their position, how they follow the bodies, and the soil behind them.
#include "refined_mesh.h"
#include <gtest/gtest.h>
#include <kedge/mesh/window.h>

using namespace kedge;

namespace
{
/// 10 cells of 0.5 m along every axis, a body in its middle, a track with planes on the last axis alone.
template <typename Dimension> class WindowPlanes : public testing::Test
{
public:
  static constexpr int dim = Dimension::value;
  static constexpr unsigned int axis = dim - 1;

  WindowPlanes()
  {
    std::array<unsigned int, dim> cells;
    cells.fill(10);
    grid = test::make_brick<dim>(cells, 0.5);
    track.min[axis] = {FaceCondition::fixed, 0.6, Advance::positive, false};
    track.max[axis] = {FaceCondition::roller, 1.1, Advance::positive, false};
    put_body_at(2., 2.3);
  }

  void put_body_at(const double lower, const double upper)
  {
    body.lower.fill(0.9);
    body.upper.fill(4.2);
    body.lower[axis] = lower;
    body.upper[axis] = upper;
  }

  Window<dim> place() const { return place_window<dim>(track, body, grid); }
  Window<dim> follow(const Window<dim>& from) const { return advance_window<dim>(from, track, body, grid); }
  bool leaves_behind(const double x) const
  {
    std::array<double, dim> point;
    point.fill(0.1);
    point[axis] = x;
    return is_left_behind<dim>(point, place(), track, grid);
  }

  GridLayout<dim> grid;
  BoundaryTrack track;
  Extent<dim> body;
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(WindowPlanes, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(WindowPlanes, LieAtTheirDistanceRoundedOutwardToBaseCells)
{
  EXPECT_EQ(this->place().lower[this->axis], 2u); // 1.4 m, in the cell from 1 m to 1.5 m
  EXPECT_EQ(this->place().upper[this->axis], 7u); // 3.4 m, in the cell from 3 m to 3.5 m
}

TYPED_TEST(WindowPlanes, BecomeTheFacesOfTheGridWhenOff)
{
  EXPECT_EQ(this->place().lower[0], 0u);
  EXPECT_EQ(this->place().upper[0], 10u);
}

TYPED_TEST(WindowPlanes, TouchABodyThatEndsOnACellsFaceDespiteRoundOff)
{
  this->track.min[this->axis].distance = this->track.max[this->axis].distance = 0.;
  this->put_body_at(1.5 - 1e-13, 2.5 + 1e-13);
  EXPECT_EQ(this->place().lower[this->axis], 3u);
  EXPECT_EQ(this->place().upper[this->axis], 5u);
}

TYPED_TEST(WindowPlanes, StopAtTheGrid)
{
  this->put_body_at(0.2, 4.8);
  EXPECT_EQ(this->place().lower[this->axis], 0u);
  EXPECT_EQ(this->place().upper[this->axis], 10u);
}

TYPED_TEST(WindowPlanes, KeepACellOfTheGridForABodyOutsideIt)
{
  this->put_body_at(7., 8.);
  EXPECT_EQ(this->place().lower[this->axis], 9u);
}

TYPED_TEST(WindowPlanes, MoveInAllowedDirectionsOnly)
{
  const auto before = this->place();
  this->put_body_at(2.6, 2.9); // 2 m and 4 m
  EXPECT_EQ(this->follow(before).lower[this->axis], 4u);
  EXPECT_EQ(this->follow(before).upper[this->axis], 8u);
}

TYPED_TEST(WindowPlanes, StayWhereTheBodyReturns)
{
  const auto before = this->place();
  this->put_body_at(1.4, 1.7);
  EXPECT_EQ(this->follow(before), before);
}

TYPED_TEST(WindowPlanes, MoveInBothDirectionsIfAllowed)
{
  const auto before = this->place();
  this->track.min[this->axis].advance = this->track.max[this->axis].advance = Advance::both;
  this->put_body_at(1.4, 1.7); // 0.8 m and 2.8 m
  EXPECT_EQ(this->follow(before).lower[this->axis], 1u);
  EXPECT_EQ(this->follow(before).upper[this->axis], 6u);
}

TYPED_TEST(WindowPlanes, FollowDownwardAlone)
{
  const auto before = this->place();
  this->track.min[this->axis].advance = this->track.max[this->axis].advance = Advance::negative;
  this->put_body_at(2.6, 2.9);
  EXPECT_EQ(this->follow(before), before);
  this->put_body_at(1.4, 1.7);
  EXPECT_EQ(this->follow(before).lower[this->axis], 1u);
}

TYPED_TEST(WindowPlanes, StayWhereTheyWouldMeet)
{
  const auto before = this->place();
  this->track.max[this->axis].advance = Advance::negative;
  this->put_body_at(4.4, 4.7);
  EXPECT_EQ(this->follow(before), before);
}

TYPED_TEST(WindowPlanes, RemoveSoilOnlyBehindThemselves)
{
  this->track.min[this->axis].remove = true;
  EXPECT_TRUE(this->leaves_behind(0.9));
  EXPECT_FALSE(this->leaves_behind(1.1));
  EXPECT_FALSE(this->leaves_behind(3.6));
}

TYPED_TEST(WindowPlanes, AboveTheBodyRemoveSoilAboveThemselves)
{
  this->track.max[this->axis].remove = true;
  EXPECT_TRUE(this->leaves_behind(3.6));
  EXPECT_FALSE(this->leaves_behind(0.9));
}

TYPED_TEST(WindowPlanes, AreCrossedByABodyThatTheyMayNotFollow)
{
  const auto before = this->place();
  EXPECT_FALSE(reach_beyond(before, this->body, this->grid));
  this->put_body_at(0.9, 1.2);
  EXPECT_TRUE(reach_beyond(before, this->body, this->grid));
  this->put_body_at(3.4, 3.6);
  EXPECT_TRUE(reach_beyond(before, this->body, this->grid));
}

TYPED_TEST(WindowPlanes, AtTheGridsFacesAreNotCrossed)
{
  this->put_body_at(-0.1, 5.1);
  EXPECT_FALSE(reach_beyond(this->place(), this->body, this->grid));
}

TYPED_TEST(WindowPlanes, BoundTheSameLeavesAfterRefinement)
{
  constexpr int dim = TypeParam::value;
  test::RefinedMesh<dim> scene;
  Window<dim> window{{}, scene.mesh.layout().base_cells};
  window.lower[0] = 1;
  window.upper[0] = 2;
  scene.mesh.set_window(window);
  test::refine_some_cells(scene.mesh, 7);
  scene.mesh.update();
  double volume = 0.;
  for (const auto& leaf : scene.mesh.leaves().leaves)
    if (leaf.owned && scene.mesh.leaves().in_window(leaf))
    {
      volume += std::pow(leaf.size, dim);
      EXPECT_GT(leaf.lower[0], 0.29);
      EXPECT_LT(leaf.lower[0] + leaf.size, 0.61);
    }
  EXPECT_NEAR(sum_over_ranks(volume, MPI_COMM_WORLD), 0.3 * std::pow(0.6, dim - 1), 1e-12);
}
