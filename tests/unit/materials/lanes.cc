// Several points at once get what each gets by itself.
#include <gtest/gtest.h>
#include <kedge/materials/stress_lanes.h>

#include "cases.h"

using namespace kedge;

namespace
{
constexpr int width = 8;

/// Points with their increments, asked in lanes and each by itself.
struct Batch
{
  Material material[width];
  SymmetricTensor strain[width];
  Eigen::Matrix3d increment[width];
  State state[width];

  void compare(const bool in_place) const
  {
    StressLanes<width> lanes;
    DeformationLanes<width> deformation;
    State given[width], received[width];
    double b[6][width];
    for (int l = 0; l < width; ++l)
    {
      given[l] = state[l];
      lanes.point[l] = {young, cell_size, given[l].value};
      lanes.material[l] = &material[l];
      lanes.next_state[l] = in_place ? given[l].value : received[l].value;
      lanes.admissible[l] = true;
      for (int i = 0; i < 9; ++i)
        deformation.f[i][l] = increment[l](i % 3, i / 3);
      const SymmetricTensor own = left_cauchy_green(strain[l]);
      for (int i = 0; i < 6; ++i)
        b[i][l] = own[i];
    }
    deformation.push_forward(b, lanes.trial.tensor);
    lanes.trial.find();
    lanes.trial.find_strains();
    lanes.respond();
    double stress[6][width], elastic_strain[6][width];
    lanes.trial.turn(lanes.stress, stress);
    lanes.trial.turn(lanes.elastic_strain, elastic_strain);
    lanes.find_left_cauchy_green(b);
    for (int l = 0; l < width; ++l)
    {
      State next = state[l];
      const StressUpdate own = update_stress(increment[l], left_cauchy_green(strain[l]),
                                             {young, cell_size, state[l].value}, material[l], next.value);
      ASSERT_TRUE(lanes.admissible[l]);
      ASSERT_EQ(lanes.status[l], own.status);
      ASSERT_NEAR(lanes.plastic_increment[l], own.plastic_increment, 2e-15);
      const SymmetricTensor own_b = left_cauchy_green(own.elastic_strain);
      for (int i = 0; i < 6; ++i)
      {
        // round-off of the strain, times the largest modulus: E / (1 - 2 nu)
        ASSERT_NEAR(stress[i][l], own.stress[i], 5e-15 * young);
        ASSERT_NEAR(elastic_strain[i][l], own.elastic_strain[i], 2e-15);
        ASSERT_NEAR(b[i][l], own_b[i], 1e-14);
      }
      for (unsigned int i = 0; i < material[l].n_state; ++i)
        ASSERT_NEAR(lanes.next_state[l][i], next.value[i], 2e-15 * std::max(1., next.value[i]));
    }
  }
};

/// One point of each law after the other, from `first` on.
Batch random_batch(const std::vector<Case>& cases, const int first, const int stride, RandomStrain& random)
{
  Batch batch;
  for (int l = 0; l < width; ++l)
  {
    const Case& c = cases[(first + stride * l) % cases.size()];
    batch.material[l] = make_material(c.parameters);
    batch.strain[l] = random.symmetric(1e-2);
    batch.increment[l] = Eigen::Matrix3d::Identity() + random.matrix(1e-2);
    batch.state[l] = random_state(c, random);
  }
  return batch;
}
} // namespace

TEST(StressLanes, OneLawAnswersAsToEachPoint)
{
  RandomStrain random(1);
  const std::vector<Case> cases = all_cases();
  for (int n = 0; n < 300; ++n)
    for (std::size_t c = 0; c < cases.size(); ++c)
      random_batch(cases, c, 0, random).compare(n % 2 == 0);
}

TEST(StressLanes, LawsMayDiffer)
{
  RandomStrain random(2);
  const std::vector<Case> cases = all_cases();
  for (int n = 0; n < 1000; ++n)
    random_batch(cases, n, 1, random).compare(n % 2 == 0);
}

TEST(StressLanes, AnInvertedPointHasNoAnswerAndKeepsItsState)
{
  for (const Case& c : all_cases())
  {
    const Material material = make_material(c.parameters);
    StressLanes<width> lanes;
    State state[width], untouched;
    std::fill(std::begin(untouched.value), std::end(untouched.value), 0.25);
    RandomStrain random(3);
    for (int l = 0; l < width; ++l)
    {
      state[l] = untouched;
      lanes.point[l] = {young, cell_size, state[l].value};
      lanes.material[l] = &material;
      lanes.next_state[l] = state[l].value;
      lanes.admissible[l] = l != 1;
      PrincipalFrame frame = principal_frame(left_cauchy_green(random.symmetric(1e-3)));
      if (l == 2)
        frame.values.setZero();
      if (l == 3)
        frame.values[1] = std::nan("");
      lanes.trial.set(l, frame);
    }
    lanes.trial.find_strains();
    lanes.respond();
    for (int l = 0; l < width; ++l)
    {
      EXPECT_EQ(lanes.admissible[l], l < 1 || l > 3);
      for (int i = 0; i < 3 && lanes.admissible[l]; ++i)
        EXPECT_TRUE(std::isfinite(lanes.stress[i][l]));
      for (std::size_t i = 0; i < Laws::max_state && !lanes.admissible[l]; ++i)
        EXPECT_EQ(state[l].value[i], untouched.value[i]);
    }
  }
}

TEST(DeformationLanes, PushForwardAndInverse)
{
  RandomStrain random(4);
  DeformationLanes<width> lanes;
  Eigen::Matrix3d f[width];
  SymmetricTensor b[width];
  double start[6][width], pushed[6][width];
  for (int l = 0; l < width; ++l)
  {
    f[l] = Eigen::Matrix3d::Identity() + random.matrix(0.3);
    b[l] = left_cauchy_green(random.symmetric(0.1));
    for (int i = 0; i < 9; ++i)
      lanes.f[i][l] = f[l](i % 3, i / 3);
    for (int i = 0; i < 6; ++i)
      start[i][l] = b[l][i];
  }
  lanes.push_forward(start, pushed);
  lanes.invert();
  for (int l = 0; l < width; ++l)
  {
    SymmetricTensor found;
    for (int i = 0; i < 6; ++i)
      found[i] = pushed[i][l];
    EXPECT_LT((full_matrix(found) - f[l] * full_matrix(b[l]) * f[l].transpose()).norm(), 1e-14);
    EXPECT_LT((lanes.matrix_of(l) - f[l].inverse()).norm(), 1e-13);
  }
}
