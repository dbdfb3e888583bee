#include "tall_block.h"
#include <Eigen/Core>
#include <gtest/gtest.h>
#include <kedge/base/exceptions.h>
#include <set>

using namespace kedge;

namespace
{
/// Two layers in a block of 4 (by 3) by 2.75 m, cells of 0.5 m, the interface within a row.
template <typename Dimension> class Particles : public testing::Test, public test::SoilFixture<Dimension::value>
{
public:
  using test::SoilFixture<Dimension::value>::particles;
  static constexpr int dim = Dimension::value;
  static constexpr double interface = 2.15, top = 2.75, gravity = 10.;

  Particles() : test::SoilFixture<dim>(test::tall_block<dim>(), two_layers(), gravity) {}

  static MaterialPointParameters two_layers()
  {
    MaterialPointParameters parameters =
        test::layers_of({test::elastic_layer(0.6, 1500., 2e6), test::elastic_layer(2.15, 2000.)}, 0.4);
    parameters.layers[1].material.overburden = Overburden{1e4, 0.5};
    return parameters;
  }

  double plan_area() const { return dim == 3 ? 4. * 3. : 4.; }

  double sum(const kedge::View<double*>& view) const
  {
    double sum = 0.;
    for (std::size_t p = 0; p < particles.ids().size(); ++p)
      sum += copy_to_host(view)(p);
    return sum_over_ranks(sum, MPI_COMM_WORLD);
  }

  double overburden(const double z) const
  {
    return z > interface ? 1500. * gravity * (top - z)
                         : 1500. * gravity * (top - interface) + 2000. * gravity * (interface - z);
  }

  /// A trial state for commit().
  template <typename Displacement>
  ParticleIncrements increments(const Displacement& displacement, const double stretch = 1.) const
  {
    return test::increments_of(particles, displacement, stretch);
  }

  std::vector<long long> all_ids() const
  {
    std::vector<long long> ids = gather_everywhere(particles.ids(), MPI_COMM_WORLD);
    std::sort(ids.begin(), ids.end());
    return ids;
  }
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(Particles, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(Particles, FillTheBlockExactly)
{
  const double volume = this->plan_area() * this->top;
  EXPECT_NEAR(this->sum(this->particles.arrays().initial_volume), volume, 1e-12 * volume);
}

TYPED_TEST(Particles, WeighWhatTheLayersWeigh)
{
  const double mass = this->plan_area() * (0.6 * 1500. + 2.15 * 2000.);
  EXPECT_NEAR(this->sum(this->particles.arrays().mass), mass, 1e-12 * mass);
}

TYPED_TEST(Particles, HaveNumbersOfTheirOwn)
{
  const std::vector<long long> ids = this->all_ids();
  EXPECT_EQ(static_cast<long long>(ids.size()), this->particles.n_global());
  EXPECT_EQ(std::set<long long>(ids.begin(), ids.end()).size(), ids.size());
}

TYPED_TEST(Particles, BeginWithTheStateOfTheirLaw)
{
  constexpr int dim = TypeParam::value;
  MaterialPointParameters clay = test::layers_of({test::elastic_layer(0.6), test::elastic_layer(2.15)});
  clay.layers[1].material.law = law_index<Clay>;
  clay.layers[1].material.constants.values = {{"undrained strength", 2e3}, {"strength gradient", 1.5e3}};
  const test::SoilFixture<dim> block(test::tall_block<dim>(), clay);
  const auto state = copy_to_host(block.particles.arrays().state);
  const auto layer = copy_to_host(block.particles.arrays().layer);
  for (std::size_t p = 0; p < block.particles.ids().size(); ++p)
  {
    const double depth = this->top - block.particles.positions()[p][dim - 1];
    ASSERT_NEAR(state(p, 0), layer(p) == 1 ? 2e3 + 1.5e3 * depth : 0., 1e-9);
    ASSERT_EQ(state(p, 1), 0.);
  }
}

TYPED_TEST(Particles, StayWithinTheirLayer)
{
  constexpr unsigned int vertical = TypeParam::value - 1;
  const auto layer = copy_to_host(this->particles.arrays().layer);
  for (std::size_t p = 0; p < this->particles.ids().size(); ++p)
  {
    const double z = this->particles.positions()[p][vertical], half = this->particles.half_widths()[p][vertical];
    if (layer(p) == 0)
    {
      ASSERT_GE(z - half, this->interface - 1e-12);
    }
    else
    {
      ASSERT_LE(z + half, this->interface + 1e-12);
    }
  }
}

TYPED_TEST(Particles, StandUnderTheOverburdenAndK0TimesIt)
{
  constexpr unsigned int vertical = TypeParam::value - 1;
  const auto stress = copy_to_host(this->particles.arrays().trial_stress);
  for (std::size_t p = 0; p < this->particles.ids().size(); ++p)
  {
    const double expected = -this->overburden(this->particles.positions()[p][vertical]);
    for (unsigned int d = 0; d < 6; ++d)
      ASSERT_NEAR(stress(p, d), expected * (d == vertical ? 1. : d < 3 ? 0.4 : 0.), -1e-12 * expected);
  }
}

TYPED_TEST(Particles, RefuseAnInitialStressThatCrushesThem)
{
  constexpr int dim = TypeParam::value;
  MaterialPointParameters soft = TestFixture::two_layers();
  soft.layers[0].material.young = 2e3; // 6 kPa below it
  try
  {
    const test::SoilFixture<dim> block(test::tall_block<dim>(), soft, TestFixture::gravity);
    FAIL();
  }
  catch (const InputError& error)
  {
    EXPECT_EQ(error.path, "material points.layers[0].material");
  }
}

TYPED_TEST(Particles, HaveTheElasticStrainOfTheirStress)
{
  const auto strain = copy_to_host(this->particles.arrays().trial_strain),
             stress = copy_to_host(this->particles.arrays().trial_stress);
  const auto young = copy_to_host(this->particles.arrays().young);
  for (std::size_t p = 0; p < this->particles.ids().size(); ++p)
    for (unsigned int d = 0; d < 3; ++d)
    {
      const double trace = strain(p, 0) + strain(p, 1) + strain(p, 2); // lame = shear = 0.4 E for nu = 0.25
      ASSERT_NEAR(0.4 * young(p) * (trace + 2. * strain(p, d)), stress(p, d), 1e-9);
    }
}

TYPED_TEST(Particles, StiffenWithTheOverburden)
{
  const auto young = copy_to_host(this->particles.arrays().young);
  const auto layer = copy_to_host(this->particles.arrays().layer);
  for (std::size_t p = 0; p < this->particles.ids().size(); ++p)
  {
    const double sigma = this->overburden(this->particles.positions()[p][TypeParam::value - 1]);
    ASSERT_NEAR(young(p), layer(p) == 0 ? 2e6 : 1e7 * std::sqrt(sigma / 1e4), 1e-4);
  }
}

TYPED_TEST(Particles, MoveByTheirDisplacementAcrossCellsAndRanks)
{
  // almost a cell along, less across
  const auto displacement = [](const long long id, const unsigned int d)
  { return d == 0 ? 0.45 * test::noise(id, 0) : 0.4 * (test::noise(id, d) - 0.5); };
  const auto start_of = [&](const auto& particle)
  { return Eigen::Map<const Eigen::Vector3d>(particle.get_properties().data() + field::initial_position); };
  const auto left = [&](const auto& start, const long long id)
  {
    bool outside = false;
    for (unsigned int d = 0; d < TypeParam::value; ++d)
    {
      const double x = start[d] + displacement(id, d);
      outside = outside || x < 0. || x > this->mesh.layout().extent(d);
    }
    return outside;
  };
  const long long before = this->particles.n_global();
  long long expected_to_leave = 0;
  for (const auto& particle : this->particles.handler())
    expected_to_leave += left(start_of(particle), particle.get_id());
  expected_to_leave = sum_over_ranks(expected_to_leave, MPI_COMM_WORLD);
  ASSERT_GT(expected_to_leave, 0);

  this->particles.commit(this->increments(displacement), DomainUpdate::none);
  EXPECT_EQ(this->particles.lost().number, expected_to_leave);
  EXPECT_EQ(this->particles.n_global(), before - expected_to_leave);
  const std::vector<long long> ids = this->all_ids();
  EXPECT_EQ(std::set<long long>(ids.begin(), ids.end()).size(), ids.size());
  for (const auto& particle : this->particles.handler())
    for (unsigned int d = 0; d < TypeParam::value; ++d)
      ASSERT_NEAR(particle.get_location()[d], start_of(particle)[d] + displacement(particle.get_id(), d), 1e-14);
  for (std::size_t p = 0; p < this->particles.ids().size(); ++p)
  {
    const auto& leaf = this->mesh.leaves().leaves[this->particles.leaves()[p]];
    ASSERT_TRUE(leaf.owned);
    for (unsigned int d = 0; d < TypeParam::value; ++d)
    {
      ASSERT_GE(this->particles.positions()[p][d], leaf.lower[d] - 1e-12);
      ASSERT_LE(this->particles.positions()[p][d], leaf.lower[d] + leaf.size + 1e-12);
    }
  }
}

TYPED_TEST(Particles, ArriveWhereverTheyJump)
{
  // six cells of eight: past the ghost cells on several ranks
  const auto is_left_of = [&](const double x)
  {
    long long n = 0;
    for (const auto& particle : this->particles.handler())
      n += particle.get_location()[0] < x;
    return sum_over_ranks(n, MPI_COMM_WORLD);
  };
  const long long before = this->particles.n_global(), staying = is_left_of(1.);
  const double x_sum = 3. * staying;
  this->particles.commit(this->increments([](long long, const unsigned int d) { return d == 0 ? 3. : 0.; }),
                         DomainUpdate::none);
  EXPECT_EQ(this->particles.n_global(), staying);
  EXPECT_EQ(this->particles.lost().number, before - staying);
  double moved = 0.;
  for (const auto& particle : this->particles.handler())
  {
    const auto& leaf = this->mesh.leaves().leaves[this->mesh.leaf_number(particle.get_surrounding_cell())];
    EXPECT_TRUE(leaf.owned);
    EXPECT_NEAR(leaf.lower[0] + particle.get_reference_location()[0] * leaf.size, particle.get_location()[0], 1e-12);
    moved += particle.get_location()[0] - particle.get_properties()[field::initial_position];
  }
  EXPECT_NEAR(sum_over_ranks(moved, MPI_COMM_WORLD), x_sum, 1e-9 * x_sum);
}

TYPED_TEST(Particles, KeepTheirMassWhenTheyChangeRanks)
{
  const double mass = this->sum(this->particles.arrays().mass);
  const std::vector<long long> ids = this->all_ids();
  for (const double sign : {1., -1.})
  {
    this->particles.commit(this->increments([&](const long long id, const unsigned int d)
                                            { return d == 0 ? sign * 0.12 * test::noise(id, 0) : 0.; }),
                           DomainUpdate::none);
    this->particles.balance_load(50.);
  }
  EXPECT_NEAR(this->sum(this->particles.arrays().mass), mass, 1e-12 * mass);
  EXPECT_EQ(this->all_ids(), ids);
}

TYPED_TEST(Particles, KeepTheirDataWhenCellsAreRefinedAndCoarsened)
{
  std::map<long long, std::vector<double>> before;
  const auto collect = [&](std::map<long long, std::vector<double>>& data)
  {
    for (const auto& particle : this->particles.handler())
    {
      const auto& properties = particle.get_properties();
      data[particle.get_id()].assign(properties.begin(), properties.end());
      data[particle.get_id()][field::contact_gap] = 0.; // not a number away from bodies
    }
  };
  collect(before);
  auto& forest = this->mesh.triangulation();
  for (const bool refine : {true, false})
  {
    for (const auto& cell : forest.active_cell_iterators())
      if (cell->is_locally_owned() && refine && cell->center()[0] < 2.)
        cell->set_refine_flag();
      else if (cell->is_locally_owned() && !refine && cell->level() > 0 && cell->center()[1] < 1.)
        cell->set_coarsen_flag();
    this->particles.carry_through([&] { forest.execute_coarsening_and_refinement(); });
    std::map<long long, std::vector<double>> after;
    collect(after);
    EXPECT_EQ(after, before); // no repartition: they stay on their ranks
    for (std::size_t p = 0; p < this->particles.ids().size(); ++p)
      ASSERT_EQ(int(this->particles.leaves()[p]), this->mesh.leaves().find_leaf(this->particles.positions()[p]));
  }
}

TYPED_TEST(Particles, CommitTheTrialState)
{
  const ParticleArrays& arrays = this->particles.arrays();
  Kokkos::deep_copy(arrays.trial_stress, -7.);
  Kokkos::deep_copy(arrays.trial_strain, 0.);
  Kokkos::deep_copy(arrays.trial_plastic, 0.25);
  Kokkos::deep_copy(arrays.trial_state, 0.75);
  const auto none = [](long long, unsigned int) { return 0.; };
  this->particles.commit(this->increments(none, 1.1), DomainUpdate::none);
  const auto stress = copy_to_host(this->particles.arrays().trial_stress);
  const auto state = copy_to_host(this->particles.arrays().state);
  const auto b = copy_to_host(this->particles.arrays().elastic_left_cauchy_green);
  for (std::size_t p = 0; p < this->particles.ids().size(); ++p)
  {
    ASSERT_EQ(state(p, 0), 0.75);
    for (unsigned int i = 0; i < 6; ++i)
    {
      ASSERT_EQ(stress(p, i), -7.);
      ASSERT_NEAR(b(p, i), i < 3 ? 1. : 0., 1e-15);
    }
  }
  Kokkos::deep_copy(this->particles.arrays().trial_plastic, 0.5);
  this->particles.commit(this->increments(none, 1.1), DomainUpdate::none);
  for (const auto& particle : this->particles.handler())
  {
    ASSERT_EQ(particle.get_properties()[field::plastic_strain], 0.75);
    ASSERT_NEAR(particle.get_properties()[field::deformation_gradient], 1.21, 1e-14);
    ASSERT_EQ(particle.get_properties()[field::half_width], particle.get_properties()[field::initial_half_width]);
  }
}

TYPED_TEST(Particles, StretchTheirDomainsUpToTheCap)
{
  const auto none = [](long long, unsigned int) { return 0.; };
  const auto ratio = [&](const unsigned int axis)
  {
    const auto first = this->particles.handler().begin();
    const auto& particle = *first;
    return particle.get_properties()[field::half_width + axis] /
           particle.get_properties()[field::initial_half_width + axis];
  };
  this->particles.commit(this->increments(none, 1.5), DomainUpdate::stretch);
  EXPECT_NEAR(ratio(0), 1.5, 1e-14);
  EXPECT_NEAR(ratio(TypeParam::value - 1), 1., 1e-14);
  this->particles.commit(this->increments(none, 1.5), DomainUpdate::stretch); // 2.25
  EXPECT_NEAR(ratio(0), 1.99, 1e-14);
  this->particles.commit(this->increments(none, 0.4), DomainUpdate::stretch); // 0.9
  EXPECT_NEAR(ratio(0), 0.9, 1e-14);
}

TYPED_TEST(Particles, AreRemovedWhereAConditionHolds)
{
  const long long before = this->particles.n_global();
  const long long removed =
      this->particles.remove_if([](const auto& particle) { return particle.get_location()[0] < 1.; });
  EXPECT_EQ(removed, before / 4);
  EXPECT_EQ(this->particles.n_global(), before - removed);
  for (const auto& x : this->particles.positions())
    ASSERT_GT(x[0], 1.);
}

TYPED_TEST(Particles, NoteTheirContactGaps)
{
  const long long marked = this->all_ids().front();
  this->particles.set_contact_gaps({{marked, -0.25}});
  for (const auto& particle : this->particles.handler())
  {
    const double gap = particle.get_properties()[field::contact_gap];
    if (static_cast<long long>(particle.get_id()) == marked)
    {
      EXPECT_EQ(gap, -0.25);
    }
    else
    {
      ASSERT_TRUE(std::isnan(gap));
    }
  }
}
