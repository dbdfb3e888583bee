// Particles outside the mesh's window wait.
#include "soil_block.h"
#include <gtest/gtest.h>
#include <kedge/particles/cleaning.h>
#include <set>

using namespace kedge;

namespace
{
/// The block with a window of its two middle columns of cells, from 0.5 m to 1.5 m.
template <typename Dimension> class WaitingParticles : public testing::Test, public test::SoilBlock<Dimension::value>
{
public:
  static constexpr int dim = Dimension::value;
  static constexpr double lower = 0.5, upper = 1.5;
  using Record = test::ParticleRecord<dim>;

  WaitingParticles()
  {
    Window<dim> window{{}, this->mesh.layout().base_cells};
    window.lower[0] = 1;
    window.upper[0] = 3;
    this->mesh.set_window(window);
  }

  static bool is_active(const Record& record) { return record.position[0] > lower && record.position[0] < upper; }

  /// A trial state in which every active particle moves down and is stretched.
  void commit_motion()
  {
    const std::size_t n = this->particles.ids().size();
    ParticleIncrements increments;
    increments.displacement = kedge::View<double* [3]>("displacement", n);
    increments.deformation_gradient = kedge::View<double* [9]>("dF", n);
    const auto u = copy_to_host(increments.displacement);
    const auto f = copy_to_host(increments.deformation_gradient);
    for (std::size_t p = 0; p < n; ++p)
    {
      u(p, dim - 1) = -1e-3;
      for (unsigned int i = 0; i < 3; ++i)
        f(p, 4 * i) = 1.1;
    }
    Kokkos::deep_copy(increments.displacement, u);
    Kokkos::deep_copy(increments.deformation_gradient, f);
    this->particles.commit(increments, DomainUpdate::stretch);
  }
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(WaitingParticles, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(WaitingParticles, AreNotInTheArrays)
{
  const auto loaded = gather_everywhere(this->particles.ids(), MPI_COMM_WORLD);
  std::set<long long> expected;
  for (const auto& record : this->records())
    if (this->is_active(record))
      expected.insert(record.id);
  EXPECT_EQ(std::set<long long>(loaded.begin(), loaded.end()), expected);
  EXPECT_EQ(loaded.size(), expected.size());
  EXPECT_EQ(2 * expected.size(), this->records().size());
}

TYPED_TEST(WaitingParticles, KeepTheirStateWhileTheOthersMove)
{
  auto before = this->by_number();
  this->commit_motion();
  for (const auto& record : this->records())
  {
    const auto& old = before.at(record.id);
    const double moved = this->is_active(record) ? 1e-3 : 0.;
    EXPECT_NEAR(old.position[TypeParam::value - 1] - record.position[TypeParam::value - 1], moved, 1e-15);
    EXPECT_NEAR(record.F()(0, 0) - old.F()(0, 0), 100. * moved, 1e-15);
  }
}

TYPED_TEST(WaitingParticles, GetTheirOwnDataBackWhenTheyWake)
{
  constexpr int dim = TypeParam::value;
  this->mesh.set_window(Window<dim>{{}, this->mesh.layout().base_cells});
  const auto records = this->by_number();
  EXPECT_EQ(gather_everywhere(this->particles.ids(), MPI_COMM_WORLD).size(), records.size());
  for (std::size_t p = 0; p < this->particles.ids().size(); ++p)
    EXPECT_EQ(this->particles.positions()[p], records.at(this->particles.ids()[p]).position);
}

TYPED_TEST(WaitingParticles, AreNoWork)
{
  // The lower half, with which the curve through the cells begins: were all soil work, two ranks would not share it.
  // Siblings stay together, so one of three ranks has two families of four.
  constexpr int dim = TypeParam::value;
  Window<dim> half{{}, this->mesh.layout().base_cells};
  half.upper[dim - 1] /= 2;
  this->mesh.set_window(half);
  this->particles.balance_load(1000.);
  const double mine = this->particles.ids().size(),
               mean = sum_over_ranks(mine, MPI_COMM_WORLD) / size_of(MPI_COMM_WORLD);
  EXPECT_LT(max_over_ranks(mine, MPI_COMM_WORLD), 1.6 * mean);
}

TYPED_TEST(WaitingParticles, AreNoCompanyForAnActiveOne)
{
  // in the window one particle is left, beside the plane
  const long long kept = [&]
  {
    for (const auto& record : this->records())
      if (this->is_active(record) && record.position[0] < this->lower + 0.2)
        return record.id;
    return -1ll;
  }();
  this->particles.remove_if(
      [&](const auto& particle)
      {
        const double x = particle.get_location()[0];
        return x > this->lower && x < this->upper && static_cast<long long>(particle.get_id()) != kept;
      });
  EXPECT_EQ(remove_hopeless_particles(this->particles, this->mesh, false).isolated, 1);
}

TYPED_TEST(WaitingParticles, AreNotRemovedForBeingAlone)
{
  // one in the first column of cells, the next one in the third, where the window begins
  const long long kept = this->records().front().id;
  Window<TypeParam::value> window = this->mesh.leaves().window;
  window.lower[0] = 2;
  this->mesh.set_window(window);
  this->particles.remove_if(
      [&](const auto& particle)
      { return particle.get_location()[0] < 1. && static_cast<long long>(particle.get_id()) != kept; });
  EXPECT_EQ(remove_hopeless_particles(this->particles, this->mesh, false).isolated, 0);
}
