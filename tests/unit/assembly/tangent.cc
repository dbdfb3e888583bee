#include "../basis/box_average.h"
#include "block.h"
#include <Eigen/Dense>
#include <gtest/gtest.h>
#include <kedge/assembly/acting_points.h>
#include <kedge/assembly/deformation.h>
#include <kedge/solvers/linear_solver.h>

using namespace kedge;

namespace
{
template <typename Dimension> class TangentMatrix : public testing::Test
{
public:
  static constexpr int dim = Dimension::value;

  void use(const MaterialParameters& material, const bool stressed = true, const bool f_bar = false)
  {
    block = std::make_unique<test::Block<dim>>(material, MPI_COMM_WORLD, stressed);
    system = block->parts->make_system(f_bar);
    cells = f_bar ? block->parts->cells : CellGroups{};
  }

  void assemble(const TpetraVector& increment)
  {
    system->clear_matrix();
    deform<dim>(block->particles.arrays(), block->parts->stencils, system->spread(increment));
    add_tangent<dim>(block->particles.arrays(), block->parts->stencils, block->materials, system->graph(),
                     system->values(), cells);
    system->finish_matrix();
  }

  TpetraVector times(const TpetraVector& x) const
  {
    TpetraVector y(system->graph().row_map);
    system->matrix()->apply(x, y);
    return y;
  }

  /// Largest error of the tangent against differences of the force in random directions, relative to the tangent.
  double error_against_differences(const double strain)
  {
    const TpetraVector increment = block->parts->owned(*system, block->random_field(strain, 1));
    test::internal_force(*block, *system, increment, cells); // the shared pressure comes from these stresses
    assemble(increment);
    constexpr double step = 1e-4;
    double worst = 0.;
    for (unsigned int direction = 0; direction < 4; ++direction)
    {
      const TpetraVector change = block->parts->owned(*system, block->random_field(strain, 100 * (direction + 1)));
      TpetraVector ahead(increment, Teuchos::Copy), behind(increment, Teuchos::Copy);
      ahead.update(step, change, 1.);
      behind.update(-step, change, 1.);
      TpetraVector difference = test::internal_force(*block, *system, ahead, cells);
      difference.update(-0.5 / step, test::internal_force(*block, *system, behind, cells), 0.5 / step);
      const TpetraVector product = times(change);
      difference.update(-1., product, 1.);
      worst = std::max(worst, difference.normInf() / product.normInf());
    }
    return worst;
  }

  std::array<long long, 2> count_plastic_and_tensile() const
  {
    const auto plastic = copy_to_host(block->particles.arrays().trial_plastic);
    const auto stress = copy_to_host(block->particles.arrays().trial_stress);
    long long n_plastic = 0, n_tensile = 0;
    for (std::size_t p = 0; p < plastic.extent(0); ++p)
    {
      n_plastic += plastic(p) > 0.;
      n_tensile += stress(p, 0) + stress(p, 1) + stress(p, 2) > 0.;
    }
    return {{sum_over_ranks(n_plastic, MPI_COMM_WORLD), sum_over_ranks(n_tensile, MPI_COMM_WORLD)}};
  }

  std::unique_ptr<test::Block<dim>> block;
  std::unique_ptr<System> system;
  CellGroups cells; ///< empty without F-bar
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(TangentMatrix, Dimensions, test::DimensionName);
} // namespace

TYPED_TEST(TangentMatrix, IsTheDerivativeOfTheElasticForce)
{
  this->use(test::soil_material<Elastic>());
  EXPECT_LT(this->error_against_differences(0.1), 1e-6);
}

TYPED_TEST(TangentMatrix, IsTheDerivativeOfTheMohrCoulombForce)
{
  this->use(test::soil_material<MohrCoulomb>());
  EXPECT_LT(this->error_against_differences(5e-3), 1e-6);
  const auto [plastic, tensile] = this->count_plastic_and_tensile();
  EXPECT_GT(plastic, this->block->particles.n_global() / 10);
  EXPECT_LT(plastic, this->block->particles.n_global());
  EXPECT_EQ(tensile, 0); // at an apex the tangent keeps a residual stiffness that differences do not have
}

TYPED_TEST(TangentMatrix, IsTheDerivativeOfTheElasticForceWithFBar)
{
  this->use(test::soil_material<Elastic>(), true, true);
  EXPECT_LT(this->error_against_differences(0.1), 1e-6);
}

TYPED_TEST(TangentMatrix, IsTheDerivativeOfTheMohrCoulombForceWithFBar)
{
  this->use(test::soil_material<MohrCoulomb>(), true, true);
  EXPECT_LT(this->error_against_differences(5e-3), 1e-6);
  const auto [plastic, tensile] = this->count_plastic_and_tensile();
  EXPECT_GT(plastic, this->block->particles.n_global() / 10);
  EXPECT_LT(plastic, this->block->particles.n_global());
  EXPECT_EQ(tensile, 0);
}

TYPED_TEST(TangentMatrix, IsTheDerivativeOfTheForceOfALawWithMemory)
{
  this->use(test::softening_soil());
  Kokkos::deep_copy(this->block->particles.arrays().state, 0.01);
  EXPECT_LT(this->error_against_differences(5e-3), 1e-6);
  const auto [plastic, tensile] = this->count_plastic_and_tensile();
  EXPECT_GT(plastic, this->block->particles.n_global() / 10);
  EXPECT_EQ(tensile, 0);
}

TYPED_TEST(TangentMatrix, SeesNoRigidBodyModesWithoutStress)
{
  constexpr int dim = TypeParam::value;
  this->use(test::soil_material<Elastic>(), false);
  this->assemble(TpetraVector(this->system->graph().row_map));
  std::vector<double> position;
  for (unsigned int v = 0; v < this->block->parts->nodes.n_owned; ++v)
    for (unsigned int d = 0; d < dim; ++d)
      position.push_back(this->block->parts->position[v][d]);
  const auto modes = make_rigid_body_modes(this->system->graph().row_map, dim, position,
                                           std::vector<unsigned char>(position.size(), 0));
  const double scale =
      this->times(this->block->parts->owned(*this->system, this->block->random_field(1., 1))).normInf();
  for (std::size_t mode = 0; mode < modes->getNumVectors(); ++mode)
    EXPECT_LT(this->times(*modes->getVector(mode)).normInf(), 1e-10 * scale) << "mode " << mode;
}

TYPED_TEST(TangentMatrix, IsThatOfOneRank)
{
  // The reference sums over the particles of a mesh that is this rank's alone, without any matrix.
  constexpr int dim = TypeParam::value;
  this->use(test::soil_material<MohrCoulomb>());
  const auto increment = this->block->random_field(5e-3, 1), direction = this->block->random_field(1., 50);
  this->assemble(this->block->parts->owned(*this->system, increment));
  const TpetraVector product = this->times(this->block->parts->owned(*this->system, direction));

  const test::Block<dim> serial(test::soil_material<MohrCoulomb>(), MPI_COMM_SELF);
  const auto deformation = copy_to_host(
      interpolate_increments<dim>(serial.particles.arrays(), serial.parts->stencils, serial.parts->nodal(increment))
          .deformation_gradient);
  const auto strain = copy_to_host(
      interpolate_increments<dim>(serial.particles.arrays(), serial.parts->stencils, serial.parts->nodal(direction))
          .deformation_gradient);
  const ParticleArrays& arrays = serial.particles.arrays();
  const auto b = copy_to_host(arrays.elastic_left_cauchy_green);
  const auto volume = copy_to_host(arrays.initial_volume), young = copy_to_host(arrays.young);
  std::vector<double> expected(dim * serial.mesh.leaves().node_ids.size(), 0.);
  for (std::size_t p = 0; p < arrays.n; ++p)
  {
    Eigen::Matrix3d dF, change;
    SymmetricTensor left;
    for (int i = 0; i < 9; ++i)
    {
      dF(i / 3, i % 3) = deformation(p, i);
      change(i / 3, i % 3) = strain(p, i) - (i % 4 == 0 ? 1. : 0.);
    }
    for (int i = 0; i < 6; ++i)
      left[i] = b(p, i);
    SpatialTangent tangent;
    update_stress(dF, left, {young(p), test::Block<dim>::cell, nullptr}, copy_to_host(serial.materials)(0), nullptr,
                  tangent);
    const Eigen::Matrix3d spatial = change * dF.inverse();
    Eigen::Matrix3d stress = Eigen::Matrix3d::Zero();
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k)
          for (int l = 0; l < 3; ++l)
            stress(i, j) += volume(p) * tangent(i, j, k, l) * spatial(k, l);
    const Eigen::Matrix3d flux = stress * dF.inverse().transpose();
    for (const NodeShare<dim>& share : test::average_over_box<dim>(
             serial.mesh.leaves(), serial.particles.positions()[p], serial.particles.half_widths()[p]))
      for (unsigned int i = 0; i < dim; ++i)
        for (unsigned int j = 0; j < dim; ++j)
          expected[dim * share.node + i] += flux(i, j) * share.gradient[j];
  }

