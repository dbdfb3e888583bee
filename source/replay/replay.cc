#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <kedge/base/communication.h>
#include <kedge/base/exceptions.h>
#include <kedge/base/failure.h>
#include <kedge/replay/replay.h>
#include <kedge/solvers/linear_solver.h>
#include <kedge/solvers/scaled_factors.h>

namespace kedge
{
namespace
{
/// The shortest time of some repetitions on the slowest rank, s.
template <typename Work> double shortest(const unsigned int repetitions, const MPI_Comm communicator, const Work& work)
{
  double best = INFINITY;
  for (unsigned int i = 0; i < repetitions; ++i)
  {
    MPI_Barrier(communicator);
    const auto start = std::chrono::steady_clock::now();
    work();
    Kokkos::fence();
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
    best = std::min(best, max_over_ranks(passed.count(), communicator));
  }
  return best;
}

/// Unknowns up to which systems may be factorised, so that the whole matrix is assembled, too.
constexpr long long most_factorised = 20000;

/// Largest difference over the largest entry of what was saved.
double difference(const std::vector<double>& found, const std::vector<double>& saved, const MPI_Comm communicator)
{
  double apart = 0., largest = 0.;
  for (std::size_t i = 0; i < saved.size(); ++i)
  {
    apart = std::max(apart, std::abs(found[i] - saved[i]));
    largest = std::max(largest, std::abs(saved[i]));
  }
  apart = max_over_ranks(apart, communicator);
  return apart == 0. ? 0. : apart / max_over_ranks(largest, communicator);
}

void add_to_owned(const NodalVector& other, TpetraVector& residual)
{
  const auto owned = Kokkos::subview(residual.getLocalViewDevice(Tpetra::Access::ReadWrite), Kokkos::ALL(), 0);
  Kokkos::parallel_for(
      "other forces", Kokkos::RangePolicy<ExecutionSpace>(0, owned.extent(0)),
      KOKKOS_LAMBDA(const std::size_t i) { owned(i) += other(i); });
}

template <int dim> ReplayReport replay(SavedStep& step, const ReplayOptions& options)
{
  const MPI_Comm communicator = step.parts.numbering.communicator;
  ReplayReport report;
  report.dim = dim;
  report.n_particles = sum_over_ranks(static_cast<long long>(step.parts.particles.n), communicator);
  report.n_dofs = sum_over_ranks(static_cast<long long>(dim) * step.parts.numbering.n_owned, communicator);
  report.tolerance = step.tolerance;
  const auto say = [&](const auto& text, const auto& word)
  {
    if (rank_of(communicator) == 0)
      fmt::print(stderr, fmt::runtime(std::string(text) + "\n"), word);
  };
  const auto time = [&](const char* name, const auto& work)
  {
    ReplayedPart part;
    part.name = name;
    say("{} ...", name); // who waits in vain knows for what
    if (options.watch != KernelWatch::none)
    {
      const KernelProfiler profiler(options.watch);
      work();
      part.profile = profiler.profile();
    }
    {
      const KernelProfiler counter(KernelWatch::none);
      part.seconds = shortest(options.repetitions, communicator, work);
      part.copied_bytes = copied_bytes(counter.profile()) / options.repetitions;
    }
    report.parts.push_back(part);
    return part.seconds;
  };

  Timings timings;
  std::unique_ptr<NodalEquations<dim>> equations;
  time("sparsity",
       [&]
       {
         equations.reset(); // its memory first
         equations = std::make_unique<NodalEquations<dim>>(step.parts, false, step.is_dynamic != 0, timings);
       });
  equations->set_motion(step.motion);
  equations->set_newmark(step.newmark);
  const System& system = equations->system();
  ContactArrays& contact = step.contact.arrays;

  TpetraVector residual(system.graph().row_map);
  time("residual",
       [&]
       {
         const NodalVector force = system.make_nodal_vector();
         equations->add_force(step.increment, force);
         evaluate_contact(dim, contact, step.contact.motions, step.increment, step.contact.keeps_multipliers != 0);
         add_point_forces(dim, contact.points, -1., force);
         system.collect(force, residual);
         add_to_owned(step.other, residual);
         system.zero_constrained(residual);
       });
  report.residual_difference = difference(values_of(residual), step.residual, communicator);
  say("differs by {:.2g} from what was saved", report.residual_difference);

  Border border;
  time("tangent",
       [&]
       {
         equations->linearise(step.increment, contact.points, step.elastic_share);
         if (!step.rigid_side.empty())
           border = contact_border(contact, step.contact.motions, step.contact.rates(), system);
       });
  const std::size_t n_rigid = step.rigid_side.size();
  if (n_rigid > 0)
  {
    border.corner = Eigen::Map<const Eigen::MatrixXd>(step.corner.data(), n_rigid, n_rigid);
    report.border_difference = std::max(difference(values_of(*border.columns), step.columns, communicator),
                                        difference(values_of(*border.rows), step.rows, communicator));
    say("differs by {:.2g} from what was saved", report.border_difference);
  }
  LinearSystem linear = equations->linear_system();
  TpetraVector product(system.graph().row_map);
  {
    const auto saved = vectors_of(step.solution, system.graph().row_map, 1);
    for (const TpetraMultiVector* const vectors : {saved.get(), static_cast<TpetraMultiVector*>(&product)})
      vectors->getLocalViewDevice(Tpetra::Access::ReadOnly); // what the host has written goes there once
    time("product", [&] { linear.product->apply(*saved, product); });
  }
  report.product_difference = difference(values_of(product), step.product, communicator);
  say("differs by {:.2g} from what was saved", report.product_difference);

  if (report.n_dofs <= most_factorised)
  {
    Teuchos::RCP<TpetraMatrix> whole;
    time("whole matrix", [&] { whole = equations->assemble_whole(); });
    whole->apply(*vectors_of(step.solution, system.graph().row_map, 1), product);
    report.whole_difference = difference(values_of(product), step.product, communicator);
    say("differs by {:.2g} from what was saved", *report.whole_difference);
  }

  const double matrix = time("matrix", [&] { linear.near(); });
  const Eigen::VectorXd rigid_side = Eigen::Map<const Eigen::VectorXd>(step.rigid_side.data(), n_rigid);
  TpetraVector solution(system.graph().row_map);
  Eigen::VectorXd rigid_solution;
  const auto make_solver = [&](const bool reuse)
  {
    SolverParameters parameters;
    parameters.linear_solver = LinearSolverChoice::iterative;
    parameters.reuse = reuse;
    auto solver = std::make_unique<LinearSolver>(parameters, dim);
    solver->set_structure(linear);
    return solver;
  };
  const auto solve = [&](LinearSolver& solver)
  {
    const LinearReport solved = solver.solve(residual, rigid_side, border, solution, rigid_solution, step.tolerance);
    if (!solved.converged || solved.method == "UMFPACK")
      throw SolverError(solved.trouble.empty() ? "the linear system could not be solved by iteration"
                                               : "no multigrid hierarchy: " + solved.trouble,
                        {});
    report.linear_iterations = solved.iterations;
  };
  // A solver that keeps no hierarchy as it is renews it in every solution.
  auto solver = make_solver(false);
  const double first = time("hierarchy",
                            [&]
                            {
                              solver->set_structure(linear); // forgets the hierarchy
                              solve(*solver);
                            });
  const double renewed = time("renewal", [&] { solve(*solver); });
  solver.reset(); // its memory first
  solver = make_solver(true);
  solve(*solver);
  const double krylov = time("solution", [&] { solve(*solver); });
  report.parts.back().remark = fmt::format("{} iterations", report.linear_iterations);
  // Both without what else was done for them.
  for (const auto& [name, whole] : {std::make_pair("hierarchy", first), std::make_pair("renewal", renewed)})
  {
    ReplayedPart& part = *std::find_if(report.parts.begin(), report.parts.end(),
                                       [&, name = name](const ReplayedPart& one) { return one.name == name; });
    part.seconds = std::max(0., whole - krylov - matrix);
    part.remark = "copies and kernels are those of matrix and solution, too";
  }

  // GMRES compares with the right side of which the border's unknowns are eliminated.
  TpetraVector left(residual, Teuchos::Copy), side(residual, Teuchos::Copy);
  linear.product->apply(solution, left, Teuchos::NO_TRANS, -1., 1.);
  if (n_rigid > 0)
  {
    add_columns(border, -1., rigid_solution, left);
    add_columns(border, -1., ScaledFactors(border.corner).solve(rigid_side), side);
  }
  report.solution_residual = left.norm2() / side.norm2();
  return report;
}
} // namespace

ReplayReport replay_step(const std::string& path, const ReplayOptions& options)
{
  const MPI_Comm world = MPI_COMM_WORLD;
  SavedStep step;
  agree(world,
        [&]
        {
          step = read_step(rank_file(path, world), options.copies);
          if (step.n_ranks != static_cast<unsigned int>(size_of(world)))
            throw FileError(path, fmt::format("was saved by {} ranks and is replayed by as many", step.n_ranks));
        });
  return step.dim == 2 ? replay<2>(step, options) : replay<3>(step, options);
}

std::string format_replay(const ReplayReport& report, const std::string& back_end)
{
  std::string text = fmt::format("{}-D, {} material points, {} unknowns; back end {}\n", report.dim, report.n_particles,
                                 report.n_dofs, back_end);
  text += fmt::format("{:<12}{:>12}{:>18}{:>12}\n", "part", "seconds", "ns per point", "MB copied");
  double both = 0., hierarchy = 0., renewal = 0.;
  for (const ReplayedPart& part : report.parts)
  {
    if (part.name == "hierarchy")
      hierarchy = part.seconds;
    else if (part.name == "renewal")
      renewal = part.seconds;
    else if (part.name != "sparsity" && part.name != "product" && part.name != "whole matrix")
      both += part.seconds;
    text += fmt::format("{:<12}{:>12.4g}{:>18.4g}{:>12.4g}  {}\n", part.name, part.seconds,
                        1e9 * part.seconds / report.n_particles, 1e-6 * part.copied_bytes, part.remark);
  }
  for (const auto& [name, seconds, remark] :
       {std::make_tuple("first", both + hierarchy, "iteration of a step, without sparsity and renewal"),
        std::make_tuple("iteration", both + renewal, "a later one; the product is part of the solution")})
    text += fmt::format("{:<12}{:>12.4g}{:>18.4g}              {}\n", name, seconds, 1e9 * seconds / report.n_particles,
                        remark);
  text += fmt::format("difference from what was saved: residual {:.2g}, product {:.2g}, border {:.2g}\n",
                      report.residual_difference, report.product_difference, report.border_difference);
  if (report.whole_difference)
    text += fmt::format("product with the whole matrix {:.2g}\n", *report.whole_difference);
  text += fmt::format("linear residual {:.2g} for a tolerance of {:.2g}\n", report.solution_residual, report.tolerance);
  for (const ReplayedPart& part : report.parts)
    if (!part.profile.kernels.empty())
      text += fmt::format("\n{}\n{}", part.name, format_profile(part.profile, 25));
  return text;
}
} // namespace kedge
