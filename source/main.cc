// The command line: reads arguments, calls one function per subcommand and turns errors into exit codes.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <kedge/base/environment.h>
#include <kedge/base/exceptions.h>
#include <kedge/base/failure.h>
#include <kedge/geometry/command.h>
#include <kedge/simulation/check.h>
#include <kedge/simulation/simulation.h>
#include <kedge/simulation/version.h>

namespace
{
using kedge::ExitCode;

/// For words_for_cli() only.
constexpr const char* restart_auto = "--restart-auto";

/// Whether all of it was written is seen at the end.
void print(const std::string& text) { std::fputs(text.c_str(), stdout); }

struct Arguments
{
  std::string file, output;
  std::vector<std::string> overrides;
  bool cpu = false, quiet = false, verbose = false, json = false, restarts = false, restarts_if_possible = false;
  kedge::SystemToDump dumped;
};

/// `dumps`: up to the step whose linear system is to be written.
ExitCode run(const Arguments& arguments, const bool dumps)
{
  std::signal(SIGPIPE, SIG_IGN); // a run goes on when nobody reads its progress any more
  kedge::Input input;
  kedge::agree(MPI_COMM_WORLD,
               [&]
               {
                 input = kedge::read_input(arguments.file, arguments.overrides);
                 kedge::refuse_unavailable_features(input);
               });
  if (arguments.cpu)
    input.gpu = false;
  kedge::RunOptions options;
  options.input_file = arguments.file;
  options.output_directory = arguments.output.empty()
                                 ? std::filesystem::path(arguments.file).stem().string() + (dumps ? "-dump" : "-output")
                                 : arguments.output;
  options.quiet = arguments.quiet;
  options.verbose = arguments.verbose;
  options.restart = arguments.restarts_if_possible ? kedge::Restart::automatic
                    : arguments.restarts           ? kedge::Restart::yes
                                                   : kedge::Restart::no;
  if (dumps)
    options.dumps = arguments.dumped;
  return kedge::run_simulation(input, options);
}

void check(const Arguments& arguments)
{
  const kedge::Input input = kedge::read_input(arguments.file, arguments.overrides);
  kedge::refuse_unavailable_features(input);
  const kedge::CheckResult result = kedge::check_scene(input);
  print(arguments.json ? kedge::check_as_json(input, result) : kedge::format_check(input, result, arguments.file));
}

void add_file_arguments(CLI::App& command, Arguments& arguments)
{
  command.add_option("FILE", arguments.file, "Input file (JSON)")->required();
  command
      .add_option("--set", arguments.overrides,
                  "Replace a value of the input: \"path=value\", array positions from 0, "
                  "for example --set \"analysis.1.load steps=40\"")
      ->expected(1)
      ->take_all();
}

void add_run_arguments(CLI::App& command, Arguments& arguments, const std::string& folder)
{
  command.add_option("-o,--output", arguments.output, "Folder for all output " + folder);
  command.add_flag("--cpu", arguments.cpu, "Take \"GPU\" in the input for \"off\"");
  command.add_flag("-q,--quiet", arguments.quiet, "Print warnings and errors only");
  command.add_flag("-v,--verbose", arguments.verbose, "Print the residuals of Newton's iterations of every step")
      ->excludes("--quiet");
  command.add_flag("--restart", arguments.restarts,
                   "Continue from the newest sound restart file in the output folder; \"--restart auto\": where there "
                   "is one, else begin anew");
  command.add_flag(restart_auto, arguments.restarts_if_possible)->group(""); // not in the help
}

/// The words for CLI11, in reverse, as it reads a list: without the options that Kokkos reads, and with "--restart
/// auto" as one flag, since CLI11 would take "auto" for the input file.
std::vector<std::string> words_for_cli(const std::vector<std::string>& words)
{
  std::vector<std::string> kept;
  for (const std::string& word : words)
    if (word == "auto" && !kept.empty() && kept.back() == "--restart")
      kept.back() = restart_auto;
    else if (word == "--restart=auto")
      kept.push_back(restart_auto);
    else if (word.rfind("--kokkos-", 0) != 0)
      kept.push_back(word);
  std::reverse(kept.begin(), kept.end());
  return kept;
}

int run_program(kedge::Environment& environment, int argc, char** argv)
{
  CLI::App app("Kedge: the material point method for anchors, plates, cones and ploughs in soil");
  app.name("kedge");
  app.require_subcommand(0, 1); // CLI11 names a word that is none only where it does not miss one
  app.set_version_flag("--version", kedge::describe_versions());
  app.footer(
      "Under MPI: mpirun -n 2 kedge run FILE.json\n"
      "Options that begin with --kokkos- go to Kokkos: --kokkos-print-configuration\n"
      "Exit codes: 0 done, 2 wrong input, 3 the equations could not be solved,\n"
      "            4 results could not be written or a restart file not be read,\n"
      "            1 too little memory or a mistake in the program,\n"
      "            143 ended by SIGTERM, SIGUSR1 or SIGHUP, 130 by SIGINT (Ctrl-C), after a restart file was written");

  Arguments arguments;
  CLI::App& run_command = *app.add_subcommand("run", "Run an input file");
  add_file_arguments(run_command, arguments);
  add_run_arguments(run_command, arguments, "[<stem of FILE>-output]");
  ExitCode code = kedge::success;
  run_command.final_callback([&] { code = run(arguments, false); });

  CLI::App& dump_command = *app.add_subcommand(
      "dump-step", "Run an input file up to a step and write a linear system of it for kedge-replay");
  add_file_arguments(dump_command, arguments);
  add_run_arguments(dump_command, arguments, "[<stem of FILE>-dump]");
  dump_command.add_option("--to", arguments.dumped.path, "File for the system (safetensors)")->required();
  dump_command.add_option("--step", arguments.dumped.step, "Number of the step, as in the progress line [the first]");
  dump_command.add_option("--iteration", arguments.dumped.iteration, "Iteration of Newton's method in it [1]")
      ->check(CLI::PositiveNumber);
  dump_command.final_callback([&] { code = run(arguments, true); });

  CLI::App& check_command = *app.add_subcommand("check", "Validate an input file and estimate the cost of its run");
  add_file_arguments(check_command, arguments);
  check_command.add_flag("--json", arguments.json, "Print the effective input, warnings and cost as one JSON object");
  check_command.final_callback(
      [&]
      {
        kedge::agree(MPI_COMM_WORLD,
                     [&]
                     {
                       if (environment.rank() == 0)
                         check(arguments);
                     });
      });

  CLI::App& schema_command = *app.add_subcommand("schema", "Print the JSON Schema of the input, or its manual");
  bool manual = false;
  schema_command.add_flag("--manual", manual, "Print the parameter reference in Markdown instead");
  schema_command.final_callback([&] { print(manual ? kedge::input_manual() : kedge::input_schema() + "\n"); });

  kedge::add_geometry_command(app);
  try
  {
    app.parse(words_for_cli({argv + 1, argv + argc}));
    if (app.get_subcommands().empty())
      throw CLI::RequiredError::Subcommand(1);
  }
  catch (const CLI::ParseError& error)
  {
    if (app.exit(error) != 0)
      return kedge::bad_input;
  }
  const bool runs = run_command.parsed() || dump_command.parsed(); // whose results are in files
  if ((std::fflush(stdout) != 0 || std::ferror(stdout) != 0) && !runs)
    throw kedge::FileError("standard output", "cannot be written; see whether the disk is full");
  return code;
}

/// For SIGUSR1 while no run listens to it, with the exit code that job scripts look for.
void end_at_once(int) { std::_Exit(kedge::told_to_end); }
} // namespace

int main(int argc, char** argv)
{
  if (std::signal(SIGUSR1, end_at_once) == SIG_IGN)
    std::signal(SIGUSR1, SIG_IGN);
  kedge::Environment environment(argc, argv);
  return kedge::exit_code_of("kedge", [&] { return run_program(environment, argc, argv); });
}
