#include <kedge/base/environment.h>

#include <Tpetra_Core.hpp>
#include <csignal>
#include <kedge/base/failure.h>
#include <kedge/base/kokkos.h>
#include <mpi.h>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace kedge
{
namespace
{
/// MPI must be finalised after Tpetra, hence a scope of its own.
struct MpiScope
{
  MpiScope(int& argc, char**& argv)
  {
    MPI_Init(&argc, &argv);
    open_failure_channel();
    std::signal(SIGXFSZ, SIG_IGN); // a file beyond the limit of its size is an error of that file
  }
  ~MpiScope()
  {
    close_failure_channel();
    MPI_Finalize();
  }
};

/// The options --kokkos... alone: Kokkos would also take others, such as --help.
struct KokkosArguments
{
  KokkosArguments(int argc, char** argv) : values{argv[0]}
  {
    for (int i = 1; i < argc; ++i)
      if (std::string(argv[i]).rfind("--kokkos", 0) == 0)
        values.push_back(argv[i]);
    count = static_cast<int>(values.size());
    values.push_back(nullptr);
    first = values.data();
  }
  std::vector<char*> values;
  int count;
  char** first;
};

} // namespace

struct Environment::Scopes
{
  Scopes(int& argc, char**& argv) : mpi(argc, argv), kokkos(argc, argv)
  {
    try
    {
      tpetra.emplace(&kokkos.count, &kokkos.first);
    }
    catch (const std::runtime_error& error)
    {
      if (device_is_host)
        throw;
      const std::string reason = error.what(); // its first line; a trace of calls follows
      abort_all_ranks(
          {bad_input, "",
           "no GPU can be used here, but this build computes on one: " + reason.substr(0, reason.find('\n'))});
    }
  }
  MpiScope mpi;
  KokkosArguments kokkos;
  std::optional<Tpetra::ScopeGuard> tpetra;
};

Environment::Environment(int& argc, char**& argv) : scopes(std::make_unique<Scopes>(argc, argv)) {}
Environment::~Environment() = default;

int Environment::rank() const
{
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  return rank;
}

int Environment::size() const
{
  int size = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  return size;
}
} // namespace kedge
