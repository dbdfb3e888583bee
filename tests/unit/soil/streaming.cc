// Soil that flows into cells finer than those it comes from, and soil that bodies replace.
#include "../bodies/shapes.h"
#include "../soil_fixture.h"
#include <gtest/gtest.h>

using namespace kedge;

namespace
{
template <typename Dimension> class FlowingSoil : public testing::Test, public test::SoilFixture<Dimension::value>
{
public:
  static constexpr int dim = Dimension::value;

  FlowingSoil() : test::SoilFixture<dim>(layout(), test::layers_of({test::elastic_layer(0.8)}))
  {
    adaptivity.type = AdaptivityType::rigid_body_surface;
    adaptivity.element_size = 0.1;
    RefinedBox box;
    box.min.fill(0.);
    box.max.fill(1.6);
    box.min[0] = 0.8;
    box.element_size = 0.1;
    adaptivity.boxes = {box};
    bodies.points.emplace_back();
    bodies.points[0].pose.position = {100., 0., 0.};
    bodies.surfaces.push_back({Surface(test::box({-0.1, -50., -0.1}, {0.1, 50., 0.1})), 0});
  }

  static GridLayout<dim> layout()
  {
    std::array<unsigned int, dim> cells;
    cells.fill(4);
    GridLayout<dim> grid = test::make_brick<dim>(cells, 0.4, 0.5);
    grid.finest_size = 0.1;
    return grid;
  }

  /// Puts two bodies in place of the one, each between two places along x.
  void put_walls(const std::array<std::array<double, 2>, 2>& ends)
  {
    bodies.points[0].pose.position = {0., 0., 0.};
    bodies.surfaces.clear();
    for (const auto& [from, to] : ends)
      bodies.surfaces.push_back({Surface(test::box({from, -50., -1.}, {to, 50., 2.})), 0});
  }

  /// Of all ranks: particles wider than sqrt(2) times their cell over the points per axis.
  long long count_wide() const
  {
    long long wide = 0;
    for (std::size_t p = 0; p < this->particles.ids().size(); ++p)
    {
      double volume = 1.;
      for (const double half : this->particles.half_widths()[p])
        volume *= 2. * half;
      const double size = this->mesh.leaves().leaves[this->particles.leaves()[p]].size;
      wide += std::pow(volume, 1. / dim) > std::sqrt(2.) * size / 2. * (1. + 1e-9);
    }
    return sum_over_ranks(wide, MPI_COMM_WORLD);
  }

  RigidSystems bodies;
  Adaptivity adaptivity;
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(FlowingSoil, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(FlowingSoil, IsSplitBeforeEveryStep)
{
  this->soil.adapt(this->bodies, this->adaptivity);
  EXPECT_FALSE(this->soil.adapt(this->bodies, this->adaptivity));
  for (unsigned int step = 0; step < 6; ++step)
  {
    this->move([](long long, const unsigned int d) { return d == 0 ? 0.12 : 0.; });
    this->soil.parts().contact.follow_particles(all_ids(this->particles));
    const long long came_in = this->count_wide();
    EXPECT_EQ(this->soil.adapt(this->bodies, this->adaptivity), came_in > 0);
    EXPECT_EQ(this->count_wide(), 0) << "step " << step;
  }
}

TYPED_TEST(FlowingSoil, FindsNoRoomInANarrowSlit)
{
  // Particles of 0.2 m, their centres at 0.5 and 0.7 m; the slit from 0.68 to 0.72 m is narrower than their boxes. The
  // bodies' outer faces lie between centres and inside boxes.
  this->put_walls({{{0.38, 0.68}, {0.72, 0.98}}});
  const long long all = this->particles.n_global();
  EXPECT_EQ(this->soil.remove_buried(this->bodies), all * 3 / 8);
  for (std::size_t p = 0; p < this->particles.ids().size(); ++p)
    EXPECT_GT(std::abs(this->particles.positions()[p][0] - 0.7), 0.3);
}

TYPED_TEST(FlowingSoil, LeavesNoContactBehindForTheNextWithItsNumber)
{
  Contact<TypeParam::value>& contact = this->soil.parts().contact;
  std::vector<ContactRecord> records;
  for (const long long id : this->particles.ids())
  {
    ContactRecord record{};
    record.particle = id;
    record.bonded = 1;
    records.push_back(record);
  }
  contact.import_history(records, this->particles.ids());
  this->put_walls({{{0.38, 0.68}, {0.72, 0.98}}});
  ASSERT_GT(this->soil.remove_buried(this->bodies), 0);
  const auto count = [](const std::size_t n) { return sum_over_ranks(static_cast<long long>(n), MPI_COMM_WORLD); };
  EXPECT_EQ(count(contact.export_history().size()), this->particles.n_global());
}

TYPED_TEST(FlowingSoil, FindsNoRoomInASlitOfASingleRow)
{
  // Both bodies leave all of the boxes of 0.2 m around 0.7 m, or nearly: no second row fits between 0.6 and 0.98 m.
  this->put_walls({{{0.58, 0.61}, {0.98, 1.01}}});
  const long long all = this->particles.n_global();
  EXPECT_EQ(this->soil.remove_buried(this->bodies), all * 2 / 8);
  for (std::size_t p = 0; p < this->particles.ids().size(); ++p)
    EXPECT_GT(std::abs(this->particles.positions()[p][0] - 0.8), 0.2);
}

TYPED_TEST(FlowingSoil, StaysBetweenThinBodies)
{
  // Two rows fit between the bodies, which are thinner than boxes.
  this->put_walls({{{0.56, 0.59}, {1.01, 1.04}}});
  EXPECT_EQ(this->soil.remove_buried(this->bodies), 0);
}
