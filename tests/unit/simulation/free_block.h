// An elastic block that nothing holds, for tests of dynamics.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <gtest/gtest.h>
#include <kedge/base/communication.h>
#include <kedge/particles/generation.h>
#include <kedge/simulation/step_problem.h>

namespace kedge::test
{
/// An elastic block of 4 x 4 x 2 cells with nothing that holds it and no face of the grid near.
struct FreeBlock
{
  FreeBlock(const double young, const double gravity, const Newmark& newmark, const bool lumped = false)
      : mesh(MPI_COMM_WORLD, layout()), particles(mesh), contact({}, MPI_COMM_WORLD)
  {
    input.gravity = {{0., 0., gravity}};
    input.solver.tolerance = 1e-11;
    input.solver.ghost_factor = 0.1;
    input.solver.ghost_factor_mass = 0.25;
    input.solver.linear_solver = LinearSolverChoice::direct;
    MaterialPointParameters& soil = input.material_points;
    Layer layer;
    layer.thickness = 1.;
    layer.material.young = young;
    layer.material.poisson = 0.3;
    layer.material.density = 2000.;
    soil.layers = {layer};
    stage.stepping.type = StageType::dynamic;
    stage.stepping.lumped_mass = lumped;
    const FaceCondition free = FaceCondition::free;
    stage.boundary_conditions.min = stage.boundary_conditions.max = {{free, free, free}};
    load.newmark = newmark;

    generate_particles(particles, mesh, soil, std::abs(gravity));
    particles.remove_if(
        [](const auto& particle)
        {
          const auto& x = particle.get_location();
          return std::max(std::abs(x[0] - 1.), std::abs(x[1] - 1.)) > 0.5 || x[2] < 0.5;
        });
    particles.load();
    materials = upload_materials({layer.material});
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
    for (auto& particle : particles.handler())
    {
      const auto x = particle.get_location();
      const Eigen::Vector3d v = field(Eigen::Vector3d(x[0], x[1], x[2]));
      for (unsigned int d = 0; d < 3; ++d)
        particle.get_properties()[field::velocity + d] = v[d];
    }
    particles.load();
  }

  StepScene<3> scene() { return {input, stage, mesh, particles, materials, bodies, contact, timings}; }

  void step()
  {
    StepProblem<3> problem(scene());
    const NewtonReport newton = problem.solve(load, {});
    ASSERT_TRUE(newton.converged) << newton.failure;
    loads = problem.body_loads();
    commit(problem);
  }

  /// Makes the solution of a step the state from which the next one starts.
  void commit(const TrialStep<3>& problem)
  {
    particles.commit(problem.particle_increments(), DomainUpdate::none);
    particles.load();
    problem.move_bodies(bodies);
    contact.commit();
    load.starts_at_rest = load.begins_stage = false;
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

  Input input;
  Stage stage;
  BackgroundMesh<3> mesh;
  ParticleSet<3> particles;
  Contact<3> contact;
  Materials materials;
  RigidSystems bodies;
  Timings timings;
  StepLoad load;
  BodyLoads loads;
};
} // namespace kedge::test
