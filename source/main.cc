#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <kedge/base/environment.h>
#include <kedge/base/exceptions.h>
#include <kedge/simulation/simulation.h>

int main(int argc, char** argv)
{
  kedge::Environment environment(argc, argv);
  kedge::RunOptions options;
  options.input_file = argv[1];
  try {
  const kedge::Input input = kedge::read_input(options.input_file);
  kedge::run_simulation(input, options);
  } catch (const std::exception& e) { fmt::print(stderr, "{}\n", e.what()); return 2; }
}
