// Checks or runs input files, each in a process of its own that is forked after MPI and Kokkos have started, which
// takes most of the time of a short check. For the script fuzz beside it.
#include <fmt/format.h>
#include <iostream>
#include <kedge/base/environment.h>
#include <kedge/base/failure.h>
#include <kedge/simulation/check.h>
#include <kedge/simulation/simulation.h>
#include <string>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace
{
int execute(const std::string& task, const std::string& file, const std::string& folder)
{
  try
  {
    const kedge::Input input = kedge::read_input(file);
    kedge::refuse_unavailable_features(input);
    if (task == "check")
    {
      fmt::print("{}", kedge::check_as_json(input, kedge::check_scene(input)));
      return std::fflush(stdout) == 0 ? kedge::success : kedge::file_failure;
    }
    kedge::RunOptions options;
    options.input_file = file;
    options.output_directory = folder;
    options.quiet = true;
    return kedge::run_simulation(input, options);
  }
  catch (...)
  {
    const kedge::Failure failure = kedge::current_failure();
    fmt::print(stderr, "kedge: {}\n", failure.message);
    return failure.code;
  }
}
} // namespace

/// Reads lines "check FILE FOLDER" or "run FILE FOLDER"; writes the process number of each. What the process prints
/// goes to FOLDER/out and FOLDER/err. When it has ended: its exit status as wait4() gives it, its CPU time (s) and its
/// largest memory (KiB).
int main(int argc, char** argv)
{
  kedge::Environment environment(argc, argv);
  std::string task, file, folder;
  while (std::cin >> task >> file >> folder)
  {
    const pid_t child = fork();
    if (child == 0)
    {
      const bool has_files = std::freopen((folder + "/out").c_str(), "w", stdout) != nullptr &&
                             std::freopen((folder + "/err").c_str(), "w", stderr) != nullptr;
      const int code = has_files ? execute(task, file, folder + "/output") : kedge::file_failure;
      std::fflush(stdout);
      std::fflush(stderr);
      _exit(code);
    }
    std::cout << child << std::endl;
    int status = 0;
    rusage usage = {};
    wait4(child, &status, 0, &usage);
    std::cout << status << ' ' << usage.ru_utime.tv_sec + 1e-6 * usage.ru_utime.tv_usec << ' ' << usage.ru_maxrss
              << std::endl;
  }
}
