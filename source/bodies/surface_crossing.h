// Crossings that end the making of a surface.
#pragma once

#include <kedge/bodies/surface.h>

namespace kedge
{
/// Two sides of a closed outline that touch, cross or overlap, if there are any; that neighbours share a corner does
/// not count. Side i runs from corner i to the next one. Exact.
std::optional<std::array<unsigned int, 2>> find_touching_sides(const std::vector<std::array<double, 2>>& outline);

/// As check_surface(), without the search for crossings and for shells inside others.
void check_connections(const TriangleMesh& mesh, const std::string& path, const std::string& name,
                       double resolution = 0.);
} // namespace kedge
