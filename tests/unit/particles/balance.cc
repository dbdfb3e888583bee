#include "tall_block.h"
#include <gtest/gtest.h>

using namespace kedge;

namespace
{
/// A block of 4 (by 3) by 2.75 m in cells of 0.5 m.
template <typename Dimension> class Balance : public testing::Test, public test::SoilFixture<Dimension::value>
{
public:
  static constexpr int dim = Dimension::value;

  Balance()
      : test::SoilFixture<dim>(test::tall_block<dim>(),
                               test::layers_of({test::elastic_layer(0.6), test::elastic_layer(2.15)}, 0.4), 10.)
  {
  }
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(Balance, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(Balance, AreBalancedAfterRefinementInACorner)
{
  constexpr double cost = 20.;
  this->particles.remove_if([](const auto& particle) { return particle.get_location()[0] > 2.; });
  auto& forest = this->mesh.triangulation();
  for (unsigned int pass = 0; pass < 2; ++pass)
  {
    for (const auto& cell : forest.active_cell_iterators())
      if (cell->is_locally_owned() && cell->center().norm() < 1.)
        cell->set_refine_flag();
    this->particles.carry_through([&] { forest.execute_coarsening_and_refinement(); });
  }
  const double before = this->particles.imbalance(cost);
  this->particles.balance_load(cost);
  if (size_of(MPI_COMM_WORLD) == 1)
  {
    EXPECT_EQ(before, 1.);
  }
  else
  {
    EXPECT_GT(before, 1.3);
    EXPECT_LT(this->particles.imbalance(cost), 1.2);
  }
}

TYPED_TEST(Balance, CostMoreWhereTheySeeMoreNodes)
{
  if (size_of(MPI_COMM_WORLD) == 1)
    GTEST_SKIP() << "one rank is always balanced";
  // twice finer, each reaches into 2^dim cells; by their number alone the imbalance would be 1.23 at most
  for (unsigned int pass = 0; pass < 2; ++pass)
  {
    auto& forest = this->mesh.triangulation();
    for (const auto& cell : forest.active_cell_iterators())
      if (cell->is_locally_owned() && rank_of(MPI_COMM_WORLD) == 0)
        cell->set_refine_flag();
    this->particles.carry_through([&] { forest.execute_coarsening_and_refinement(); });
  }
  EXPECT_GT(this->particles.imbalance(20.), 1.35);
}

TYPED_TEST(Balance, CostMoreNearABody)
{
  const double before = this->particles.imbalance(20.);
  std::unordered_map<long long, double> gaps;
  if (rank_of(MPI_COMM_WORLD) == 0)
    for (const auto& particle : this->particles.handler())
      gaps[particle.get_id()] = 0.01;
  this->particles.set_contact_gaps(gaps);
  if (size_of(MPI_COMM_WORLD) == 1)
  {
    EXPECT_EQ(this->particles.imbalance(20.), 1.);
  }
  else
  {
    EXPECT_GT(this->particles.imbalance(20.), 1.2 * before);
  }
}
