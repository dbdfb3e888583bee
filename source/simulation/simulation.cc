#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <kedge/base/communication.h>
#include <kedge/base/exceptions.h>
#include <kedge/particles/generation.h>
#include <kedge/simulation/simulation.h>
#include <kedge/simulation/step_problem.h>
#include <kedge/time/clock.h>
#include <numeric>

namespace kedge
{
namespace
{
/// A particle's work in a step relative to that of an empty cell, for the partition.
constexpr double particle_cost = 20.;

template <int dim>
GridLayout<dim> make_layout(const Input& input)
{
  std::vector<double> sizes;
  for (const Stage& stage : input.stages)
    if (stage.adaptivity.type == AdaptivityType::rigid_body_surface)
      {
        sizes.push_back(stage.adaptivity.element_size);
        if (stage.adaptivity.region > 0.)
          sizes.push_back(stage.adaptivity.element_size_in_region);
      }
  const MaterialPointParameters& soil = input.material_points;
  std::array<double, dim - 1> footprint;
  std::copy_n(soil.plan_extent.begin(), dim - 1, footprint.begin());
  double thickness = 0.;
  for (const Layer& layer : soil.layers)
    thickness += layer.thickness;
  return make_grid_layout<dim>(soil.element_size, sizes, footprint, thickness, soil.points_per_axis);
}

Materials upload_materials(const std::vector<Layer>& layers)
{
  const Materials materials("materials", layers.size());
  const auto host = Kokkos::create_mirror_view(materials);
  for (std::size_t i = 0; i < layers.size(); ++i)
    host(i) = make_material(layers[i].material);
  Kokkos::deep_copy(materials, host);
  return materials;
}

double magnitude(const std::array<double, 3>& x)
{
  return std::sqrt(std::inner_product(x.begin(), x.end(), x.begin(), 0.));
}

template <int dim>
class Simulation
{
public:
  Simulation(const Input& input, const RunOptions& options);
  void run();

private:
  void begin_stage(unsigned int number);
  void run_stage(unsigned int number);
  NewtonReport find_equilibrium(const Clock& clock);
  void commit_trial();
  void report_progress(unsigned int number, const Clock& clock, const NewtonReport& newton);
  [[noreturn]] void give_up(unsigned int number, const Clock& clock, const NewtonReport& newton);
  void remove_buried_particles();

  const Input& input;
  const RunOptions& options;
  const Stage* stage = nullptr;
  Report report;
  Timings timings;

  BackgroundMesh<dim> mesh;
  ParticleSet<dim> particles;
  Materials materials;
  RigidSystems bodies;
  Contact<dim> contact;

