#pragma once

#include <string>

namespace kedge
{
/// Version of this program.
std::string version();
/// Kokkos' name of the back end that kernels run on.
std::string back_end();
/// Both and the libraries under them, one per line.
std::string describe_versions();
} // namespace kedge
