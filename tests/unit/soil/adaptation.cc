// The mesh follows the bodies: sizes, particles, ranks.
#include "../bodies/shapes.h"
#include "../soil_fixture.h"
#include <gtest/gtest.h>
#include <kedge/soil/adaptation.h>
#include <set>

using namespace kedge;

namespace
{
/// A cell of any rank.
template <int dim> struct Cell
{
  std::array<double, dim> lower;
  double size;

  bool operator<(const Cell& other) const { return std::tie(lower, size) < std::tie(other.lower, other.size); }
  bool operator==(const Cell& other) const { return lower == other.lower && size == other.size; }
};

/// Soil that fills the lower half of a grid of 4 base cells of 0.4 m per axis, cut by a turned slab and with a little
/// ball inside one cell.
template <int dim> struct SlabInSoil : test::SoilFixture<dim>
{
  static constexpr double base = 0.4, finest = 0.1;
  using test::SoilFixture<dim>::mesh;
  using test::SoilFixture<dim>::particles;

  explicit SlabInSoil(const MPI_Comm communicator = MPI_COMM_WORLD)
      : test::SoilFixture<dim>(layout(), test::layers_of({test::elastic_layer(0.8)}), 10., {}, communicator)
  {
    adaptivity.type = AdaptivityType::rigid_body_surface;
    adaptivity.element_size = finest;
    bodies.points.resize(2);
    bodies.points[0].pose.rotation = rotation_from_vector({dim == 3 ? 0.3 : 0., 0.5, dim == 3 ? 0.2 : 0.});
    bodies.surfaces.push_back(
        {Surface(dim == 3 ? test::box({-0.3, -0.25, -0.04}, {0.3, 0.25, 0.04})
                          : extrude_outline({{-0.3, -0.04}, {0.3, -0.04}, {0.3, 0.04}, {-0.3, 0.04}}, "slab")),
         0});
    bodies.surfaces.push_back(
        {Surface(dim == 3 ? test::sphere(0.02, 1) : extrude_outline({{-0.02, 0.}, {0., -0.02}, {0.02, 0.}}, "ball")),
         1});
    place({0.61, 0.83, 0.7});
    bodies.points[1].pose.position = Eigen::Vector3d(1.31, dim == 3 ? 0.27 : 0., 0.22);
  }

  static GridLayout<dim> layout()
  {
    std::array<unsigned int, dim> cells;
    cells.fill(4);
    GridLayout<dim> grid = test::make_brick<dim>(cells, base, 0.5);
    grid.finest_size = finest;
    return grid;
  }

  void place(const Eigen::Vector3d& position)
  {
    bodies.points[0].pose.position = {position[0], dim == 3 ? position[1] : 0., position[2]};
  }

  /// Fits the cells, with the particles as they are; returns whether anything changed.
  bool adapt()
  {
    using Pass = typename CellAdaptation<dim>::Pass;
    CellAdaptation<dim> adaptation(mesh, particles, bodies, adaptivity, points_per_axis);
    bool changed = false;
    passes = 0;
    for (Pass pass = adaptation.next(); pass != Pass::none; pass = adaptation.next())
    {
      passes += pass == Pass::cells;
      changed = true;
    }
    return changed;
  }

  std::vector<Cell<dim>> cells() const
  {
    std::vector<Cell<dim>> cells;
    for (const auto& leaf : mesh.leaves().leaves)
      if (leaf.owned)
        cells.push_back({leaf.lower, leaf.size});
    cells = gather_everywhere(cells, mesh.communicator());
    std::sort(cells.begin(), cells.end());
    return cells;
  }

  static constexpr unsigned int points_per_axis = 2;
  RigidSystems bodies;
  Adaptivity adaptivity;
  unsigned int passes = 0;
};

template <typename Dimension> class Adaptation : public testing::Test, public SlabInSoil<Dimension::value>
{
public:
  static constexpr int dim = Dimension::value;
  using Box = Cell<dim>;

  static Box parent_of(const Box& cell)
  {
    Box parent{{}, 2. * cell.size};
    for (unsigned int d = 0; d < dim; ++d)
      parent.lower[d] = parent.size * std::floor(cell.lower[d] / parent.size + 0.1);
    return parent;
  }

  /// Whether the boxes overlap or, with a positive margin (m), touch.
  static bool meet(const Box& a, const Box& b, const double margin)
  {
    bool meet = true;
    for (unsigned int d = 0; d < dim; ++d)
      meet = meet && a.lower[d] < b.lower[d] + b.size + margin && b.lower[d] < a.lower[d] + a.size + margin;
    return meet;
  }

  /// Particles of all ranks; they are square.
  std::vector<Box> all_particles() const
  {
    std::vector<Box> boxes;
    for (std::size_t p = 0; p < this->particles.ids().size(); ++p)
    {
      const double half = this->particles.half_widths()[p][0];
      boxes.push_back({this->particles.positions()[p], 2. * half});
      for (double& x : boxes.back().lower)
        x -= half;
    }
    return gather_everywhere(boxes, MPI_COMM_WORLD);
  }

  OrientedBox in_space(const Box& cell) const
  {
    // in plane strain not quite flat: clipping would trip over points in the plane
    const double back = dim == 3 ? cell.lower[1] : -1e-6, width = dim == 3 ? cell.size : 2e-6;
    const Eigen::Vector3d size(cell.size, width, cell.size);
    return {Eigen::Vector3d(cell.lower[0], back, cell.lower[dim - 1]) + 0.5 * size, Eigen::Matrix3d::Identity(),
            0.5 * size};
  }

  bool crosses(const Box& cell) const
  {
    for (const WeldedSurface& welded : this->bodies.surfaces)
      for (const auto& triangle : welded.surface.mesh().triangles)
      {
        std::vector<Eigen::Vector3d> corners;
        for (const unsigned int v : triangle)
          corners.push_back(this->bodies.points[welded.point].pose.to_world(welded.surface.mesh().vertices[v]));
        if (test::crosses_by_clipping(corners, in_space(cell)))
          return true;
      }
    return false;
  }

  double wanted(const Box& cell) const
  {
    if (crosses(cell))
      return this->finest;
    for (const RefinedBox& box : this->adaptivity.boxes)
    {
      double narrowest = this->base;
      for (unsigned int d = 0; d < dim; ++d)
        narrowest =
            std::min(narrowest, std::min(cell.lower[d] + cell.size, box.max[d]) - std::max(cell.lower[d], box.min[d]));
      if (narrowest > 1e-9)
        return box.element_size;
    }
    const OrientedBox box = in_space(cell);
    return this->adaptivity.region > 0. && surface_comes_within(this->bodies, box.centre - box.half_width,
                                                                box.centre + box.half_width, this->adaptivity.region)
               ? this->adaptivity.element_size_in_region
               : this->base;
  }

  /// Cells that hold soil are as fine as wanted, and no cell is finer without a reason: its parent was larger than
  /// wanted and held soil, or touches a cell of less than half its children's size.
  void expect_the_coarsest_mesh_that_is_wanted() const
  {
    const std::vector<Box> soil = all_particles(), cells = this->cells();
    const auto holds_soil = [&](const Box& cell)
    { return std::any_of(soil.begin(), soil.end(), [&](const Box& box) { return meet(box, cell, -1e-6); }); };
    const auto has_to_be_refined = [&](const Box& cell) { return cell.size > 1.01 * wanted(cell) && holds_soil(cell); };
    std::set<Box> parents;
    for (const Box& cell : cells)
    {
      EXPECT_FALSE(has_to_be_refined(cell));
      if (cell.size < 0.99 * this->base)
        parents.insert(parent_of(cell));
    }
    for (const Box& parent : parents)
      EXPECT_TRUE(has_to_be_refined(parent) ||
                  std::any_of(cells.begin(), cells.end(),
                              [&](const Box& cell)
                              { return cell.size < 0.3 * parent.size && meet(cell, parent, 1e-6); }));
  }

  bool has_base_cells_only() const
  {
    const auto cells = this->cells();
    return std::all_of(cells.begin(), cells.end(), [&](const Box& cell) { return cell.size == this->base; });
  }
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(Adaptation, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(Adaptation, RefinesTheCellsWithSoilThatASurfaceCrossesAndNoOthers)
{
  ASSERT_TRUE(this->adapt());
  this->expect_the_coarsest_mesh_that_is_wanted();
}

TYPED_TEST(Adaptation, RefinesTheRegionAroundTheSurfaces)
{
  this->adaptivity.region = 0.12; // 2:1 alone makes cells of half the base size farther than that
  this->adaptivity.element_size_in_region = this->finest;
  ASSERT_TRUE(this->adapt());
  this->expect_the_coarsest_mesh_that_is_wanted();
}

TYPED_TEST(Adaptation, KeepsABoxFineWhereverTheBodyIs)
{
  this->adapt();
  const auto few = this->cells().size();
  RefinedBox box;
  box.min.fill(0.5 * this->base);
  box.max.fill(this->base); // ends on faces of cells, which does not refine those beyond
  box.element_size = this->finest;
  this->adaptivity.boxes = {box};
  ASSERT_TRUE(this->adapt());
  EXPECT_GT(this->cells().size(), few);
  this->expect_the_coarsest_mesh_that_is_wanted();
  this->bodies.points[1].pose.position[0] += 100.;
  this->place({100., 0., 0.});
  ASSERT_TRUE(this->adapt());
  EXPECT_FALSE(this->has_base_cells_only());
  this->expect_the_coarsest_mesh_that_is_wanted();
}

TYPED_TEST(Adaptation, ChangesNothingTheSecondTime)
{
  ASSERT_TRUE(this->adapt());
  const auto cells = this->cells();
  EXPECT_FALSE(this->adapt());
  EXPECT_EQ(this->passes, 0u);
  EXPECT_EQ(this->cells(), cells);
}

TYPED_TEST(Adaptation, LetsParticlesBeSplitAfterEachOfTwoLevels)
{
  this->adapt();
  EXPECT_EQ(this->passes, 2u);
}

TYPED_TEST(Adaptation, CoarsensBehindTheBody)
{
  this->adapt();
  this->bodies.points[1].pose.position[0] += 100.;
  this->place({100., 0., 0.});
  ASSERT_TRUE(this->adapt());
  EXPECT_TRUE(this->has_base_cells_only());
}

TYPED_TEST(Adaptation, CoarsensInAStageWithoutRefinement)
{
  this->adapt();
  this->adaptivity.type = AdaptivityType::none;
  ASSERT_TRUE(this->adapt());
  EXPECT_TRUE(this->has_base_cells_only());
}

TYPED_TEST(Adaptation, CoarsensCellsWhoseChildrenAreOnSeveralRanks)
{
  // all soil fine: on three ranks a boundary between them passes through a base cell
  this->adaptivity.region = 10.;
  this->adaptivity.element_size_in_region = this->finest;
  this->adapt();
  this->adaptivity.type = AdaptivityType::none;
  ASSERT_TRUE(this->adapt());
  EXPECT_TRUE(this->has_base_cells_only());
}

TYPED_TEST(Adaptation, KeepsTheCellsThatSmallParticlesNeed)
{
  constexpr int dim = TypeParam::value;
  this->adapt();
  for (auto& particle : this->particles.edit())
    for (unsigned int d = 0; d < dim; ++d)
      particle.get_properties()[field::half_width + d] *= 0.5;
  std::vector<Cell<dim>> refined; // cells of half the base size that hold particles, or whose children do
  for (const unsigned int number : this->particles.leaves())
  {
    const auto& leaf = this->mesh.leaves().leaves[number];
    const Cell<dim> cell{leaf.lower, leaf.size};
    if (cell.size < 0.75 * this->base)
      refined.push_back(cell.size < 0.375 * this->base ? this->parent_of(cell) : cell);
  }
  refined = gather_everywhere(refined, MPI_COMM_WORLD);
  this->adaptivity.type = AdaptivityType::none;
  this->adapt();
  ASSERT_FALSE(refined.empty());
  const auto cells = this->cells();
  for (const auto& cell : refined)
    EXPECT_TRUE(std::any_of(cells.begin(), cells.end(),
                            [&](const Cell<dim>& other)
                            { return other.size == cell.size && this->meet(other, cell, -1e-6); }));
}

TYPED_TEST(Adaptation, GivesTheSameMeshOnAnyNumberOfRanksAlongAPath)
{
  SlabInSoil<TypeParam::value> alone(MPI_COMM_SELF);
  for (const double forward : {0., 0.15, 0.3, 0.6})
  {
    for (SlabInSoil<TypeParam::value>* scene : {static_cast<SlabInSoil<TypeParam::value>*>(this), &alone})
    {
      scene->place({0.61 + forward, 0.83 - 0.2 * forward, 0.7 - 0.5 * forward});
      scene->adapt();
    }
    EXPECT_EQ(this->cells(), alone.cells()) << "moved by " << forward;
    this->expect_the_coarsest_mesh_that_is_wanted();
  }
}

TYPED_TEST(Adaptation, KeepsParticlesAndTheirData)
{
  constexpr int dim = TypeParam::value;
  const auto all_data = [&]
  {
    std::vector<std::array<double, field::count>> data;
    for (const auto& particle : this->particles.handler())
    {
      const auto& properties = particle.get_properties();
      data.emplace_back();
      std::copy_n(properties.begin(), field::count, data.back().begin());
      data.back()[field::contact_gap] = particle.get_id(); // the gap is NaN
      for (unsigned int d = 0; d < dim; ++d)
        EXPECT_EQ(particle.get_location()[d], properties[field::initial_position + d]);
    }
    data = gather_everywhere(data, MPI_COMM_WORLD);
    std::sort(data.begin(), data.end());
    return data;
  };
  const auto before = all_data();
  this->adapt();
  this->place({1., 0.8, 0.6});
  this->adapt();
  EXPECT_EQ(all_data(), before);
  for (std::size_t p = 0; p < this->particles.ids().size(); ++p)
  {
    const auto& leaf = this->mesh.leaves().leaves[this->particles.leaves()[p]];
    EXPECT_TRUE(leaf.owned);
    EXPECT_TRUE(this->meet({leaf.lower, leaf.size}, {this->particles.positions()[p], 0.}, 1e-12)); // or in a face
  }
}

TYPED_TEST(Adaptation, RefinesUnderABodyThatRestsOnTheSoil)
{
  this->bodies.points[0].pose.rotation = Eigen::Quaterniond::Identity();
  this->bodies.points[1].pose.position[0] += 100.;
  this->place({0.61, 0.83, 0.84 + 5e-8}); // as near as single precision comes
  ASSERT_TRUE(this->adapt());
  const auto cells = this->cells();
  Cell<TypeParam::value> below{{}, this->finest};
  below.lower.fill(0.6);
  below.lower[TypeParam::value - 1] = 0.7;
  EXPECT_TRUE(std::any_of(cells.begin(), cells.end(),
                          [&](const Cell<TypeParam::value>& cell)
                          { return cell.size == this->finest && this->meet(cell, below, -1e-6); }));
}
