#pragma once

#include <string>

namespace kedge
{
/// Version of this program.
std::string version();
/// The last commit that touched what the program is built from, "unknown" outside a checkout. With uncommitted changes
/// "-modified-" and a hash of them follow. cmake/commit.cmake writes this function.
std::string commit();
/// Kokkos' name of the back end that kernels run on.
std::string back_end();
/// All three and the libraries under them, one per line.
std::string describe_versions();
} // namespace kedge
