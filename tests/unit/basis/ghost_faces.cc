#include "ghost_reference.h"
#include <gtest/gtest.h>

using namespace kedge;
using namespace kedge::test;

namespace
{
/// The faces of random soil on a refined mesh.
template <typename Dimension> class GhostFacesOfRandomSoil : public testing::Test
{
public:
  static constexpr int dim = Dimension::value;

  const LeafTable<dim>& table() const { return refined.mesh.leaves(); }
  std::size_t n_faces() const { return faces.stiffness.size(); }
  static double random_field(const std::array<double, dim>& x) { return noise_at(x, dim, 31); }

  /// Largest over the faces of all ranks of a number per matrix.
  template <typename Error> double worst(const Error& error) const
  {
    double largest = 0.;
    for (std::size_t f = 0; f < n_faces(); ++f)
      largest = std::max(largest, error(matrix_of(faces, f), f));
    return max_over_ranks(largest, MPI_COMM_WORLD);
  }

  RefinedMesh<dim> refined;
  HostGhostFaces faces = find_faces<dim>(table(), random_fill<dim>);
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(GhostFacesOfRandomSoil, Dimensions, DimensionName);

/// Names a set of nodes, whatever their order.
template <int dim> long long signature(const LeafTable<dim>& table, const std::vector<unsigned int>& nodes)
{
  long long sum = 0;
  for (const unsigned int node : nodes)
    sum += std::llround(std::ldexp(noise_at(table.node_position[node], dim, 41), 50));
  return sum;
}
} // namespace

TYPED_TEST(GhostFacesOfRandomSoil, AreThoseOfTheDefinitionOnOneRankEach)
{
  constexpr int dim = TypeParam::value;
  std::vector<long long> found, expected;
  for (std::size_t f = 0; f < this->n_faces(); ++f)
  {
    const auto nodes = this->faces.nodes.begin();
    found.push_back(
        signature<dim>(this->table(), {nodes + this->faces.node_begin[f], nodes + this->faces.node_begin[f + 1]}));
  }
  found = gather_everywhere(found, MPI_COMM_WORLD);
  const Reference<dim> reference;
  for (const auto& face : reference.stabilised())
  {
    std::vector<unsigned int> nodes;
    for (const Leaf<dim>* leaf : {face.lower, face.upper})
      nodes.insert(nodes.end(), reference.table().nodes.begin() + leaf->node_begin,
                   reference.table().nodes.begin() + leaf->node_begin + leaf->n_nodes);
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    expected.push_back(signature<dim>(reference.table(), nodes));
  }
  std::sort(found.begin(), found.end());
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(found, expected);
}

TYPED_TEST(GhostFacesOfRandomSoil, WeighTheJumpsByTheMeanStiffness)
{
  constexpr int dim = TypeParam::value;
  const Reference<dim> reference;
  double expected = 0.;
  for (const auto& face : reference.stabilised())
    expected += factors.stiffness * 0.5 * (young_of<dim>(*face.lower) + young_of<dim>(*face.upper)) *
                reference.jump_energy(face, this->random_field);
  EXPECT_NEAR(energy<dim>(this->table(), this->faces, this->faces.stiffness, this->random_field), expected,
              1e-12 * expected);
}

TYPED_TEST(GhostFacesOfRandomSoil, WeighTheJumpsByTheMeanDensity)
{
  constexpr int dim = TypeParam::value;
  const Reference<dim> reference;
  double expected = 0.;
  for (const auto& face : reference.stabilised())
    expected += factors.mass * 0.5 * (density_of<dim>(*face.lower) + density_of<dim>(*face.upper)) *
                reference.jump_energy(face, this->random_field);
  EXPECT_NEAR(energy<dim>(this->table(), this->faces, this->faces.mass, this->random_field), expected,
              1e-12 * expected);
}

TYPED_TEST(GhostFacesOfRandomSoil, HaveSymmetricMatrices)
{
  EXPECT_LT(this->worst([](const Matrix& J, std::size_t)
                        { return (J - J.transpose()).cwiseAbs().maxCoeff() / J.cwiseAbs().maxCoeff(); }),
            1e-15);
}

TYPED_TEST(GhostFacesOfRandomSoil, HaveNoNegativeEigenvalues)
{
  EXPECT_LT(this->worst(
                [](const Matrix& J, std::size_t)
                {
                  const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(J).eigenvalues();
                  return -values.minCoeff() / values.maxCoeff();
                }),
            1e-12);
}

TYPED_TEST(GhostFacesOfRandomSoil, HaveRowsThatSumToZero)
{
  EXPECT_LT(this->worst([](const Matrix& J, std::size_t)
                        { return J.rowwise().sum().cwiseAbs().maxCoeff() / J.cwiseAbs().maxCoeff(); }),
            1e-12);
}

TYPED_TEST(GhostFacesOfRandomSoil, LeaveLinearFieldsAlone)
{
  EXPECT_LT(this->worst(
                [&](const Matrix& J, const std::size_t f)
                {
                  double largest = 0.;
                  for (unsigned int axis = 0; axis < TypeParam::value; ++axis)
                  {
                    const auto values =
                        at_nodes(this->table(), this->faces, f, [axis](const auto& x) { return x[axis]; });
                    largest = std::max(largest, (J * values).cwiseAbs().maxCoeff() / J.cwiseAbs().maxCoeff());
                  }
                  return largest; // m, on a grid of about 1 m
                }),
            1e-12);
}

TYPED_TEST(GhostFacesOfRandomSoil, CountTheSoilOfAllRanks)
{
  // Boxes of about half a cell at random places: some reach into neighbours, also those of other ranks.
  constexpr int dim = TypeParam::value;
  const auto make_boxes = [](const LeafTable<dim>& table)
  {
    Soil<dim> soil = make_soil<dim>(table, [](const Leaf<dim>&) { return Fill::full; });
    for (std::size_t p = 0; p < soil.centre.size(); ++p)
    {
      const auto seed = soil.centre[p];
      for (unsigned int d = 0; d < dim; ++d)
      {
        const double size = soil.half_width[p][d] / 0.49;
        const double reach =
            std::min({0.4 * size, seed[d] - 0.3 * size, RefinedMesh<dim>::layout().extent(d) - seed[d] - 0.3 * size});
        soil.centre[p][d] += reach * (2. * noise_at(seed, dim, 50 + d) - 1.);
        soil.half_width[p][d] = 0.25 * size;
      }
    }
    return soil;
  };
  const std::vector<LeafContent> contents = find_contents(this->table(), make_boxes(this->table()), poor_factor);
  const Reference<dim> reference;
  const Soil<dim> all = make_boxes(reference.table());
  double largest = 0.;
  for (std::size_t i = 0; i < contents.size(); ++i)
  {
    const auto& leaf = this->table().leaves[i];
    LeafContent expected;
    for (std::size_t p = 0; p < all.centre.size(); ++p)
    {
      double share = 1., volume = 1.;
      for (unsigned int d = 0; d < dim; ++d)
      {
        const double x = all.centre[p][d], half = all.half_width[p][d];
        share *= std::max(0., std::min(x + half, leaf.lower[d] + leaf.size) - std::max(x - half, leaf.lower[d]));
        volume *= 2. * half;
      }
      expected.volume += share;
      expected.initial_volume += share * all.initial_volume[p] / volume;
      expected.stiffness += share * all.young[p];
      expected.mass += share * all.mass[p] / volume;
    }
    const double scale = std::pow(leaf.size, dim);
    largest = std::max({largest, std::abs(contents[i].volume - expected.volume) / scale,
                        std::abs(contents[i].initial_volume - expected.initial_volume) / scale,
                        std::abs(contents[i].stiffness - expected.stiffness) / (1e6 * scale),
                        std::abs(contents[i].mass - expected.mass) / (2e3 * scale)});
  }
  EXPECT_LT(max_over_ranks(largest, MPI_COMM_WORLD), 1e-10); // slivers below 1e-11 of a box are left out
}

namespace
{
/// A grid of five equal cells in every direction.
template <typename Dimension> class GhostFacesOnRegularCells : public testing::Test
{
public:
  static constexpr int dim = Dimension::value;
  static constexpr double size = 0.3;

  static GridLayout<dim> layout()
  {
    std::array<unsigned int, dim> cells;
    cells.fill(5);
    return make_brick<dim>(cells, size);
  }

  static bool is_middle(const Leaf<dim>& leaf)
  {
    return std::all_of(leaf.lower.begin(), leaf.lower.end(),
                       [](const double x) { return std::abs(x - 2. * size) < hair; });
  }

  /// Number of faces if the middle cell differs from all other cells, which are full.
  long long count_faces(const Fill middle) const
  {
    const auto fill = [middle](const Leaf<dim>& leaf) { return is_middle(leaf) ? middle : Fill::full; };
    return sum_over_ranks(static_cast<long long>(find_faces<dim>(mesh.leaves(), fill).stiffness.size()),
                          MPI_COMM_WORLD);
  }

  /// Integral of J for a field that bends by a unit slope at the third layer of faces, all faces stabilised.
  double energy_of_a_kink() const
  {
    const HostGhostFaces faces = find_faces<dim>(
        mesh.leaves(), [](const Leaf<dim>&) { return Fill::full; }, 1.);
    return energy<dim>(mesh.leaves(), faces, std::vector<double>(faces.stiffness.size(), 1.),
                       [](const std::array<double, dim>& x) { return std::max(0., x[0] - 3. * size); });
  }

  BackgroundMesh<dim> mesh{MPI_COMM_WORLD, layout()};
};
TYPED_TEST_SUITE(GhostFacesOnRegularCells, Dimensions, DimensionName);
} // namespace

TYPED_TEST(GhostFacesOnRegularCells, TheBoundaryOfTheGridNeedsNone) { EXPECT_EQ(this->count_faces(Fill::full), 0); }

TYPED_TEST(GhostFacesOnRegularCells, SurroundAPoorlyFilledCell)
{
  EXPECT_EQ(this->count_faces(Fill::poor), 2 * TypeParam::value);
}

TYPED_TEST(GhostFacesOnRegularCells, AreThoseOfTheNeighboursOfAnEmptyCellExceptTowardsIt)
{
  constexpr int n_neighbours = 2 * TypeParam::value;
  EXPECT_EQ(this->count_faces(Fill::empty), n_neighbours * (n_neighbours - 1));
}

TYPED_TEST(GhostFacesOnRegularCells, ReachACellThatABoxHardlyTouches)
{
  // 1e-10 of the box, ten times what the basis takes for round-off, pokes out of the middle cell
  constexpr int dim = TypeParam::value;
  Soil<dim> soil = make_soil<dim>(this->mesh.leaves(), [this](const Leaf<dim>& leaf)
                                  { return this->is_middle(leaf) ? Fill::full : Fill::empty; });
  for (std::size_t p = 0; p < soil.centre.size(); ++p)
    soil.centre[p][0] += 0.5 * this->size - soil.half_width[p][0] * (1. - 2e-10);
  const HostGhostFaces faces =
      find_ghost_faces<dim>(this->mesh.leaves(), find_contents(this->mesh.leaves(), soil, poor_factor), factors);
  EXPECT_EQ(sum_over_ranks(static_cast<long long>(faces.stiffness.size()), MPI_COMM_WORLD), 1);
}

TYPED_TEST(GhostFacesOnRegularCells, MeasureAKink)
{
  const double area = std::pow(5. * this->size, TypeParam::value - 1), h = this->size;
  EXPECT_NEAR(this->energy_of_a_kink(), h * h * h / 3. * area, 1e-12 * h * h * h);
}

TYPED_TEST(GhostFacesOnRegularCells, MeasureAKinkByTheSmallerCellsAtAChangeOfSize)
{
  for (const auto& cell : this->mesh.triangulation().active_cell_iterators())
    if (cell->is_locally_owned() && cell->center()[0] > 3. * this->size)
      cell->set_refine_flag();
  this->mesh.triangulation().execute_coarsening_and_refinement();
  this->mesh.update();
  const double area = std::pow(5. * this->size, TypeParam::value - 1), h = 0.5 * this->size;
  EXPECT_NEAR(this->energy_of_a_kink(), h * h * h / 3. * area, 1e-12 * h * h * h);
}
