// The moving window: planes between base cells that follow the bodies and bound the active soil.
#pragma once

#include <kedge/mesh/grid_layout.h>
#include <kedge/mesh/parameters.h>

namespace kedge
{
/// Axis-aligned bounds of the bodies, m.
template <int dim> struct Extent
{
  std::array<double, dim> lower, upper;
};

/// The base cells from number lower[axis] up to, not including, upper[axis] along every axis.
template <int dim> struct Window
{
  std::array<unsigned int, dim> lower{}, upper{};

  bool operator==(const Window& other) const { return lower == other.lower && upper == other.upper; }
};

/// Places the planes around the bodies: at the track's distances from their extent, rounded outward to base cells. If a
/// plane is off or would lie beyond the grid, the face of the grid takes its place.
template <int dim>
Window<dim> place_window(const BoundaryTrack& track, const Extent<dim>& bodies, const GridLayout<dim>& grid);

/// Moves each plane to its position from place_window if its "advance" allows this direction; otherwise it stays.
/// Planes that would meet stay, too.
template <int dim>
Window<dim> advance_window(const Window<dim>& window, const BoundaryTrack& track, const Extent<dim>& bodies,
                           const GridLayout<dim>& grid);

/// Whether a point (m) lies behind a plane that removes soil.
template <int dim>
bool is_left_behind(const std::array<double, dim>& x, const Window<dim>& window, const BoundaryTrack& track,
                    const GridLayout<dim>& grid);

/// Whether the bodies reach beyond a plane inside the grid, into soil that is not active.
template <int dim> bool reach_beyond(const Window<dim>& window, const Extent<dim>& bodies, const GridLayout<dim>& grid);
} // namespace kedge
