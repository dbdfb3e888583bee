#include <algorithm>
#include <cmath>
#include <kedge/mesh/window.h>

namespace kedge
{
namespace
{
/// Tolerance in base cells: a body may be built to rest against the face of a cell and must not count as crossing it.
constexpr double slack = 1e-9;

unsigned int move_plane(const unsigned int from, const unsigned int to, const Advance advance)
{
  return advance == Advance::both || (advance == Advance::positive ? to > from : to < from) ? to : from;
}
} // namespace

template <int dim>
Window<dim> place_window(const BoundaryTrack& track, const Extent<dim>& bodies, const GridLayout<dim>& grid)
{
  Window<dim> window;
  for (unsigned int axis = 0; axis < dim; ++axis)
  {
    const TrackPlane &min = track.min[axis], &max = track.max[axis];
    const double n = grid.base_cells[axis];
    const double lower = std::floor((bodies.lower[axis] - min.distance) / grid.base_size + slack);
    const double upper = std::ceil((bodies.upper[axis] + max.distance) / grid.base_size - slack);
    window.lower[axis] = min.type ? static_cast<unsigned int>(std::clamp(lower, 0., n - 1.)) : 0;
    window.upper[axis] = max.type ? static_cast<unsigned int>(std::clamp(upper, 1., n)) : grid.base_cells[axis];
  }
  return window;
}

template <int dim>
Window<dim> advance_window(const Window<dim>& window, const BoundaryTrack& track, const Extent<dim>& bodies,
                           const GridLayout<dim>& grid)
{
  const Window<dim> placed = place_window<dim>(track, bodies, grid);
  Window<dim> advanced = window;
  for (unsigned int axis = 0; axis < dim; ++axis)
  {
    const unsigned int lower = move_plane(window.lower[axis], placed.lower[axis], track.min[axis].advance);
    const unsigned int upper = move_plane(window.upper[axis], placed.upper[axis], track.max[axis].advance);
    if (lower >= upper)
      continue;
    advanced.lower[axis] = lower;
    advanced.upper[axis] = upper;
  }
  return advanced;
}

template <int dim>
bool is_left_behind(const std::array<double, dim>& x, const Window<dim>& window, const BoundaryTrack& track,
                    const GridLayout<dim>& grid)
{
  for (unsigned int axis = 0; axis < dim; ++axis)
  {
    const auto removes = [&](const TrackPlane& plane) { return plane.type && plane.remove; };
    if ((removes(track.min[axis]) && x[axis] < grid.base_size * window.lower[axis]) ||
        (removes(track.max[axis]) && x[axis] > grid.base_size * window.upper[axis]))
      return true;
  }
  return false;
}

template <int dim> bool reach_beyond(const Window<dim>& window, const Extent<dim>& bodies, const GridLayout<dim>& grid)
{
  for (unsigned int axis = 0; axis < dim; ++axis)
    if ((window.lower[axis] > 0 && bodies.lower[axis] < grid.base_size * (window.lower[axis] - slack)) ||
        (window.upper[axis] < grid.base_cells[axis] &&
         bodies.upper[axis] > grid.base_size * (window.upper[axis] + slack)))
      return true;
  return false;
}

template Window<2> place_window<2>(const BoundaryTrack&, const Extent<2>&, const GridLayout<2>&);
template Window<3> place_window<3>(const BoundaryTrack&, const Extent<3>&, const GridLayout<3>&);
template Window<2> advance_window<2>(const Window<2>&, const BoundaryTrack&, const Extent<2>&, const GridLayout<2>&);
template Window<3> advance_window<3>(const Window<3>&, const BoundaryTrack&, const Extent<3>&, const GridLayout<3>&);
template bool is_left_behind<2>(const std::array<double, 2>&, const Window<2>&, const BoundaryTrack&,
                                const GridLayout<2>&);
template bool is_left_behind<3>(const std::array<double, 3>&, const Window<3>&, const BoundaryTrack&,
                                const GridLayout<3>&);
template bool reach_beyond<2>(const Window<2>&, const Extent<2>&, const GridLayout<2>&);
template bool reach_beyond<3>(const Window<3>&, const Extent<3>&, const GridLayout<3>&);
} // namespace kedge
