#pragma once

#include <memory>

namespace kedge
{
/// Starts MPI, Tpetra and Kokkos for the lifetime of the object and ends them in the right order.
/// Exactly one may exist, in main().
class Environment
{
public:
  Environment(int& argc, char**& argv);
  ~Environment();
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

  /// Rank of this process in MPI_COMM_WORLD.
  int rank() const;
  /// Number of processes in MPI_COMM_WORLD.
  int size() const;

private:
  struct Scopes;
  std::unique_ptr<Scopes> scopes;
};
} // namespace kedge
