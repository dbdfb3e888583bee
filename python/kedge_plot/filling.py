"""Triangles between the material points of a section, which fill the cracks between their boxes."""
import numpy as np
from matplotlib.tri import Triangulation

LONGEST = 1.  # edge over the sum of the diagonals of the boxes at its ends; a larger gap is a void


def triangles_between(lower, upper, outline):
    """Delaunay's triangles between the centres of boxes (n, 2), without those that span a void or cross a body's
    outline (segments, 2 ends, 2 coordinates). None if the centres span no area."""
    centre, diagonal = (lower + upper) / 2., np.linalg.norm(upper - lower, axis=1)
    try:
        triangulation = Triangulation(*centre.T)
    except (RuntimeError, ValueError):  # fewer than three points, or all on a line
        return None
    edges = triangulation.edges
    bad = np.linalg.norm(centre[edges[:, 0]] - centre[edges[:, 1]], axis=1) > LONGEST * diagonal[edges].sum(axis=1)
    bad[~bad] = _cross(centre[edges[~bad]], outline)
    keys = _keys(edges[bad], len(centre))
    corners = triangulation.triangles
    sides = np.stack([corners, np.roll(corners, -1, axis=1)], axis=-1)
    triangulation.set_mask(np.isin(_keys(sides, len(centre)), keys).any(axis=1))
    return triangulation


def _keys(edges, n):
    """One number per edge (..., 2), the same for both directions."""
    return edges.min(axis=-1).astype(np.int64) * n + edges.max(axis=-1)


def _cross(segments, others):
    """Whether each segment (n, 2, 2) crosses one of the others (m, 2, 2)."""
    crossed = np.zeros(len(segments), dtype=bool)
    for other in others:
        near = (segments.max(axis=1) >= other.min(axis=0)) & (segments.min(axis=1) <= other.max(axis=0))
        near = near.all(axis=1) & ~crossed
        a, b = segments[near, 0], segments[near, 1]
        crossed[near] = (_side(a, b, other[0]) != _side(a, b, other[1])) & (_side(*other, a) != _side(*other, b))
    return crossed


def _side(a, b, point):
    """Whether points lie left of the lines from a to b."""
    return (b[..., 0] - a[..., 0]) * (point[..., 1] - a[..., 1]) > (b[..., 1] - a[..., 1]) * (point[..., 0] - a[..., 0])
