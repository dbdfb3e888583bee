#include <gtest/gtest.h>
#include <kedge/particles/generation.h>

using namespace kedge;

namespace
{
Layer layer(const double thickness, const double density)
{
  Layer layer;
  layer.thickness = thickness;
  layer.material.density = density;
  return layer;
}
} // namespace

TEST(Rows, FillTheBlockWithoutGaps)
{
  const auto rows = make_rows(0.25, 3., {layer(1.1, 1500.), layer(1.9, 2000.)}, 10.);
  EXPECT_EQ(rows.front().bottom, 0.);
  EXPECT_NEAR(rows.back().top, 3., 1e-14);
  for (std::size_t i = 0; i + 1 < rows.size(); ++i)
    EXPECT_EQ(rows[i].top, rows[i + 1].bottom);
}

TEST(Rows, AreCutWhereAnInterfacePassesThrough)
{
  const auto rows = make_rows(0.25, 3., {layer(1.1, 1500.), layer(1.9, 2000.)}, 10.);
  ASSERT_EQ(rows.size(), 13u);
  EXPECT_EQ(rows[7].top, 1.9);
  EXPECT_EQ(rows[7].layer, 1u);
  EXPECT_EQ(rows[8].bottom, 1.9);
  EXPECT_EQ(rows[8].layer, 0u);
}

TEST(Rows, AreNotCutWhereAnInterfaceLiesOnTheirEdge)
{
  // 0.3 + 0.3 + 0.3 is not 0.9 in binary
  EXPECT_EQ(make_rows(0.1, 1.2, {layer(0.3, 1.), layer(0.3, 1.), layer(0.3, 1.), layer(0.3, 1.)}, 10.).size(), 12u);
}

TEST(Rows, GiveTheTopmostLayerWhatRoundingAdds)
{
  // 2.9 m of soil in a block of 3 m: interfaces are measured from the base
  const auto rows = make_rows(0.5, 3., {layer(0.9, 1500.), layer(2., 2000.)}, 10.);
  ASSERT_EQ(rows.size(), 6u);
  EXPECT_EQ(rows[3].layer, 1u);
  EXPECT_EQ(rows[4].layer, 0u);
  EXPECT_EQ(rows[5].layer, 0u);
}

TEST(Rows, CarryTheOverburdenOfTheRowsAbove)
{
  const auto rows = make_rows(0.25, 3., {layer(1.1, 1500.), layer(1.9, 2000.)}, 10.);
  for (const ParticleRow& row : rows)
  {
    const double middle = 0.5 * (row.bottom + row.top);
    const double expected = middle > 1.9 ? 1.5e4 * (3. - middle) : 1.5e4 * 1.1 + 2e4 * (1.9 - middle);
    EXPECT_NEAR(row.vertical_stress, expected, 1e-10 * expected) << "at " << middle;
  }
}