  std::unique_ptr<StepProblem<dim>> problem; ///< of the current step; survives a cut
  typename StepProblem<dim>::Load load;
  std::vector<Vector6> reactions;
  bool take_reference_gaps = false; ///< at the first step of a stage whose bodies are wished in place
  long long deleted = 0;
  unsigned int step = 1; ///< global counter; the first converged step is number 2, as the file names have it
};

template <int dim>
Simulation<dim>::Simulation(const Input& input_, const RunOptions& options_)
  : input(input_),
    options(options_),
    report(rank_of(MPI_COMM_WORLD) == 0, options_.quiet),
    mesh(MPI_COMM_WORLD, make_layout<dim>(input_)),
    particles(mesh),
    materials(upload_materials(input_.material_points.layers)),
    bodies(make_rigid_systems(input_.systems, dim)),
    contact(input_.contact, MPI_COMM_WORLD)
{
  const auto scope = timings.measure("generation");
  generate_particles(particles, mesh, input.material_points, magnitude(input.gravity));
  particles.balance_load(mesh, particle_cost);
  particles.load();
}

template <int dim>
void Simulation<dim>::run()
{
  for (unsigned int number = 0; number < input.stages.size(); ++number)
    {
      begin_stage(number);
      run_stage(number);
    }
}

template <int dim>
void Simulation<dim>::begin_stage(const unsigned int number)
{
  stage = &input.stages[number];
  apply_conditions(bodies, input.systems, stage->point_conditions, dim);
  if (!stage->rigid_bodies)
    return;
  if (stage->surface_placement)
    place_on_surface(bodies, 2, mesh.layout().soil_extent[dim - 1]);
  if (stage->wished_in_place)
    remove_buried_particles();
  take_reference_gaps = stage->wished_in_place;
}

template <int dim>
void Simulation<dim>::remove_buried_particles()
{
  const long long removed = particles.remove_if([this](const dealii::Point<dim>& x) {
    return is_inside(bodies, dim == 3 ? Eigen::Vector3d(x[0], x[1], x[dim - 1]) : Eigen::Vector3d(x[0], 0., x[1]));
  });
  deleted += removed;
  particles.load();
  report.line(fmt::format("{} material points inside buried bodies removed", removed));
}

template <int dim>
void Simulation<dim>::run_stage(const unsigned int number)
{
  Clock clock(stage->stepping.load_steps, input.solver.minimum_step_fraction);
  while (!clock.at_end())
    {
      const NewtonReport newton = find_equilibrium(clock);
      if (newton.converged)
        {
          commit_trial();
          clock.advance();
          ++step;
          report_progress(number, clock, newton);
        }
      else if (!clock.cut())
        give_up(number, clock, newton);
    }
  report.end_progress();
}

template <int dim>
NewtonReport Simulation<dim>::find_equilibrium(const Clock& clock)
{
  if (!problem)
    problem = std::make_unique<StepProblem<dim>>(input, *stage, mesh, particles, materials, bodies, contact, timings);
  if (take_reference_gaps)
    contact.take_reference_gaps(bodies);
  take_reference_gaps = false;

  load.gravity_factor =
    stage->stepping.load == GravityLoad::ramp ? clock.steps_after() / clock.requested_steps() : 1.;
  load.body_increments.clear();
  for (const RigidPoint& point : bodies.points)
    load.body_increments.push_back(point.prescribed_increment(clock.step_fraction()));
  return problem->solve(load);
}

template <int dim>
void Simulation<dim>::commit_trial()
{
  const ParticleIncrements increments = problem->particle_increments();
  const BodyLoads loads = problem->body_loads();
  reactions.clear();
  for (std::size_t i = 0; i < bodies.points.size(); ++i)
    {
      RigidPoint& point = bodies.points[i];
      point.pose = point.pose.moved(load.body_increments[i]);
      Vector6 reaction = stage->rigid_bodies ? Vector6(-loads[i]) : Vector6(Vector6::Zero());
      for (unsigned int d = 0; d < 3; ++d)
        reaction[d] -= load.gravity_factor * point.mass * input.gravity[d];
      reactions.push_back(reaction);
    }

  const auto scope = timings.measure("commit");
  if (stage->rigid_bodies)
    {
      particles.set_contact_gaps(contact.smallest_gaps());
      contact.commit();
    }
  problem.reset();
  particles.commit(increments, input.material_points.domain_update);
  particles.load();
  contact.follow_particles(particles.ids());
}

template <int dim>
void Simulation<dim>::report_progress(const unsigned int number, const Clock& clock, const NewtonReport& newton)
{
  Progress state;
  state.stage = number + 1;
  state.n_stages = input.stages.size();
  state.time = clock.steps_done() / clock.requested_steps();
  state.step = step;
  state.increment = clock.step_fraction() / clock.requested_steps();
  state.newton_iterations = newton.iterations;
  state.krylov_iterations = newton.krylov_iterations;
  state.cuts = clock.cuts();
  state.deleted = deleted + particles.n_lost();
  state.particles = particles.n_global();
  report.progress(state);
}

template <int dim>
void Simulation<dim>::give_up(const unsigned int number, const Clock& clock, const NewtonReport& newton)
{
  report.end_progress();
  std::string history;
  for (const double residual : newton.residuals)
    history += fmt::format(" {:.2e}", residual);
  throw SolverError(
    fmt::format("stage {}, step {} of {}: {} even with a step cut to {:.3g} of the requested one.\n"
                "Residual over the soil's weight:{}\n"
                "Smaller load steps, a finer mesh at the body, a little cohesion or a larger \"ghost factor\" may help.",
                number + 1,
                clock.steps_done() + 1.,
                clock.requested_steps(),
                newton.failure,
                clock.step_fraction(),
                history),
    newton.residuals);
}
} // namespace

void run_simulation(const Input& input, const RunOptions& options)
{
  if (input.dimension == 2)
    Simulation<2>(input, options).run();
  else
    Simulation<3>(input, options).run();
}
} // namespace kedge
