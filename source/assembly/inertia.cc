#include <kedge/assembly/ghost.h>
#include <kedge/assembly/inertia.h>
#include <kedge/assembly/kernels.h>
#include <kedge/assembly/nodal_operator.h>
#include <kedge/base/exceptions.h>
#include <kedge/solvers/linear_solver.h>

namespace kedge
{
namespace
{
/// Columns that are summed at once: all of a particle in regular cells.
constexpr unsigned int mass_block = 27;

/// Two sums a component, which do not wait for each other.
template <int dim>
void add_mass_product(const NodeGraph& graph, const NodalMass& mass, const double factor, const NodalVector& x,
                      const NodalVector& result)
{
  const auto row_begin = graph.row_begin;
  const auto column = graph.column;
  Kokkos::parallel_for(
      "mass times vector", Kokkos::RangePolicy<ExecutionSpace>(0, graph.n_rows), KOKKOS_LAMBDA(const unsigned int row) {
        double sum[2][dim] = {};
        const std::size_t end = row_begin(row + 1);
        for (std::size_t k = row_begin(row); k < end; k += 2)
          for (std::size_t odd = 0; odd < 2 && k + odd < end; ++odd)
            for (int c = 0; c < dim; ++c)
              sum[odd][c] += mass(k + odd) * x(static_cast<std::size_t>(dim) * column(k + odd) + c);
        for (int c = 0; c < dim; ++c)
          result(static_cast<std::size_t>(dim) * row + c) += factor * (sum[0][c] + sum[1][c]);
      });
}
} // namespace

namespace
{
/// Relative residual of the projection. The increments that follow from it need this accuracy.
constexpr double projection_tolerance = 1e-12;
/// What will do where round-off allows no more: far below what a step is solved to.
constexpr double loosest_projection = 1e-8;

/// What is divided by M nearly is corrected so often, by a mass with a share of its row sums in addition on its
/// diagonal. A pattern of nodes whose mass is a share s of its row sums then has the relative error (1 - s) (share / (s
/// + share))^2.
constexpr unsigned int corrections = 2;
constexpr double share_for_forces = 1e-3, share_where_round_off_rules = 1e-6;

double relative_residual(const TpetraOperator& product, const TpetraVector& right_side, const TpetraVector& solution)
{
  TpetraVector residual(right_side, Teuchos::Copy);
  product.apply(solution, residual, Teuchos::NO_TRANS, -1., 1.);
  return residual.norm2() / right_side.norm2();
}

/// Of the owned dofs; constrained ones have 1.
TpetraVector diagonal_of(const NodeGraph& graph, const NodalMass& mass, const System& system)
{
  const NodalVector local = system.make_nodal_vector();
  const auto row_begin = graph.row_begin;
  const auto column = graph.column;
  const unsigned int dim = graph.dim;
  Kokkos::parallel_for(
      "mass diagonal", Kokkos::RangePolicy<ExecutionSpace>(0, graph.n_rows), KOKKOS_LAMBDA(const unsigned int row) {
        for (unsigned int c = 0; c < dim; ++c)
          local(static_cast<std::size_t>(dim) * row + c) = mass(find_entry(row_begin, column, row, row));
      });
  TpetraVector diagonal(system.graph().row_map), ones(system.graph().row_map);
  ones.putScalar(1.);
  system.collect(local, diagonal);
  system.keep_constrained(ones, diagonal);
  return diagonal;
}
} // namespace

void add_particle_mass(const ParticleArrays& particles, const StencilSet& stencils, const bool lumped,
                       const NodeGraph& graph, const NodalMass& mass)
{
  const auto row_begin = graph.row_begin;
  const auto column = graph.column;
  if (lumped)
  {
    Kokkos::parallel_for(
        "lumped mass", Kokkos::RangePolicy<ExecutionSpace>(0, particles.n), KOKKOS_LAMBDA(const unsigned int p) {
          const ParticleNodes at = nodes_of(stencils, p);
          for (unsigned int v = 0; v < at.n; ++v)
            add_to(mass(find_entry(row_begin, column, at.node[v], at.node[v])), particles.mass(p) * at.value[v]);
        });
    return;
  }
  // The diagonal and what is right of it, then the rest: M is symmetric.
  Kokkos::parallel_for(
      "particle mass", Kokkos::RangePolicy<ExecutionSpace>(0, stencils.n_patterns),
      KOKKOS_LAMBDA(const std::size_t pattern) {
        const unsigned int first = stencils.pattern_node_begin(pattern);
        const unsigned int n = stencils.pattern_node_begin(pattern + 1) - first;
        for (unsigned int a = 0; a < n; ++a)
        {
          const unsigned int row = stencils.pattern_nodes(first + a);
          std::size_t at = find_entry(row_begin, column, row, row);
          for (unsigned int b = a; b < n; b += mass_block)
          {
            const unsigned int length = n - b < mass_block ? n - b : mass_block;
            double sum[mass_block] = {};
            for (unsigned int i = stencils.pattern_particle_begin(pattern);
                 i < stencils.pattern_particle_begin(pattern + 1); ++i)
            {
              const unsigned int p = stencils.pattern_particles(i);
              const double* value = &stencils.value(stencils.value_begin(p));
              const double share = particles.mass(p) * value[a];
              for (unsigned int k = 0; k < length; ++k)
                sum[k] += share * value[b + k];
            }
            for (unsigned int k = 0; k < length; ++k)
            {
              while (column(at) != stencils.pattern_nodes(first + b + k)) // both lists ascend
                ++at;
              add_to(mass(at), sum[k]);
            }
          }
        }
      });
  Kokkos::parallel_for(
      "mirror mass", Kokkos::RangePolicy<ExecutionSpace>(0, graph.n_rows), KOKKOS_LAMBDA(const unsigned int row) {
        for (std::size_t k = row_begin(row); column(k) < row; ++k)
          mass(k) = mass(find_entry(row_begin, column, column(k), row));
      });
}

void add_mass_times(const NodeGraph& graph, const NodalMass& mass, const double factor, const NodalVector& x,
                    const NodalVector& result)
{
  (graph.dim == 3 ? add_mass_product<3> : add_mass_product<2>)(graph, mass, factor, x, result);
}

void add_mass_matrix(const NodeGraph& mass_graph, const NodalMass& mass, const double factor, const NodeGraph& graph,
                     const View<double*>& values)
{
  const auto mass_begin = mass_graph.row_begin, row_begin = graph.row_begin;
  const auto mass_column = mass_graph.column, column = graph.column;
  const unsigned int dim = graph.dim;
  Kokkos::parallel_for(
      "mass matrix", Kokkos::RangePolicy<ExecutionSpace>(0, graph.n_rows), KOKKOS_LAMBDA(const unsigned int row) {
        const std::size_t begin = row_begin(row), length = row_begin(row + 1) - begin;
        double* block_row = &values(std::size_t(dim) * dim * begin);
        for (std::size_t k = mass_begin(row); k < mass_begin(row + 1); ++k)
        {
          const std::size_t position = find_entry_or_diagonal(row_begin, column, row, mass_column(k)) - begin;
          for (unsigned int c = 0; c < dim; ++c)
            block_row[dim * (c * length + position) + c] += factor * mass(k);
        }
      });
}

void add_particle_momentum(const ParticleArrays& particles, const StencilSet& stencils,
                           const View<double* [3]>& quantity, const NodalVector& result)
{
  const unsigned int dim = stencils.dim;
  Kokkos::parallel_for(
      "particle momentum", Kokkos::RangePolicy<ExecutionSpace>(0, particles.n), KOKKOS_LAMBDA(const unsigned int p) {
        const double q[3] = {quantity(p, 0), quantity(p, 1), quantity(p, 2)};
        add_weighted_by_mass(particles, stencils, dim, p, q, result);
      });
}

namespace
{
/// M x = b on the owned dofs; false where round-off does not allow it.
bool solve_mass_system(const TpetraVector& right_side, const NodeGraph& graph, const NodalMass& mass,
                       const System& system, TpetraVector& solution)
{
  const auto product = Teuchos::rcp(new NodalOperator(system, [&](const NodalVector& x, const NodalVector& y)
                                                      { add_mass_times(graph, mass, 1., x, y); }));
  return solve_positive_definite(product, diagonal_of(graph, mass, system), right_side, solution,
                                 projection_tolerance) ||
         relative_residual(*product, right_side, solution) < loosest_projection;
}

/// M with a share of its row sums, the first of `dim` equal ones of each node, on its diagonal.
NodalMass with_share_of_row_sums(const NodeGraph& graph, const NodalMass& mass, const double share,
                                 const NodalVector& row_sums)
{
  const NodalMass result("mass and a share of its row sums", mass.extent(0));
  Kokkos::deep_copy(result, mass);
  const auto row_begin = graph.row_begin;
  const auto column = graph.column;
  const unsigned int dim = graph.dim;
  Kokkos::parallel_for(
      "row sums", Kokkos::RangePolicy<ExecutionSpace>(0, graph.n_rows), KOKKOS_LAMBDA(const unsigned int row) {
        result(find_entry(row_begin, column, row, row)) += share * row_sums(std::size_t(dim) * row);
      });
  return result;
}

/// Nearly M^-1 b on the owned dofs, which are zero in b where they are held: b over the row sums of M, corrected by a
/// mass that has a share of them in addition. Exact where all nodes move alike.
TpetraVector solve_nearly(const TpetraVector& right_side, const NodeGraph& graph, const NodalMass& mass,
                          const System& system, const double share)
{
  const NodalVector ones = system.make_nodal_vector(), local = system.make_nodal_vector();
  Kokkos::deep_copy(ones, 1.);
  add_mass_times(graph, mass, 1., ones, local);
  TpetraVector inverse(system.graph().row_map), one(system.graph().row_map);
  system.collect(local, inverse);
  one.putScalar(1.);
  system.keep_constrained(one, inverse);
  inverse.reciprocal(inverse);

  const NodalOperator product(system, [&](const NodalVector& x, const NodalVector& y)
                              { add_mass_times(graph, mass, 1., x, y); });
  TpetraVector solution(system.graph().row_map), left(right_side, Teuchos::Copy), correction(solution.getMap());
  solution.elementWiseMultiply(1., inverse, right_side, 0.);
  const NodalMass heavier = with_share_of_row_sums(graph, mass, share, local);
  for (unsigned int k = 0; k < corrections; ++k)
  {
    Tpetra::deep_copy(left, right_side);
    product.apply(solution, left, Teuchos::NO_TRANS, -1., 1.);
    if (!solve_mass_system(left, graph, heavier, system, correction))
      throw SolverError("the motion of the soil could not be projected to the nodes: the mass matrix is too badly "
                        "conditioned; increase \"ghost factor mass\", set \"mass\": \"lumped\" or, where the soil "
                        "flies apart, damp with a \"gamma\" above 0.5",
                        {});
    solution.update(1., correction, 1.);
  }
  return solution;
}

/// M^-1 b, or what comes near to it where soil reaches into cells by so little that round-off does not allow it.
NodalVector project(TpetraVector& right_side, const NodeGraph& graph, const NodalMass& mass, const System& system)
{
  system.zero_constrained(right_side);
  TpetraVector solution(system.graph().row_map);
  return system.spread(solve_mass_system(right_side, graph, mass, system, solution)
                           ? solution
                           : solve_nearly(right_side, graph, mass, system, share_where_round_off_rules));
}
} // namespace

NodalVector find_accelerations(TpetraVector& forces, const NodeGraph& graph, const NodalMass& mass,
                               const System& system, const bool has_ghost_mass)
{
  if (has_ghost_mass)
    return project(forces, graph, mass, system);
  system.zero_constrained(forces);
  return system.spread(solve_nearly(forces, graph, mass, system, share_for_forces));
}

NodalMotion project_motion(const ParticleArrays& particles, const StencilSet& stencils, const GhostFaces& faces,
                           const bool lumped, const bool with_acceleration, const NodeGraph& graph,
                           const System& system)
{
  NodalMotion motion;
  motion.mass = NodalMass("nodal mass", graph.column.extent(0));
  add_particle_mass(particles, stencils, lumped, graph, motion.mass);
  if (faces.n_faces() > 0)
    add_ghost_mass(faces, graph, motion.mass);

  const auto project_to_nodes = [&](const View<double* [3]>& quantity)
  {
    const NodalVector momentum = system.make_nodal_vector();
    add_particle_momentum(particles, stencils, quantity, momentum);
    TpetraVector right_side(system.graph().row_map);
    system.collect(momentum, right_side);
    return project(right_side, graph, motion.mass, system);
  };
  motion.velocity = project_to_nodes(particles.velocity);
  motion.acceleration = with_acceleration ? project_to_nodes(particles.acceleration) : system.make_nodal_vector();
  return motion;
}

namespace
{
/// Newmark's accelerations of all local nodes.
NodalVector end_accelerations(const NodalMotion& motion, const Newmark& newmark, const NodalVector& increment)
{
  const NodalVector result("acceleration", increment.extent(0));
  const NodalVector velocity = motion.velocity, acceleration = motion.acceleration;
  Kokkos::parallel_for(
      "Newmark", Kokkos::RangePolicy<ExecutionSpace>(0, increment.extent(0)), KOKKOS_LAMBDA(const std::size_t i) {
        result(i) = newmark.acceleration(increment(i), velocity(i), acceleration(i));
      });
  return result;
}
} // namespace

void add_inertia_force(const NodeGraph& graph, const NodalMotion& motion, const Newmark& newmark,
                       const NodalVector& increment, const NodalVector& force)
{
  add_mass_times(graph, motion.mass, 1., end_accelerations(motion, newmark, increment), force);
}

ParticleMotion particle_motion(const StencilSet& stencils, const NodalMotion& motion, const Newmark& newmark,
                               const NodalVector& increment)
{
  const NodalVector end = end_accelerations(motion, newmark, increment);
  const NodalVector change("velocity change", end.extent(0)), start = motion.acceleration;
  Kokkos::parallel_for(
      "velocity change", Kokkos::RangePolicy<ExecutionSpace>(0, end.extent(0)),
      KOKKOS_LAMBDA(const std::size_t i) { change(i) = newmark.velocity_change(start(i), end(i)); });
  return {interpolate_to_particles(stencils, change), interpolate_to_particles(stencils, end)};
}
} // namespace kedge
