// Full cells integrate constants and linear functions exactly, wherever their particles are.
#include "block.h"
#include <gtest/gtest.h>
#include <kedge/basis/cell_quadrature.h>

using namespace kedge;

namespace
{
template <typename Dimension> class CellQuadrature : public testing::Test
{
public:
  static constexpr int dim = Dimension::value;

  CellQuadrature() : block(test::soil_material<Elastic>())
  {
    const ParticleArrays& arrays = block.particles.arrays();
    const std::vector<double> young = download(arrays.young), mass = download(arrays.mass);
    volume = download(arrays.initial_volume);
    contents = find_leaf_contents<dim>(table(), {parts(), block.particles.half_widths(), young, mass, volume}, 0.25,
                                       MPI_COMM_WORLD);
    for (LeafContent& content : contents) // at the ends of so small a block, too
      content.full = content.full > 0. ? 1. : 0.;
  }

  const LeafTable<dim>& table() const { return block.mesh.leaves(); }

  BoxParts<dim> parts() const
  {
    return find_box_parts<dim>(table(), block.particles.positions(), block.particles.half_widths(),
                               block.particles.leaves());
  }

  HostStencils stencils(const bool corrected) const
  {
    return build_stencils<dim>(table(), parts(),
                               corrected ? find_cell_corrections<dim>(table(), contents)
                                         : std::vector<CellCorrection<dim>>());
  }

  /// By node and axis: sum of volume times gradient, over the ranks: what uniform unit pressure does to the nodes.
  std::vector<double> uniform_pressure(const HostStencils& stencils) const
  {
    std::vector<double> force(dim * table().node_ids.size(), 0.);
    for (std::size_t p = 0; p < volume.size(); ++p)
    {
      const unsigned int first = stencils.pattern_node_begin[stencils.pattern_of_particle[p]];
      const std::size_t n = stencils.value_begin[p + 1] - stencils.value_begin[p];
      for (std::size_t v = 0; v < n; ++v)
        for (unsigned int d = 0; d < dim; ++d)
          force[dim * stencils.pattern_nodes[first + v] + d] +=
              volume[p] * stencils.volume_factor[p] * stencils.gradient[dim * (stencils.value_begin[p] + v) + d];
    }
    return force;
  }

  /// Whether all leaves around a node are full.
  std::vector<bool> inner_nodes() const
  {
    std::vector<bool> inner(table().node_ids.size(), true);
    for (std::size_t leaf = 0; leaf < table().leaves.size(); ++leaf)
    {
      const auto& cell = table().leaves[leaf];
      for (unsigned int n = 0; n < cell.n_nodes; ++n)
        if (contents[leaf].full < 1.)
          inner[table().nodes[cell.node_begin + n]] = false;
    }
    for (std::size_t v = 0; v < inner.size(); ++v)
      for (unsigned int d = 0; d < dim; ++d)
        if (table().node_position[v][d] < 1e-9 || table().node_position[v][d] > table().upper_end(d) - 1e-9)
          inner[v] = false;
    return inner;
  }

  test::Block<dim> block;
  std::vector<double> volume;
  std::vector<LeafContent> contents;
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(CellQuadrature, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(CellQuadrature, KeepsUniformStressInBalance)
{
  constexpr int dim = TypeParam::value;
  if (size_of(MPI_COMM_WORLD) > 1)
    GTEST_SKIP() << "the sums are those of one rank; scenes compare ranks";
  const std::vector<double> corrected = this->uniform_pressure(this->stencils(true)),
                            plain = this->uniform_pressure(this->stencils(false));
  const std::vector<bool> inner = this->inner_nodes();
  const double face = std::pow(0.5 * test::Block<dim>::cell, dim - 1);
  unsigned int n_inner = 0;
  double worst = 0., worst_plain = 0.;
  for (std::size_t v = 0; v < inner.size(); ++v)
    for (unsigned int d = 0; d < dim && inner[v]; ++d)
    {
      ++n_inner;
      worst = std::max(worst, std::abs(corrected[dim * v + d]));
      worst_plain = std::max(worst_plain, std::abs(plain[dim * v + d]));
    }
  ASSERT_GT(n_inner, 0u);
  EXPECT_LT(worst, 1e-12 * face);
  EXPECT_GT(worst_plain, 0.01 * face);
}

TYPED_TEST(CellQuadrature, ReproducesLinearFields)
{
  constexpr int dim = TypeParam::value;
  const HostStencils stencils = this->stencils(true);
  for (std::size_t p = 0; p < this->volume.size(); ++p)
  {
    const unsigned int first = stencils.pattern_node_begin[stencils.pattern_of_particle[p]];
    Eigen::Matrix<double, dim, dim> gradient = Eigen::Matrix<double, dim, dim>::Zero();
    for (std::size_t at = stencils.value_begin[p]; at < stencils.value_begin[p + 1]; ++at)
    {
      const auto& x = this->table().node_position[stencils.pattern_nodes[first + at - stencils.value_begin[p]]];
      for (unsigned int i = 0; i < dim; ++i)
        for (unsigned int j = 0; j < dim; ++j)
          gradient(i, j) += x[i] * stencils.gradient[dim * at + j];
    }
    EXPECT_LT((gradient - Eigen::Matrix<double, dim, dim>::Identity()).norm(), 1e-11);
  }
}
