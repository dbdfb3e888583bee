"""Values between material points."""
import numpy as np
from scipy.spatial import cKDTree

from .filling import crossing

_NEAREST = 16  # points whose boxes may reach the edge of a box: twelve smaller ones around it, and more
_FITTED = 12  # points through which a linear field is fitted


def edge_places(lower, upper):
    """Corners and middles of the sides of boxes, (n, 8, 2), counter-clockwise from the lower corner."""
    corners = rectangle_corners(lower, upper)
    middles = (corners + np.roll(corners, -1, axis=1)) / 2.
    return np.stack([corners, middles], axis=2).reshape(-1, 8, 2)


def edge_values(lower, upper, values, outline):
    """Values at the places of edge_places, (n, 8). Each is the mean of the values of the boxes around it, weighted by
    hats twice as wide as these boxes; on a regular grid this is bilinear interpolation. A box beyond a gap wider than
    half a box, or beyond a body's outline, does not count.

    lower, upper: corners of the boxes (n, 2), m. outline: segments (m, 2 ends, 2 coordinates), m.
    """
    places = edge_places(lower, upper)
    centre, width = (lower + upper) / 2., upper - lower
    own = np.arange(len(centre))[:, None, None]
    near = cKDTree(centre).query(places, min(_NEAREST, len(centre)))[1].reshape(len(centre), 8, -1)
    weights = _hats(places[:, :, None], centre[near], width[near])
    weights[near == own] = 0.
    reached = weights > 0.
    ends = np.broadcast_to(places[:, :, None], (*near.shape, 2))[reached]
    weights[reached] *= ~crossing(np.stack([ends, centre[near][reached]], axis=1), outline)
    own_weight = _hats(places, centre[:, None], width[:, None])  # counts even where the outline crosses the box
    return ((weights * values[near]).sum(axis=2) + own_weight * values[:, None]) / (weights.sum(axis=2) + own_weight)


def _hats(places, centre, width):
    """Hats of height 1 over the centres of boxes, 0 at the distance of a width."""
    return np.prod(np.maximum(1. - abs(places - centre) / width, 0.), axis=-1)


def rectangle_corners(low, high):
    """Four corners of each rectangle, shape (n, 4, 2), counter-clockwise from the lower one."""
    return np.stack([low, np.column_stack([high[:, 0], low[:, 1]]), high, np.column_stack([low[:, 0], high[:, 1]])],
                    axis=1)


def interpolate(places, points, values):
    """Values at places (m, d) of a field known at points (n, d): the linear field through the nearest points that fits
    best, the nearer the better. It is exact at the points themselves and for linear fields, beyond the outermost
    points, too. values: (n, c); returns (m, c)."""
    distance, near = cKDTree(points).query(places, min(_FITTED, len(points)))
    distance, near = distance.reshape(len(places), -1), near.reshape(len(places), -1)
    reach = np.maximum(distance[:, -1:], np.finfo(float).tiny)
    weights = 1. / ((distance / reach)**2 + 1e-10)
    offset = (points[near] - places[:, None]) / reach[:, :, None]
    base = np.concatenate([np.ones((*near.shape, 1)), offset], axis=2)
    weighted = (base * weights[:, :, None]).transpose(0, 2, 1)
    matrix = weighted @ base
    # Points in a plane or on a line say nothing about the slope across it: let it be small.
    slopes = np.arange(1, base.shape[2])
    matrix[:, slopes, slopes] += 1e-9 * np.trace(matrix[:, 1:, 1:], axis1=1, axis2=2)[:, None] + 1e-12
    # Only differences from the nearest value: round-off stays relative to them.
    nearest = values[near[:, 0]]
    return nearest + np.linalg.solve(matrix, weighted @ (values[near] - nearest[:, None]))[:, 0]
