#include "scene.h"

#include <gtest/gtest.h>
#include <kedge/base/communication.h>

namespace kedge
{
namespace
{
using Points = std::vector<double>;

ParticleView at(const double* position, const double* data) { return {0, position, data}; }

TEST(ParticleBoxes, HexahedronInVtksOrder)
{
  double data[field::count] = {};
  const double position[3] = {10., 20., 30.};
  data[field::half_width] = 1.;
  data[field::half_width + 1] = 2.;
  data[field::half_width + 2] = 3.;
  const UnstructuredGrid grid = particle_boxes<3>({at(position, data)}, {});
  EXPECT_EQ(grid.shape, CellShape::hexahedron);
  EXPECT_EQ(grid.n_cells(), 1u);
  EXPECT_EQ(grid.points, Points({9, 18, 27, 11, 18, 27, 11, 22, 27, 9, 22, 27, //
                                 9, 18, 33, 11, 18, 33, 11, 22, 33, 9, 22, 33}));
}

TEST(ParticleBoxes, QuadInThePlaneOfXAndZ)
{
  double data[field::count] = {};
  const double position[2] = {10., 30.};
  data[field::half_width] = 1.;
  data[field::half_width + 1] = 3.;
  const UnstructuredGrid grid = particle_boxes<2>({at(position, data), at(position, data)}, {});
  EXPECT_EQ(grid.shape, CellShape::quad);
  EXPECT_EQ(grid.n_cells(), 2u);
  EXPECT_EQ(Points(grid.points.begin(), grid.points.begin() + 12), Points({9, 0, 27, 11, 0, 27, 11, 0, 33, 9, 0, 33}));
  EXPECT_EQ(grid.connectivity, std::vector<std::int32_t>({0, 1, 2, 3, 4, 5, 6, 7}));
}

TEST(GatherGrid, JoinsPointsCellsAndArraysInRankOrder)
{
  // Rank r has r + 1 lines.
  const int rank = rank_of(MPI_COMM_WORLD), size = size_of(MPI_COMM_WORLD);
  UnstructuredGrid mine;
  mine.shape = CellShape::line;
  std::vector<float> values;
  for (int line = 0; line <= rank; ++line)
  {
    mine.points.insert(mine.points.end(), {100. * rank + line, 1., 2., 100. * rank + line, 3., 4.});
    mine.connectivity.insert(mine.connectivity.end(), {2 * line, 2 * line + 1});
    values.insert(values.end(), {10.f * rank, 1.f * line});
  }
  mine.cell_data.push_back({"value", 2, values});
  const UnstructuredGrid all = gather_grid(mine, MPI_COMM_WORLD);
  if (rank != 0)
    return;
  EXPECT_EQ(all.n_cells(), std::size_t(size * (size + 1) / 2));
  const auto& joined = std::get<std::vector<float>>(all.cell_data.at(0).values);
  std::size_t cell = 0;
  for (int r = 0; r < size; ++r)
    for (int line = 0; line <= r; ++line, ++cell)
      for (int end = 0; end < 2; ++end)
      {
        EXPECT_EQ(all.points[3 * all.connectivity[2 * cell + end]], 100. * r + line);
        EXPECT_EQ(all.points[3 * all.connectivity[2 * cell + end] + 1], end == 0 ? 1. : 3.);
        EXPECT_EQ(joined[2 * cell + end], end == 0 ? 10. * r : line);
      }
}

template <typename Dimension> class SceneGrids : public testing::Test
{
};
using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(SceneGrids, Dimensions);

TYPED_TEST(SceneGrids, OnlyCellsWithParticlesAreShown)
{
  constexpr int dim = TypeParam::value;
  test::Scene<dim> scene;
  const UnstructuredGrid grid = soil_cells(scene.mesh, scene.particles);
  EXPECT_EQ(sum_over_ranks(static_cast<long long>(grid.n_cells()), MPI_COMM_WORLD), dim == 3 ? 6 : 3);
  EXPECT_EQ(std::get<std::vector<std::int32_t>>(grid.cell_data.at(0).values),
            std::vector<std::int32_t>(grid.n_cells(), 0));
}

TYPED_TEST(SceneGrids, CellsOutsideTheWindowAreShownAsInactive)
{
  test::Scene<TypeParam::value> scene;
  auto window = scene.mesh.leaves().window;
  window.lower[0] = 1;
  scene.mesh.set_window(window);
  const UnstructuredGrid grid = soil_cells(scene.mesh, scene.particles);
  long long active = 0;
  for (const std::int32_t flag : std::get<std::vector<std::int32_t>>(grid.cell_data.at(1).values))
    active += flag;
  EXPECT_EQ(sum_over_ranks(active, MPI_COMM_WORLD), TypeParam::value == 3 ? 2 : 1); // of 6 or 3
}

TYPED_TEST(SceneGrids, ParticlesAreSplitByLayerAndSorted)
{
  constexpr int dim = TypeParam::value;
  test::Scene<dim> scene;
  const auto layers = particles_by_layer<dim>(scene.mesh, scene.particles, 3);
  ASSERT_EQ(layers.size(), 3u);
  EXPECT_EQ(sum_over_ranks(static_cast<long long>(layers[0].size()), MPI_COMM_WORLD), dim == 3 ? 2 : 1);
  EXPECT_EQ(sum_over_ranks(static_cast<long long>(layers[1].size()), MPI_COMM_WORLD), dim == 3 ? 4 : 2);
  EXPECT_TRUE(layers[2].empty());
  for (const auto& layer : layers)
    for (std::size_t i = 1; i < layer.size(); ++i)
      EXPECT_LT(layer[i - 1].id, layer[i].id);
}

TYPED_TEST(SceneGrids, ParticlesOutsideTheWindowAreLeftOut)
{
  constexpr int dim = TypeParam::value;
  test::Scene<dim> scene;
  const auto count = [&]
  {
    long long n = 0;
    for (const auto& layer : particles_by_layer<dim>(scene.mesh, scene.particles, 2))
      n += layer.size();
    return sum_over_ranks(n, MPI_COMM_WORLD);
  };
  const long long all = count();
  auto window = scene.mesh.leaves().window;
  window.lower[0] = 1;
  scene.mesh.set_window(window);
  EXPECT_EQ(scene.particles.n_global(), all);
  EXPECT_EQ(count(), dim == 3 ? 2 : 1); // of 6 or 3
}

RigidSystems turned_body(TriangleMesh mesh)
{
  RigidSystems bodies;
  bodies.points.resize(2);
  bodies.points[1].pose.position = {5., 0., 7.};
  bodies.points[1].pose.rotation = rotation_from_vector({0., M_PI / 2., 0.}); // x -> -z, z -> x
  bodies.points[1].velocity << 1., 0., 0., 0., 2., 0.;
  bodies.surfaces.push_back({Surface(std::move(mesh)), 1});
  bodies.tracked.push_back({Eigen::Vector3d(0., 0., 3.), 1});
  return bodies;
}

const std::vector<float>& floats(const DataArray& array) { return std::get<std::vector<float>>(array.values); }
const std::vector<std::int32_t>& integers(const DataArray& array)
{
  return std::get<std::vector<std::int32_t>>(array.values);
}

TEST(BodyGrids, RigidPointsCarryTheirFields)
{
  const RigidSystems bodies = turned_body(test::cube());
  std::vector<Vector6> reactions(2, Vector6::Zero());
  reactions[1][2] = -4.;
  const UnstructuredGrid grid = rigid_points(bodies, reactions, select_body_fields({"velocity", "reaction force"}));
  EXPECT_EQ(grid.points, Points({0, 0, 0, 5, 0, 7}));
  EXPECT_EQ(floats(grid.point_data.at(0)), std::vector<float>({0, 0, 0, 1, 0, 0}));
  EXPECT_EQ(floats(grid.point_data.at(1)), std::vector<float>({0, 0, 0, 0, 0, -4}));
}

TEST(BodyGrids, TrackedNodeMovesWithItsBody)
{
  const UnstructuredGrid grid = tracked_nodes(turned_body(test::cube()));
  ASSERT_EQ(grid.n_points(), 1u);
  EXPECT_NEAR(grid.points[0], 8., 1e-14);
  EXPECT_NEAR(grid.points[2], 7., 1e-14);
  EXPECT_EQ(integers(grid.point_data.at(0)), std::vector<std::int32_t>({1})); // track
  EXPECT_EQ(integers(grid.point_data.at(1)), std::vector<std::int32_t>({2})); // body
  // v + omega x r with r = [3, 0, 0]
  const std::vector<float>& velocity = floats(grid.point_data.at(2));
  EXPECT_NEAR(velocity[0], 1., 1e-6);
  EXPECT_NEAR(velocity[1], 0., 1e-6);
  EXPECT_NEAR(velocity[2], -6., 1e-6);
}

TEST(BodyGrids, SurfaceStandsWhereTheBodyIs)
{
  const UnstructuredGrid grid = body_surfaces<3>(turned_body(test::cube()), {}, MPI_COMM_SELF);
  EXPECT_EQ(grid.shape, CellShape::triangle);
  EXPECT_EQ(grid.n_points(), 8u);
  EXPECT_EQ(grid.n_cells(), 12u);
  // vertex 0 = [-1, -1, -1] turns to [-1, -1, 1]
  EXPECT_NEAR(grid.points[0], 4., 1e-14);
  EXPECT_NEAR(grid.points[1], -1., 1e-14);
  EXPECT_NEAR(grid.points[2], 8., 1e-14);
  EXPECT_EQ(integers(grid.cell_data.at(0)), std::vector<std::int32_t>(12, 2));
  // v + omega x r with r = [-1, -1, 1]
  EXPECT_NEAR(floats(grid.point_data.at(0))[0], 3., 1e-6);
  EXPECT_NEAR(floats(grid.point_data.at(0))[2], 2., 1e-6);
}

TEST(BodyGrids, ContactForceIsTheReactionPerArea)
{
  RigidSystems bodies = turned_body(test::cube());
  // After the turn the side x = -1 of the body faces +z of the world; both points press on one of its triangles.
  const std::vector<ContactForce> contact = {{{5.5, 0.5, 7.9}, {1., 0., 3.}, 0}, {{5.6, 0.5, 7.95}, {0., 0., 5.}, 0}};
  const UnstructuredGrid grid = body_surfaces<3>(bodies, contact, MPI_COMM_SELF);
  const std::vector<float>& force = floats(grid.cell_data.at(1));
  unsigned int n_loaded = 0;
  for (std::size_t face = 0; face < 12; ++face)
  {
    if (force[3 * face + 2] == 0.f)
      continue;
    ++n_loaded;
    EXPECT_FLOAT_EQ(force[3 * face], -1.f / 2.f); // the triangles have 2 m2
    EXPECT_FLOAT_EQ(force[3 * face + 2], -8.f / 2.f);
  }
  EXPECT_EQ(n_loaded, 1u);
}

TEST(BodyGrids, OutlineInPlaneStrain)
{
  // a rectangle of 2 m by 4 m
  RigidSystems bodies;
  bodies.points.resize(1);
  bodies.points[0].pose.position = {10., 0., 20.};
  bodies.surfaces.push_back({Surface(extrude_outline({{-1, -2}, {1, -2}, {1, 2}, {-1, 2}}, "outline")), 0});
  // 6 N and 2 N per metre on the soil below, at different places of the lower side
  const UnstructuredGrid grid = body_surfaces<2>(
      bodies, {{{9.2, 0., 18.05}, {0., 0., -6.}, 0}, {{10.9, 0., 18.05}, {0., 0., -2.}, 0}}, MPI_COMM_SELF);
  EXPECT_EQ(grid.shape, CellShape::line);
  ASSERT_EQ(grid.n_points(), 4u);
  ASSERT_EQ(grid.n_cells(), 4u);
  unsigned int n_loaded = 0;
  for (std::size_t side = 0; side < 4; ++side)
  {
    const double *a = &grid.points[3 * grid.connectivity[2 * side]],
                 *b = &grid.points[3 * grid.connectivity[2 * side + 1]];
    EXPECT_EQ(a[1], 0.);
    EXPECT_NE(a[0] == b[0], a[2] == b[2]) << "side " << side << " is not a side of the rectangle";
    const bool is_lower = a[2] == 18. && b[2] == 18.;
    n_loaded += is_lower;
    EXPECT_FLOAT_EQ(floats(grid.cell_data.at(1))[3 * side + 2], is_lower ? 4.f : 0.f); // 8 N/m over 2 m
  }
  EXPECT_EQ(n_loaded, 1u);
}
} // namespace
} // namespace kedge
