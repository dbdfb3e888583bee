// Plane strain is in the plane y = 0 of the world, where bodies live.
#pragma once

namespace kedge
{
/// World axis of a component along axis `component` of the analysis.
constexpr unsigned int world_axis(const unsigned int dim, const unsigned int component)
{
  return dim == 2 && component == 1 ? 2 : component;
}
} // namespace kedge