  const auto found = product.getLocalViewHost(Tpetra::Access::ReadOnly);
  double largest = 0.;
  for (unsigned int v = 0; v < this->block->parts->nodes.n_owned; ++v)
  {
    const auto& x = this->block->parts->position[v];
    const auto& all = serial.mesh.leaves().node_position;
    const std::size_t w = std::find_if(all.begin(), all.end(),
                                       [&](const auto& y)
                                       {
                                         double distance = 0.;
                                         for (unsigned int d = 0; d < dim; ++d)
                                           distance += std::abs(x[d] - y[d]);
                                         return distance < 1e-9;
                                       }) -
                          all.begin();
    for (unsigned int d = 0; d < dim; ++d)
      largest = std::max(largest, std::abs(found(dim * v + d, 0) - expected.at(dim * w + d)));
  }
  EXPECT_LT(max_over_ranks(largest, MPI_COMM_WORLD), 1e-10 * product.normInf());
}

TYPED_TEST(TangentMatrix, HasScaledIdentitiesForConstrainedDofs)
{
  constexpr int dim = TypeParam::value;
  this->use(test::soil_material<MohrCoulomb>());
  // rollers at the lower end of the first axis
  const auto held = [](const std::array<double, dim>& x, const unsigned int d) { return d == 0 && x[0] < 1e-9; };
  std::vector<unsigned char> constrained;
  for (const auto& x : this->block->parts->position)
    for (unsigned int d = 0; d < dim; ++d)
      constrained.push_back(held(x, d));
  const auto random = this->block->random_field(1., 7);
  const TpetraVector increment(this->system->graph().row_map);
  this->assemble(increment);
  const TpetraVector free_part = this->block->parts->owned(*this->system, [&](const auto& x, const unsigned int d)
                                                           { return held(x, d) ? 0. : random(x, d); });
  const TpetraVector all = this->block->parts->owned(*this->system, random);
  const TpetraVector unconstrained = this->times(free_part);

  this->system = this->block->parts->make_system(constrained);
  this->assemble(increment);
  const TpetraVector product = this->times(all);
  const auto y = product.getLocalViewHost(Tpetra::Access::ReadOnly);
  const auto x = all.getLocalViewHost(Tpetra::Access::ReadOnly);
  const auto before = unconstrained.getLocalViewHost(Tpetra::Access::ReadOnly);
  double lowest = INFINITY, highest = -INFINITY, largest = 0.;
  for (std::size_t dof = 0; dof < y.extent(0); ++dof)
    if (constrained[dof])
    {
      lowest = std::min(lowest, y(dof, 0) / x(dof, 0));
      highest = std::max(highest, y(dof, 0) / x(dof, 0));
    }
    else
      largest = std::max(largest, std::abs(y(dof, 0) - before(dof, 0)));
  lowest = min_over_ranks(lowest, MPI_COMM_WORLD);
  highest = max_over_ranks(highest, MPI_COMM_WORLD);
  EXPECT_GT(lowest, 0.);
  EXPECT_NEAR(lowest, highest, 1e-12 * highest);
  EXPECT_LT(max_over_ranks(largest, MPI_COMM_WORLD), 1e-12 * unconstrained.normInf());
}

