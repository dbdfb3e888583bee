#include <algorithm>
#include <cmath>
#include <kedge/assembly/highest_frequency.h>
#include <kedge/base/communication.h>
#include <kedge/steps/stable_step.h>

namespace kedge
{
namespace
{
using Policy = Kokkos::RangePolicy<ExecutionSpace>;

/// Time steps from which on it pays to find the stable one: it costs as much as a few of them.
constexpr double many_time_steps = 24.;

/// Adds the springs' stiffness to `rate` of their nodes, by weight.
void add_stiffness(const PointForces& points, const View<double*>& stiffness, const View<double*>& rate)
{
  Kokkos::parallel_for(
      "contact stiffness", Policy(0, points.n()), KOKKOS_LAMBDA(const std::size_t i) {
        for (unsigned int v = points.begin(i); v < points.begin(i + 1); ++v)
          add_to(rate(points.nodes(v)), stiffness(i) * points.weights(v));
      });
}

/// Of a point: the sum over its nodes of weight times rate over mass.
double largest_squared_frequency(const PointForces& points, const View<double*>& rate, const View<double*>& mass)
{
  double largest = 0.;
  Kokkos::parallel_reduce(
      "contact frequency", Policy(0, points.n()),
      KOKKOS_LAMBDA(const std::size_t i, double& most) {
        double sum = 0.;
        for (unsigned int v = points.begin(i); v < points.begin(i + 1); ++v)
          if (const unsigned int node = points.nodes(v); mass(node) > 0.)
            sum += points.weights(v) * rate(node) / mass(node);
        most = sum > most ? sum : most;
      },
      Kokkos::Max<double>(largest));
  return std::fmax(0., largest); // without points the reduction leaves the least number
}

/// The contact springs at a node share its mass in proportion to their stiffness there: the squared frequency of a
/// spring of stiffness k and weights w_v alone is then the sum over its nodes of w_v R_v, R_v being the sum over all
/// springs of k w_v / m_v. A bound of all of them. Collective.
double bound_of_springs(const PointForces& points, const View<double*>& stiffness, const LumpedMass& lumped,
                        const MPI_Comm communicator)
{
  const View<double*> rate("contact stiffness", lumped.mass.extent(0));
  add_stiffness(points, stiffness, rate);
  lumped.of_nodes.sum_over_ranks(rate);
  return max_over_ranks(largest_squared_frequency(points, rate, lumped.mass), communicator);
}

/// Numbers between -1/2 and 1/2 that follow from the places of the nodes, per local dof.
template <int dim> std::vector<double> scattered_numbers(const StepContext<dim>& context, const ActiveNodes& nodes)
{
  std::vector<double> numbers;
  for (const unsigned int node : nodes.mesh_node)
    for (int i = 0; i < dim; ++i)
    {
      double phase = i;
      for (int d = 0; d < dim; ++d)
        phase += (d + 1.7) * 12.9898 * context.soil.mesh().leaves().node_position[node][d];
      const double large = 43758.5453 * std::sin(phase);
      numbers.push_back(large - std::floor(large) - 0.5);
    }
  return numbers;
}

/// Whether time steps by a bound of the squared frequency are too many, or too short for a given one.
bool pays(const SteppingParameters& stepping, const double squared_frequency)
{
  const double dt = 2. / std::sqrt(squared_frequency);
  return stepping.dt > 0. ? stepping.dt > dt : step_length(stepping) > many_time_steps * stepping.cfl * dt;
}
} // namespace

// Of the linear basis: without it the stable step vanishes as the point enters a cell. Boxes need none, there values
// and gradients fade away together.
double least_share(const Basis basis) { return basis == Basis::mpm ? 0.02 : 0.; }

template <int dim>
StableStep find_stable_step(const StepContext<dim>& context, const StepBasis& basis, const LumpedMass& lumped)
{
  const MPI_Comm communicator = basis.nodes.communicator;
  const ParticleArrays& particles = context.soil.particles().arrays();
  const SteppingParameters& stepping = context.stage.stepping;
  const double soil_bound = max_over_ranks(bound_squared_frequency(particles, basis.stencils, context.soil.materials(),
                                                                   least_share(context.basis)),
                                           communicator) /
                            stepping.mass_scaling;
  // Local damping works like a share of stiffness where motion turns in every time step, as it does at the limit.
  const double damped = 1. + stepping.damping;
  double soil = soil_bound, all = soil_bound, bodies = 0.;
  PointForces points;
  View<double*> stiffness;
  if (context.stage.rigid_bodies)
  {
    points = context.soil.contact().points_of_last_evaluation();
    stiffness = context.soil.contact().point_stiffness();
    all += bound_of_springs(points, stiffness, lumped, communicator);
    bodies = context.soil.contact().largest_body_frequency(context.bodies);
  }
  if (pays(stepping, damped * (all + bodies)))
  {
    ElasticSoil system{particles,
                       basis.stencils,
                       context.soil.materials(),
                       lumped.inertia,
                       lumped.of_dofs,
                       std::size_t(dim) * basis.nodes.n_owned,
                       scattered_numbers(context, basis.nodes),
                       communicator,
                       points,
                       stiffness};
    all = find_squared_frequency<dim>(system, all);
    soil = std::min(all, soil_bound);
    if (all + bodies > soil_bound) // else springs matter so little that nobody asks for the soil alone
    {
      system.points = {};
      soil = find_squared_frequency<dim>(system, soil_bound);
    }
  }
  return {2. / std::sqrt(damped * (all + bodies)), 2. / std::sqrt(damped * soil)};
}

template StableStep find_stable_step<2>(const StepContext<2>&, const StepBasis&, const LumpedMass&);
template StableStep find_stable_step<3>(const StepContext<3>&, const StepBasis&, const LumpedMass&);
} // namespace kedge
