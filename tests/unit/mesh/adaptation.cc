#include "refined_mesh.h"
#include <gtest/gtest.h>
#include <kedge/mesh/adaptation.h>
#include <limits>

using namespace kedge;

namespace
{
template <typename Dimension> class Flags : public testing::Test, public test::RefinedMesh<Dimension::value>
{
public:
  static constexpr int dim = Dimension::value;
  static constexpr double base = 0.3, infinity = std::numeric_limits<double>::infinity();

  /// The wanted size is the same everywhere.
  static WantedSize<dim> size(const double wanted)
  {
    return [wanted](const std::array<double, dim>&, double) { return wanted; };
  }
  static FindSoil soil(const bool everywhere = true)
  {
    return [everywhere](const std::vector<unsigned char>& asked)
    { return std::vector<unsigned char>(asked.size(), everywhere); };
  }
  std::vector<double> largest(const double size) const
  {
    return std::vector<double>(this->mesh.leaves().leaves.size(), size);
  }
  void execute()
  {
    this->mesh.triangulation().execute_coarsening_and_refinement();
    this->mesh.update();
  }
  /// Coarsens until nothing is flagged.
  void coarsen(const double wanted, const double limit)
  {
    for (unsigned int pass = 0; pass < 20; ++pass)
      switch (flag_coarsening<dim>(this->mesh, size(wanted), largest(limit)))
      {
        case Coarsening::none:
          return;
        case Coarsening::flagged:
          execute();
          break;
        case Coarsening::split_families:
          this->mesh.repartition();
          this->mesh.update();
          break;
      }
    FAIL() << "coarsening does not end";
  }
  double smallest() const
  {
    return extreme_size([](double a, double b) { return std::min(a, b); });
  }
  double greatest() const
  {
    return extreme_size([](double a, double b) { return std::max(a, b); });
  }

private:
  template <typename Choice> double extreme_size(const Choice& choice) const
  {
    double extreme = this->mesh.leaves().leaves[0].size;
    for (const auto& leaf : this->mesh.leaves().leaves)
      if (leaf.owned)
        extreme = choice(extreme, leaf.size);
    for (const double other : gather_everywhere(std::vector<double>{extreme}, MPI_COMM_WORLD))
      extreme = choice(extreme, other);
    return extreme;
  }
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(Flags, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(Flags, RefineLargerCellsToTheWantedSize)
{
  ASSERT_EQ(this->greatest(), this->base);
  for (unsigned int pass = 0; pass < 2; ++pass)
  {
    ASSERT_TRUE(
        flag_refinement<TypeParam::value>(this->mesh, this->size(this->base / 4.), this->base / 4., this->soil()));
    this->execute();
  }
  EXPECT_FALSE(
      flag_refinement<TypeParam::value>(this->mesh, this->size(this->base / 4.), this->base / 4., this->soil()));
  EXPECT_EQ(this->greatest(), this->base / 4.);
}

TYPED_TEST(Flags, LeaveCellsWithoutSoil)
{
  EXPECT_FALSE(flag_refinement<TypeParam::value>(this->mesh, this->size(0.01), 0.01, this->soil(false)));
}

TYPED_TEST(Flags, TreatSizesWithinOnePercentAsOneLevel)
{
  EXPECT_FALSE(
      flag_refinement<TypeParam::value>(this->mesh, this->size(0.992 * this->base), 0.1 * this->base, this->soil()));
  this->coarsen(0.992 * this->base, this->infinity);
  EXPECT_EQ(this->smallest(), this->base);
}

TYPED_TEST(Flags, CoarsenToTheBaseCellsAndNoFurther)
{
  ASSERT_LT(this->smallest(), 0.3 * this->base);
  this->coarsen(10. * this->base, this->infinity);
  EXPECT_EQ(this->smallest(), this->base);
  EXPECT_EQ(this->greatest(), this->base);
}

TYPED_TEST(Flags, CoarsenNoFurtherThanWanted)
{
  this->coarsen(this->base / 2., this->infinity);
  EXPECT_EQ(this->smallest(), this->base / 2.);
}

TYPED_TEST(Flags, CoarsenNoFurtherThanParticlesAllow)
{
  this->coarsen(this->base, 0.7 * this->base);
  EXPECT_EQ(this->smallest(), this->base / 2.);
}

TYPED_TEST(Flags, CoarsenNoFamilyThatAFinerCellTouches)
{
  // All base cells around a vertex are refined once; at that vertex the lowest cell is refined twice.
  constexpr int dim = TypeParam::value, n = 1 << dim;
  std::array<unsigned int, dim> cells;
  cells.fill(2);
  BackgroundMesh<dim> mesh(MPI_COMM_WORLD, test::make_brick<dim>(cells, 1.));
  const auto refine_at = [&](const double x)
  {
    dealii::Point<dim> marked;
    for (unsigned int d = 0; d < dim; ++d)
      marked[d] = x;
    for (const auto& cell : mesh.triangulation().active_cell_iterators())
      if (cell->is_locally_owned() && cell->point_inside(marked))
        cell->set_refine_flag();
    mesh.triangulation().execute_coarsening_and_refinement();
  };
  refine_at(0.9);
  refine_at(0.9);
  mesh.update();
  ASSERT_EQ(mesh.triangulation().n_global_active_cells(), n * n + n - 1);

  const std::vector<double> any_size(mesh.leaves().leaves.size(), this->infinity);
  ASSERT_EQ(flag_coarsening<dim>(mesh, this->size(1.), any_size), Coarsening::flagged);
  long long flagged = 0;
  for (const auto& cell : mesh.triangulation().active_cell_iterators())
    flagged += cell->is_locally_owned() && cell->coarsen_flag_set();
  EXPECT_EQ(sum_over_ranks(flagged, MPI_COMM_WORLD), n);
}

TYPED_TEST(Flags, LetOneChildSpeakForItsFamilyFromAnotherRank)
{
  // After a pass the children of one cell may be on two ranks.
  ASSERT_EQ(flag_coarsening<TypeParam::value>(this->mesh, this->size(this->base), this->largest(this->infinity)),
            Coarsening::flagged);
  this->execute();
  const auto& leaves = this->mesh.leaves().leaves;
  std::vector<double> limit = this->largest(this->infinity);
  for (std::size_t i = 0; i < leaves.size(); ++i)
  {
    bool last = true;
    for (const double x : leaves[i].lower)
      last = last && std::lround(x / leaves[i].size) % 2 == 1;
    if (last && leaves[i].owned)
      limit[i] = leaves[i].size;
  }
  EXPECT_EQ(flag_coarsening<TypeParam::value>(this->mesh, this->size(this->base), limit), Coarsening::none);
}
