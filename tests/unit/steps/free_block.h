// An elastic block that nothing holds, for tests of dynamics.
#pragma once

#include "step_fixture.h"
#include <Eigen/Geometry>
#include <cmath>
#include <gtest/gtest.h>
#include <kedge/base/communication.h>

namespace kedge::test
{
/// An elastic block of 4 x 4 x 2 cells with nothing that holds it and no face of the grid near.
struct FreeBlock : StepFixture<3>
{
  FreeBlock(const double young, const double vertical_gravity, const Newmark& newmark, const bool lumped = false)
      : StepFixture<3>(layout(), layers_of({elastic_layer(1., 2000., young, 0.3)}), std::abs(vertical_gravity))
  {
    gravity = {{0., 0., vertical_gravity}};
    solver.tolerance = 1e-11;
    solver.ghost_factor = 0.1;
    solver.ghost_factor_mass = 0.25;
    solver.linear_solver = LinearSolverChoice::direct;
    stage.stepping.type = StageType::dynamic;
    stage.stepping.lumped_mass = lumped;
    const FaceCondition free = FaceCondition::free;
    stage.boundary_conditions.min = stage.boundary_conditions.max = {{free, free, free}};
    load.newmark = newmark;

    particles.remove_if(
        [](const auto& particle)
        {
          const auto& x = particle.get_location();
          return std::max(std::abs(x[0] - 1.), std::abs(x[1] - 1.)) > 0.5 || x[2] < 0.5;
        });
  }

  static GridLayout<3> layout()
  {
    GridLayout<3> grid;
    grid.base_size = grid.finest_size = 0.25;
    grid.base_cells = {{8, 8, 8}};
    grid.soil_extent = {{2., 2., 1.}};
    return grid;
  }

  /// Velocity (m/s) of every particle from its position (m).
  template <typename Field> void set_velocities(const Field& field)
  {
    for (auto& particle : particles.edit())
    {
      const auto x = particle.get_location();
      const Eigen::Vector3d v = field(Eigen::Vector3d(x[0], x[1], x[2]));
      for (unsigned int d = 0; d < 3; ++d)
        particle.get_properties()[field::velocity + d] = v[d];
    }
  }

  void step()
  {
    ImplicitStep<3> step(context());
    const NewtonReport newton = step.solve(load);
    ASSERT_TRUE(newton.converged) << newton.failure;
    loads = step.body_loads();
    commit(step);
  }

  void commit(const TrialStep<3>& step)
  {
    StepFixture<3>::commit(step);
    load.begins_stage = false;
  }

  /// Sum over the particles of all ranks of a vector that a function makes of mass, position and motion.
  template <typename Quantity> Eigen::Vector3d sum(const Quantity& quantity) const
  {
    Eigen::Vector3d total = Eigen::Vector3d::Zero();
    for (const auto& particle : particles.handler())
    {
      const double* data = particle.get_properties().data();
      const auto x = particle.get_location();
      total += quantity(data[field::mass], Eigen::Vector3d(x[0], x[1], x[2]),
                        Eigen::Map<const Eigen::Vector3d>(data + field::velocity),
                        Eigen::Map<const Eigen::Vector3d>(data + field::acceleration));
    }
    for (unsigned int d = 0; d < 3; ++d)
      total[d] = sum_over_ranks(total[d], MPI_COMM_WORLD);
    return total;
  }
  double mass() const
  {
    return sum([](double m, const auto&, const auto&, const auto&) { return Eigen::Vector3d(m, 0., 0.); })[0];
  }
  Eigen::Vector3d centre() const
  {
    return sum([](double m, const auto& x, const auto&, const auto&) { return Eigen::Vector3d(m * x); }) / mass();
  }
  Eigen::Vector3d momentum() const
  {
    return sum([](double m, const auto&, const auto& v, const auto&) { return Eigen::Vector3d(m * v); });
  }
  /// About the origin.
  Eigen::Vector3d angular_momentum() const
  {
    return sum([](double m, const auto& x, const auto& v, const auto&) { return Eigen::Vector3d(m * x.cross(v)); });
  }

  StepLoad load;
  BodyLoads loads;
};
} // namespace kedge::test
