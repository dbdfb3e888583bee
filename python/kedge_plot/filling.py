"""Triangles between the material points of a section, which fill the cracks between their boxes."""
import numpy as np
from matplotlib.tri import Triangulation
from scipy.spatial import cKDTree

LARGEST = 1.25  # radius of a triangle's circumcircle over the mean width of the boxes at its corners: beyond it, a void


def triangles_between(lower, upper, outline):
    """Delaunay's triangles between the centres of boxes (n, 2), without those that span a void or cross a body's
    outline (segments, 2 ends, 2 coordinates). None if the centres span no area.

    Voids are told from cracks as in alpha shapes (Edelsbrunner, Kirkpatrick & Seidel 1983, IEEE Trans. Inf. Theory 29):
    a circle that fits between the points and is larger than the boxes is empty. A missing box is a crack, four are not.
    """
    centre, width = (lower + upper) / 2., np.sqrt(np.prod(upper - lower, axis=1))
    try:
        triangulation = Triangulation(*centre.T)
    except (RuntimeError, ValueError):  # fewer than three points, or all on a line
        return None
    corners, edges = triangulation.triangles, triangulation.edges
    keys = _keys(edges[crossing(centre[edges], outline)], len(centre))
    sides = np.stack([corners, np.roll(corners, -1, axis=1)], axis=-1)
    triangulation.set_mask(np.isin(_keys(sides, len(centre)), keys).any(axis=1)
                           | (_circumradius(centre[corners]) > LARGEST * width[corners].mean(axis=1)))
    return triangulation


def _circumradius(triangles):
    """Radii of the circles through the corners of triangles (n, 3, 2); infinite for corners on a line."""
    sides = triangles - np.roll(triangles, 1, axis=1)
    twice_area = abs(np.linalg.det(sides[:, :2]))
    with np.errstate(divide="ignore", invalid="ignore"):
        radius = np.prod(np.linalg.norm(sides, axis=2), axis=1) / (2. * twice_area)
    return np.where(twice_area > 0., radius, np.inf)


def _keys(edges, n):
    """One number per edge (..., 2), the same for both directions."""
    return edges.min(axis=-1).astype(np.int64) * n + edges.max(axis=-1)


def crossing(segments, others):
    """Whether each segment (n, 2, 2) crosses one of the others (m, 2, 2)."""
    crossed = np.zeros(len(segments), dtype=bool)
    if len(segments) == 0 or len(others) == 0:
        return crossed
    half, longest = (np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1) / 2. for lines in (segments, others))
    distance, _ = cKDTree(others.mean(axis=1)).query(segments.mean(axis=1))
    candidates = np.flatnonzero(distance <= half + longest.max())
    crossed[candidates] = _crossing_nearby(segments[candidates], others)
    return crossed


def _crossing_nearby(segments, others):
    crossed = np.zeros(len(segments), dtype=bool)
    low, high = segments.min(axis=1), segments.max(axis=1)
    for other in others:
        near = (high >= other.min(axis=0)) & (low <= other.max(axis=0))
        near = near.all(axis=1) & ~crossed
        a, b = segments[near, 0], segments[near, 1]
        crossed[near] = (_side(a, b, other[0]) != _side(a, b, other[1])) & (_side(*other, a) != _side(*other, b))
    return crossed


def _side(a, b, point):
    """Whether points lie left of the lines from a to b."""
    return (b[..., 0] - a[..., 0]) * (point[..., 1] - a[..., 1]) > (b[..., 1] - a[..., 1]) * (point[..., 0] - a[..., 0])
