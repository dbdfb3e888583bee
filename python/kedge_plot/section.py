"""A plane section through the material points and the bodies."""
from dataclasses import dataclass

import numpy as np

from . import OptionError, PlotError
from .fields import evaluate

_LINE, _TRIANGLE, _QUAD, _HEXAHEDRON = 3, 5, 9, 12


@dataclass
class Backdrop:
    """Rectangles that the plane misses by less than their own width, the nearest last, and a value for each. Boxes keep
    their size where the soil stretches; the backdrop, drawn first, shows the soil in the cracks between two rows."""
    lower: np.ndarray
    upper: np.ndarray
    values: np.ndarray


@dataclass
class Section:
    """Rectangles (lower and upper corner in the two axes of the plane, m), a value for each, the bodies' outline as
    segments (n, 2 ends, 2 coordinates), and the cells of the mesh (n, lower and upper corner, 2 coordinates). is_flat:
    of a run in plane strain, all of which lies in the plane."""
    axes: str
    lower: np.ndarray
    upper: np.ndarray
    values: np.ndarray
    outline: np.ndarray
    cells: np.ndarray
    backdrop: Backdrop
    is_flat: bool = False

    def areas(self):
        """Area of each rectangle, m2."""
        return np.prod(self.upper - self.lower, axis=1)


def cut(grids, surface, plane, at, field, mesh=None):
    """Cuts boxes, surfaces and the mesh, if there is one, by the plane where the coordinate `plane` (x, y or z) has the
    value `at` (m)."""
    normal = "xyz".index(plane)
    kept = [i for i in range(3) if i != normal]
    is_flat = any((grid.types == _QUAD).any() for grid in grids)
    if is_flat and (plane != "y" or at != 0.):
        raise OptionError(f"the plane {plane} = {at:g} m: a run in plane strain lies in the plane y = 0 alone; leave "
                          "out --plane and --at")
    lower, upper, values, missed = [], [], [], []
    for grid in grids:
        boxes, value = box_bounds(grid), evaluate(grid.cell_data, field)
        value = np.where(np.isfinite(value), value, np.nan)  # some fields have no value everywhere
        hit = _crossing(boxes, normal, at)
        lower.append(boxes[0][hit][:, kept])
        upper.append(boxes[1][hit][:, kept])
        values.append(value[hit])
        away = np.maximum(boxes[0][:, normal] - at, at - boxes[1][:, normal])
        near = ~hit & (away < boxes[1][:, normal] - boxes[0][:, normal])
        missed.append((boxes[0][near][:, kept], boxes[1][near][:, kept], value[near], away[near]))
    lower, upper, values = map(np.concatenate, (lower, upper, values))
    *backdrop, away = map(np.concatenate, zip(*missed))
    order = np.argsort(-away, kind="stable")
    if len(values) == 0:
        extent = [box_bounds(grid) for grid in grids if len(grid.types)]
        between = (f"; the soil lies between {min(b[0][:, normal].min() for b in extent):.6g} and "
                   f"{max(b[1][:, normal].max() for b in extent):.6g} m") if extent else ""
        raise PlotError(f"the plane {plane} = {at:g} m meets no material point{between}")
    outline = np.empty((0, 2, 2)) if surface is None else _outline(surface, normal, at)[:, :, kept]
    cells = np.empty((0, 2, 2)) if mesh is None else _cells(mesh, normal, at)[:, :, kept]
    return Section("".join("xyz"[i] for i in kept), lower, upper, values, outline, cells,
                   Backdrop(*(array[order] for array in backdrop)), is_flat)


def _cells(mesh, normal, at):
    """Lower and upper corners (n, 2, 3) of the cells that the plane meets."""
    boxes = box_bounds(mesh)
    return np.stack(boxes, axis=1)[_crossing(boxes, normal, at)]


def box_bounds(grid):
    """Lower and upper corners (n, 3), m, of all cells, which are boxes (in plane strain rectangles)."""
    cells = grid.cells(_HEXAHEDRON)
    if cells.size == 0:
        cells = grid.cells(_QUAD)
    if len(cells) != len(grid.types):
        raise PlotError("the material points are not all boxes")
    corners = grid.points[cells] if cells.size else np.empty((0, 1, 3))
    return corners.min(axis=1), corners.max(axis=1)


def _crossing(boxes, normal, at):
    """Whether the plane meets each box. Of two boxes that touch in the plane, only the upper one counts."""
    low, high = boxes[0][:, normal], boxes[1][:, normal]
    if len(low) == 0:
        return np.zeros(0, dtype=bool)
    if (high == low).all():  # plane strain
        return abs(low - at) <= 1e-9
    # On a plane of symmetry, boxes start with a face in the plane and drift a little: look just inside them.
    tolerance = 0.25 * (high - low)
    above = (low <= at + tolerance) & (high > at + tolerance)
    return above if above.any() else (low < at) & (high >= at - tolerance)


def _outline(surface, normal, at):
    """Segments where triangles meet the plane; in plane strain the lines themselves."""
    lines, triangles = surface.cells(_LINE), surface.cells(_TRIANGLE)
    if triangles.size == 0:
        return surface.points[lines] if lines.size else np.empty((0, 2, 3))
    corners = surface.points[triangles]
    size = np.ptp(surface.points, axis=0).max()
    height = corners[:, :, normal] - at
    # A vertex in the plane counts as above it, so every triangle has two crossed sides or none.
    above = height >= -1e-12 * size
    corners, height, above = (array[above.any(axis=1) & ~above.all(axis=1)] for array in (corners, height, above))
    lone = np.where(above.sum(axis=1) == 1, above.argmax(axis=1), (~above).argmax(axis=1))
    rows = np.arange(len(lone))
    ends = []
    for other in ((lone + 1) % 3, (lone + 2) % 3):
        share = height[rows, lone] / (height[rows, lone] - height[rows, other])
        ends.append(corners[rows, lone] + share[:, None] * (corners[rows, other] - corners[rows, lone]))
    return np.stack(ends, axis=1)
