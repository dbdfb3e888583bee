// The command line of kedge-replay.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <fmt/format.h>
#include <kedge/base/environment.h>
#include <kedge/base/failure.h>
#include <kedge/replay/replay.h>

namespace
{
/// Residuals and borders of two back ends differ by round-off. Products differ by more where an entry of the
/// derivative, which is held in single precision, is rounded the other way.
constexpr double residual_limit = 1e-10, border_limit = 1e-10, product_limit = 1e-6;
/// Preconditioners differ, and so does where GMRES stops; it measures its residual by recurrence.
constexpr double tolerance_factor = 1.1;
/// Between two residuals only the rigid unknowns and the coarsest level of multigrid may cross the bus, bytes; the
/// latter in every iteration of GMRES.
constexpr double most_copied = 1e5, most_copied_by_iteration = 2e4;

/// Parts of an iteration, other than the renewal of the hierarchy, that copy more between host and device.
std::string parts_that_copy(const kedge::ReplayReport& report)
{
  std::string names;
  for (const kedge::ReplayedPart& part : report.parts)
    for (const char* const name : {"residual", "tangent", "product", "matrix", "solution"})
    {
      const unsigned int iterations = part.name == "solution" ? report.linear_iterations : 0;
      if (part.name == name && part.copied_bytes > most_copied + iterations * most_copied_by_iteration)
        names += (names.empty() ? "" : ", ") + part.name;
    }
  return names;
}

int run_program(const kedge::Environment& environment, const int argc, char** argv)
{
  CLI::App app(
      "Computes a linear system that \"kedge dump-step\" has written, times its parts on this build's back end "
      "and compares the answers with those of the run");
  app.name("kedge-replay");
  app.footer(
      "With as many ranks as the run had: mpirun -n 2 kedge-replay FILE\n"
      "Options that begin with --kokkos- go to Kokkos: --kokkos-num-threads=8\n"
      "Exit codes: 0 done, 2 wrong command line, 3 the answers differ or an iteration copies vectors between host "
      "and device, 4 the file could not be read");
  std::string path;
  kedge::ReplayOptions options;
  app.add_option("FILE", path, "What \"kedge dump-step\" has written")->required();
  app.add_option("--repeat", options.repetitions, "Times that every part is computed; the shortest counts [3]")
      ->check(CLI::Range(1, 1000000));
  app.add_option("--copies", options.copies,
                 "Computes a system of that many copies of the soil, which share the bodies: as large as a machine can "
                 "hold, with the same answers [1]")
      ->check(CLI::Range(1, 1000000));
  bool times_kernels = false, prints_names = false;
  app.add_flag("--kernels", times_kernels, "Prints what kernels and copies between host and device take");
  app.add_flag("--trace", prints_names,
               "Prints the name of every kernel before it begins: the last one hangs, or dies");
  std::vector<std::string> words;
  for (int i = argc - 1; i > 0; --i)
    if (std::string(argv[i]).rfind("--kokkos-", 0) != 0)
      words.push_back(argv[i]);
  try
  {
    app.parse(words);
  }
  catch (const CLI::ParseError& error)
  {
    return app.exit(error) == 0 ? kedge::success : kedge::bad_input;
  }
  options.watch = prints_names    ? kedge::KernelWatch::names
                  : times_kernels ? kedge::KernelWatch::time
                                  : kedge::KernelWatch::none;
  const kedge::ReplayReport report = kedge::replay_step(path, options);
  const bool agrees = report.residual_difference <= residual_limit && report.border_difference <= border_limit &&
                      report.product_difference <= product_limit &&
                      report.whole_difference.value_or(0.) <= product_limit &&
                      report.solution_residual <= tolerance_factor * report.tolerance;
  const std::string copying = parts_that_copy(report);
  if (environment.rank() == 0)
  {
    fmt::print("{}", kedge::format_replay(report, kedge::ExecutionSpace::name()));
    if (!agrees)
      fmt::print("the answers differ by more than {:.0e} (residual and border), {:.0e} (product) and the tolerance\n",
                 residual_limit, product_limit);
    if (!copying.empty())
      fmt::print("copied between host and device: more than {:.0f} kB (and {:.0f} for each iteration of GMRES) in {}\n",
                 1e-3 * most_copied, 1e-3 * most_copied_by_iteration, copying);
  }
  return agrees && copying.empty() ? kedge::success : kedge::solver_failure;
}
} // namespace

int main(int argc, char** argv)
{
  kedge::Environment environment(argc, argv);
  return kedge::exit_code_of("kedge-replay", [&] { return run_program(environment, argc, argv); });
}
