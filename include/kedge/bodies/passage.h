// Bodies do not touch each other. This tells where one passes through another.
#pragma once

#include <kedge/bodies/rigid_systems.h>
#include <utility>

namespace kedge
{
/// Watches surfaces of different systems. Those that overlap from the start are meant to.
class PassageWatch
{
public:
  PassageWatch(const RigidSystems& systems, unsigned int dim);

  /// Two surfaces, from 0, that were apart at the start and of which one has a vertex or the middle of a triangle
  /// inside the other one now. Those that cross without that are not seen.
  std::optional<std::pair<unsigned int, unsigned int>> find(const RigidSystems& systems) const;

private:
  unsigned int dim;
  std::vector<std::pair<unsigned int, unsigned int>> apart;
};
} // namespace kedge
