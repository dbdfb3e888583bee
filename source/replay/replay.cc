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

/// Largest difference over the largest entry of what was saved; infinite where one is no number, or was not saved.
double difference(const std::vector<double>& found, const std::vector<double>& saved, const MPI_Comm communicator)
{
  double apart = found.size() == saved.size() ? 0. : INFINITY, largest = 0.;
  for (std::size_t i = 0; i < std::min(found.size(), saved.size()); ++i)
  {
    const double gap = std::abs(found[i] - saved[i]);
    apart = std::max(apart, std::isnan(gap) ? INFINITY : gap);
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

/// Computes the parts of a saved step, one after the other.
template <int dim> class Replay
{
public:
  Replay(SavedStep& step, const ReplayOptions& options);

  /// All of them. Called once.
  ReplayReport run();

private:
  /// Computes a part, times it and notes it in the report. Returns the shortest time, s.
  template <typename Work> double time(const char* name, const Work& work);
  /// Tells people who wait what is done, or how far off an answer is.
  template <typename Word> void say(const char* text, const Word& word) const;
  void tell_difference(const double apart) const { say("differs by {:.2g} from what was saved", apart); }

  void set_up_equations();
  void find_residual();
  void find_tangent();
  void find_product();
  void find_whole_matrix();
  void solve();
  /// One solution of the system; throws SolverError.
  void solve_with(LinearSolver& solver);
  std::unique_ptr<LinearSolver> make_solver(bool keeps_hierarchies) const;
  /// Takes from the time of a part what else was done in it.
  void leave_hierarchy_alone(const char* name, double others);
  void check_solution();

  SavedStep& step;
  const ReplayOptions& options;
  MPI_Comm communicator;
  std::size_t n_rigid;
  Timings timings;
  ReplayReport report;
  std::unique_ptr<NodalEquations<dim>> equations;
  Border border;
  LinearSystem linear;
  std::unique_ptr<TpetraVector> residual, solution;
  Eigen::VectorXd rigid_side, rigid_solution;
};

template <int dim>
Replay<dim>::Replay(SavedStep& step, const ReplayOptions& options)
    : step(step),
      options(options),
      communicator(step.parts.numbering.communicator),
      n_rigid(step.rigid_side.size()),
      rigid_side(Eigen::Map<const Eigen::VectorXd>(step.rigid_side.data(), n_rigid))
{
  report.dim = dim;
  report.n_particles = sum_over_ranks(static_cast<long long>(step.parts.particles.n), communicator);
  report.n_dofs = sum_over_ranks(static_cast<long long>(dim) * step.parts.numbering.n_owned, communicator);
  report.tolerance = step.tolerance;
}

template <int dim> ReplayReport Replay<dim>::run()
{
  set_up_equations();
  find_residual();
  find_tangent();
  find_product();
  if (report.n_dofs <= most_factorised)
    find_whole_matrix();
  solve();
  check_solution();
  return report;
}

template <int dim> template <typename Work> double Replay<dim>::time(const char* name, const Work& work)
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
}

template <int dim> template <typename Word> void Replay<dim>::say(const char* text, const Word& word) const
{
  if (rank_of(communicator) == 0)
    fmt::print(stderr, fmt::runtime(std::string(text) + "\n"), word);
}

template <int dim> void Replay<dim>::set_up_equations()
{
  time("sparsity",
       [&]
       {
         equations.reset(); // its memory first
         equations = std::make_unique<NodalEquations<dim>>(step.parts, false, step.is_dynamic != 0, timings);
       });
  equations->set_motion(step.motion);
  equations->set_newmark(step.newmark);
}

template <int dim> void Replay<dim>::find_residual()
{
  const System& system = equations->system();
  ContactArrays& contact = step.contact.arrays;
  residual = std::make_unique<TpetraVector>(system.graph().row_map);
  time("residual",
       [&]
       {
         const NodalVector force = system.make_nodal_vector();
         equations->add_force(step.increment, force);
         evaluate_contact(dim, contact, step.contact.motions, step.increment, step.contact.keeps_multipliers != 0);
         add_point_forces(dim, contact.points, -1., force);
         system.collect(force, *residual);
         add_to_owned(step.other, *residual);
         system.zero_constrained(*residual);
       });
  report.residual_difference = difference(values_of(*residual), step.residual, communicator);
  tell_difference(report.residual_difference);
}

template <int dim> void Replay<dim>::find_tangent()
{
  ContactArrays& contact = step.contact.arrays;
  time("tangent",
       [&]
       {
         equations->linearise(step.increment, contact.points, step.elastic_share);
         if (n_rigid > 0)
           border = contact_border(contact, step.contact.motions, step.contact.rates(), equations->system());
       });
  linear = equations->linear_system();
  if (n_rigid == 0)
    return;
  border.corner = Eigen::Map<const Eigen::MatrixXd>(step.corner.data(), n_rigid, n_rigid);
  report.border_difference = std::max(difference(values_of(*border.columns), step.columns, communicator),
                                      difference(values_of(*border.rows), step.rows, communicator));
  tell_difference(report.border_difference);
}

template <int dim> void Replay<dim>::find_product()
{
  TpetraVector product(residual->getMap());
  const auto saved = vectors_of(step.solution, residual->getMap(), 1);
  for (const TpetraMultiVector* const vectors : {saved.get(), static_cast<TpetraMultiVector*>(&product)})
    vectors->getLocalViewDevice(Tpetra::Access::ReadOnly); // what the host has written goes there once
  time("product", [&] { linear.product->apply(*saved, product); });
  report.product_difference = difference(values_of(product), step.product, communicator);
  tell_difference(report.product_difference);
}

template <int dim> void Replay<dim>::find_whole_matrix()
{
  Teuchos::RCP<TpetraMatrix> whole;
  time("whole matrix", [&] { whole = equations->assemble_whole(); });
  TpetraVector product(residual->getMap());
  whole->apply(*vectors_of(step.solution, residual->getMap(), 1), product);
  report.whole_difference = difference(values_of(product), step.product, communicator);
  tell_difference(*report.whole_difference);
}

template <int dim> void Replay<dim>::solve()
{
  solution = std::make_unique<TpetraVector>(residual->getMap());
  const double matrix = time("matrix", [&] { linear.near(); });
  auto solver = make_solver(false); // renews its hierarchy in every solution
  time("hierarchy",
       [&]
       {
         solver->set_structure(linear); // forgets the hierarchy
         solve_with(*solver);
       });
  time("renewal", [&] { solve_with(*solver); });
  solver.reset(); // its memory first
  solver = make_solver(true);
  solve_with(*solver);
  const double krylov = time("solution", [&] { solve_with(*solver); });
  report.parts.back().remark = fmt::format("{} iterations", report.linear_iterations);
  for (const char* const name : {"hierarchy", "renewal"})
    leave_hierarchy_alone(name, krylov + matrix);
}

template <int dim> void Replay<dim>::solve_with(LinearSolver& solver)
{
  const LinearReport solved = solver.solve(*residual, rigid_side, border, *solution, rigid_solution, step.tolerance);
  if (!solved.converged || solved.method == "UMFPACK")
    throw SolverError(solved.trouble.empty() ? "the linear system could not be solved by iteration"
                                             : "no multigrid hierarchy: " + solved.trouble,
                      {});
  report.linear_iterations = solved.iterations;
}

template <int dim> std::unique_ptr<LinearSolver> Replay<dim>::make_solver(const bool keeps_hierarchies) const
{
  SolverParameters parameters;
  parameters.linear_solver = LinearSolverChoice::iterative;
  parameters.reuse = keeps_hierarchies;
  auto solver = std::make_unique<LinearSolver>(parameters, dim);
  solver->set_structure(linear);
  return solver;
}

template <int dim> void Replay<dim>::leave_hierarchy_alone(const char* name, const double others)
{
  ReplayedPart& part = *std::find_if(report.parts.begin(), report.parts.end(),
                                     [&](const ReplayedPart& one) { return one.name == name; });
  part.seconds = std::max(0., part.seconds - others);
  part.remark = "copies and kernels are those of matrix and solution, too";
}

/// GMRES compares with the right side of which the border's unknowns are eliminated.
template <int dim> void Replay<dim>::check_solution()
{
  TpetraVector left(*residual, Teuchos::Copy), side(*residual, Teuchos::Copy);
  linear.product->apply(*solution, left, Teuchos::NO_TRANS, -1., 1.);
  if (n_rigid > 0)
  {
    add_columns(border, -1., rigid_solution, left);
    add_columns(border, -1., ScaledFactors(border.corner).solve(rigid_side), side);
  }
  report.solution_residual = left.norm2() / side.norm2();
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
  return step.dim == 2 ? Replay<2>(step, options).run() : Replay<3>(step, options).run();
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
