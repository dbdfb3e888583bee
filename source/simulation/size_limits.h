// Scenes that no memory holds are refused before anything is made of them.
#pragma once

#include <kedge/simulation/input.h>
#include <mpi.h>
#include <string>

namespace kedge
{
/// What a scene needs at least, counted in double precision, which does not overflow.
struct LeastSize
{
  double cells = 0.;     ///< of base size, in the whole grid
  double particles = 0.; ///< as the run begins
  double bytes = 0.;
};

LeastSize least_size(const Input& input);

/// Throws InputError where a scene needs more than the memory (bytes) of a place, which the message names, or cells
/// smaller than a tree of the octree holds.
void refuse_excessive_size(const Input& input, double memory, const std::string& place);

/// Of this machine, bytes.
double memory_of_machine();
/// Of all machines that the ranks run on, bytes. Collective.
double memory_of_machines(MPI_Comm communicator);
} // namespace kedge
