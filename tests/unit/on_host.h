#pragma once

#include <kedge/base/kokkos.h>

namespace kedge::test
{
/// What a view on the device holds, for tests to look at.
template <typename DeviceView> auto on_host(const DeviceView& view) { return copy_to_host(view); }
} // namespace kedge::test
