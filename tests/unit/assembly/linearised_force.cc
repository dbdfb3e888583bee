#include "block.h"
#include <gtest/gtest.h>
#include <kedge/assembly/linearised_force.h>
#include <kedge/assembly/nodal_operator.h>

using namespace kedge;

namespace
{
/// The soil of the tangent's tests, its tangent as a matrix, as an operator and as that of elements.
template <typename Dimension> class LinearisedForceOf : public testing::Test
{
public:
  static constexpr int dim = Dimension::value;

  void use(const MaterialParameters& material, const double strain, const bool f_bar, const bool stressed = true)
  {
    block = std::make_unique<test::Block<dim>>(material, MPI_COMM_WORLD, stressed);
    system = block->parts->make_system(f_bar);
    cells = f_bar ? block->parts->cells : CellGroups{};
    const TpetraVector increment = block->parts->owned(*system, block->random_field(strain, 1));
    test::internal_force(*block, *system, increment, cells); // the shared pressure comes from these stresses
    local_increment = system->spread(increment);
    system->clear_matrix();
    add_tangent<dim>(block->particles.arrays(), block->parts->stencils, block->materials, system->graph(),
                     system->values(), cells);
    system->finish_matrix();
    derivative = linearise_force<dim>(block->particles.arrays(), block->parts->stencils, block->materials, cells, 0.);
    product = std::make_unique<NodalOperator>(
        *system, [this](const NodalVector& direction, const NodalVector& result)
        { add_linearised_force<dim>(block->parts->stencils, cells, derivative, direction, result); });
  }

  void assemble_elements()
  {
    const Elements elements = block->parts->make_elements(block->mesh, block->particles, cells);
    element_system = std::make_unique<System>(dim, block->parts->numbering(),
                                              std::vector<NodeLists>{{elements.node_begin, elements.nodes}},
                                              std::vector<unsigned char>(dim * block->parts->nodes.n_local(), 0));
    element_system->clear_matrix();
    add_element_stiffness<dim>(elements, cells, derivative, element_system->graph(), element_system->values());
    element_system->finish_matrix();
  }

  static TpetraVector times(const TpetraOperator& matrix, const TpetraVector& x)
  {
    TpetraVector y(x.getMap());
    matrix.apply(x, y, Teuchos::NO_TRANS, 1., 0.);
    return y;
  }

  static double energy(const TpetraOperator& matrix, const TpetraVector& x) { return x.dot(times(matrix, x)); }

  double error_of_product()
  {
    const TpetraVector direction = block->parts->owned(*system, block->random_field(1., 50));
    const TpetraVector expected = times(*system->matrix(), direction);
    TpetraVector difference = times(*product, direction);
    difference.update(-1., expected, 1.);
    return difference.normInf() / expected.normInf();
  }

  std::unique_ptr<test::Block<dim>> block;
  std::unique_ptr<System> system, element_system;
  CellGroups cells;
  NodalVector local_increment;
  LinearisedForce derivative;
  std::unique_ptr<NodalOperator> product;
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(LinearisedForceOf, Dimensions, test::DimensionName);

/// Of the matrix in double precision, which differences of the force confirm (tangent.cc).
constexpr double single_precision = 1e-6;
} // namespace

TYPED_TEST(LinearisedForceOf, YieldingSoilIsTheTangent)
{
  this->use(test::soil_material<MohrCoulomb>(), 5e-3, false);
  EXPECT_LT(this->error_of_product(), single_precision);
}

TYPED_TEST(LinearisedForceOf, YieldingSoilWithFBarIsTheTangent)
{
  this->use(test::soil_material<MohrCoulomb>(), 5e-3, true);
  EXPECT_LT(this->error_of_product(), single_precision);
}

TYPED_TEST(LinearisedForceOf, ElasticSoilAtLargeStrainWithFBarIsTheTangent)
{
  this->use(test::soil_material<Elastic>(), 0.1, true);
  EXPECT_LT(this->error_of_product(), single_precision);
}

TYPED_TEST(LinearisedForceOf, ConstrainedDofsIsTheIdentity)
{
  this->use(test::soil_material<Elastic>(), 0., false);
  constexpr int dim = TypeParam::value;
  std::vector<unsigned char> constrained(dim * this->block->parts->nodes.n_local(), 0);
  for (unsigned int v = 0; v < this->block->parts->nodes.n_local(); ++v)
    constrained[dim * v] = this->block->parts->position[v][0] == 0.;
  const auto held = this->block->parts->make_system(constrained);
  const NodalOperator operator_(
      *held, [this](const NodalVector& direction, const NodalVector& result)
      { add_linearised_force<dim>(this->block->parts->stencils, {}, this->derivative, direction, result); });
  TpetraVector only_held(held->graph().row_map);
  const auto on_held = [](const std::array<double, dim>& x, const unsigned int d)
  { return d == 0 && x[0] == 0. ? 3. : 0.; };
  const TpetraVector direction = this->block->parts->owned(*held, on_held);
  TpetraVector difference = this->times(operator_, direction);
  difference.update(-1., direction, 1.);
  EXPECT_EQ(difference.normInf(), 0.);
}

TYPED_TEST(LinearisedForceOf, ElementsHasTheEnergyOfLinearFields)
{
  constexpr int dim = TypeParam::value;
  for (const bool f_bar : {false, true})
  {
    this->use(test::soil_material<Elastic>(), 1e-3, f_bar);
    this->assemble_elements();
    const auto linear = [](const std::array<double, dim>& x, const unsigned int d)
    { return d == 0 ? 0.3 * x[0] - 0.2 * x[1] : 0.1 * x[0] + 0.5 * x[d]; };
    const TpetraVector u = this->block->parts->owned(*this->system, linear);
    const double expected = this->energy(*this->system->matrix(), u);
    EXPECT_NEAR(this->energy(*this->element_system->matrix(), u), expected, 1e-6 * expected) << f_bar;
  }
}

TYPED_TEST(LinearisedForceOf, ElementsIsStifferForOtherFields)
{
  this->use(test::soil_material<Elastic>(), 0., false, false);
  this->assemble_elements();
  for (unsigned int salt = 1; salt < 5; ++salt)
  {
    const TpetraVector u = this->block->parts->owned(*this->system, this->block->random_field(1., 100 * salt));
    EXPECT_GT(this->energy(*this->element_system->matrix(), u), this->energy(*this->system->matrix(), u));
  }
}