TYPED_TEST(TangentMatrix, ZeroesConstrainedEntriesOfVectors)
{
  constexpr int dim = TypeParam::value;
  this->use(test::soil_material<Elastic>());
  std::vector<unsigned char> constrained(dim * this->block->parts->nodes.n_local(), 0);
  constrained[1] = 1;
  this->system = this->block->parts->make_system(constrained);
  TpetraVector vector(this->system->graph().row_map);
  vector.putScalar(1.);
  this->system->zero_constrained(vector);
  const auto view = vector.getLocalViewHost(Tpetra::Access::ReadOnly);
  for (std::size_t dof = 0; dof < view.extent(0); ++dof)
    ASSERT_EQ(view(dof, 0), dof == 1 ? 0. : 1.);
}

TYPED_TEST(TangentMatrix, SpringsAtPointsActThroughTheirWeights)
{
  // one spring at a place inside the first particle's pattern: force = -k (weighted displacement)
  constexpr int dim = TypeParam::value;
  this->use(test::soil_material<Elastic>());
  const auto nodes = copy_to_host(this->block->parts->stencils.pattern_nodes);
  const std::vector<unsigned int> node = {nodes(0), nodes(1), nodes(2)};
  const std::vector<double> weight = {0.5, 0.3, 0.2};
  std::vector<double> point_tangent(9, 0.), point_force(3, 0.);
  for (unsigned int i = 0; i < dim; ++i)
    for (unsigned int j = 0; j < dim; ++j)
      point_tangent[3 * i + j] = -1. - i - 2. * j;
  const auto make_points = [&]
  {
    const auto list = [](const std::vector<unsigned int>& values) { return upload(values, "list"); };
    return PointForces{list({0, 3}),
                       list(node),
                       upload(weight, "weights"),
                       upload(point_force, "force"),
                       upload(point_tangent, "tangent"),
                       list({0}),
                       1};
  };
  this->system->clear_matrix();
  add_point_tangents(make_points(), -1., this->system->graph(), this->system->values());
  this->system->finish_matrix();

  const auto field = this->block->random_field(1., 3);
  const NodalVector local = this->system->spread(this->block->parts->owned(*this->system, field));
  const auto d = copy_to_host(local);
  for (unsigned int i = 0; i < dim; ++i)
    for (unsigned int j = 0; j < dim; ++j)
      for (unsigned int v = 0; v < 3; ++v)
        point_force[i] += point_tangent[3 * i + j] * weight[v] * d(dim * node[v] + j);
  const NodalVector force = this->system->make_nodal_vector();
  add_point_forces(dim, make_points(), -1., force);
  TpetraVector expected(this->system->graph().row_map);
  this->system->collect(force, expected);
  expected.update(-1., this->times(this->block->parts->owned(*this->system, field)), 1.);
  EXPECT_LT(expected.normInf(), 1e-13);
  double sum = 0.;
  for (std::size_t v = 0; v < copy_to_host(force).extent(0) / dim; ++v)
    sum += copy_to_host(force)(dim * v);
  EXPECT_NEAR(sum, -point_force[0], 1e-13);
}
