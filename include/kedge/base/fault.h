// Faults on purpose, for tests: KEDGE_FAULT="rank=1,step=2,phase=linear solver,kind=solver" throws there.
#pragma once

#include <optional>
#include <string>

namespace kedge
{
struct PlannedFault
{
  enum class Kind
  {
    input,
    solver,
    file,
    bad_alloc,
    logic, ///< a mistake in the program
    kill   ///< the process dies
  };
  unsigned int step = 0; ///< as files and the terminal count them: 2 is the first one, 1 what comes before
  std::string phase;     ///< as timings name it, or a place within one
  Kind kind = Kind::solver;
  unsigned int step_now = 1;

  void strike_at(const char* place) const;
};

/// What KEDGE_FAULT plans for this rank: nothing where it is not set or names another rank; without a rank it is meant
/// for all. Throws InputError where it cannot be understood.
std::optional<PlannedFault> planned_fault(const char* text, int rank);
} // namespace kedge
