#include <cstdlib>
#include <kedge/base/kokkos.h>
#include <string>

namespace kedge
{
bool mirrors_apart()
{
  static const bool apart = []
  {
    const char* const asked = std::getenv("KEDGE_MIRRORS_APART");
    return asked != nullptr && std::string(asked) == "1";
  }();
  return apart;
}
} // namespace kedge
