"""Triangles between the material points of a section, which fill the cracks between their boxes."""
import numpy as np
from matplotlib.tri import Triangulation
from scipy.spatial import cKDTree

WIDEST = 0.9  # gap between two boxes over their mean width; a wider gap is a void


def triangles_between(lower, upper, outline):
    """Delaunay's triangles between the centres of boxes (n, 2), without those that span a void or cross a body's
    outline (segments, 2 ends, 2 coordinates). None if the centres span no area."""
    centre, width = (lower + upper) / 2., upper - lower
    try:
        triangulation = Triangulation(*centre.T)
    except (RuntimeError, ValueError):  # fewer than three points, or all on a line
        return None
    edges = triangulation.edges
    distance, touching = abs(centre[edges[:, 0]] - centre[edges[:, 1]]), width[edges].mean(axis=1)
    bad = (distance > (1. + WIDEST) * touching).any(axis=1)
    bad[~bad] = crossing(centre[edges[~bad]], outline)
    keys = _keys(edges[bad], len(centre))
    corners = triangulation.triangles
    sides = np.stack([corners, np.roll(corners, -1, axis=1)], axis=-1)
    triangulation.set_mask(np.isin(_keys(sides, len(centre)), keys).any(axis=1))
    return triangulation


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
