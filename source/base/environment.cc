#include <kedge/base/environment.h>

#include <Tpetra_Core.hpp>
#include <mpi.h>

namespace kedge
{
namespace
{
// deal.II reaches into p4est, which wants MPI only; MPI must outlive Tpetra, hence a scope of its own.
struct MpiScope
{
  MpiScope(int& argc, char**& argv) { MPI_Init(&argc, &argv); }
  ~MpiScope() { MPI_Finalize(); }
};
} // namespace

struct Environment::Scopes
{
  Scopes(int& argc, char**& argv) : mpi(argc, argv), tpetra(&argc, &argv) {}
  MpiScope mpi;
  Tpetra::ScopeGuard tpetra;
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
