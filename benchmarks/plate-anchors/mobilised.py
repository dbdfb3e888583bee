"""Areas of soil that a plate moves with it, in sections of the half model."""
import functools

import numpy as np
from kedge_plot.section import cut
from kedge_runs import RunError
from matplotlib.tri import LinearTriInterpolator, Triangulation

MOVED = 0.1  # soil that moves by more than this share of the plate's displacement counts as mobilised
PIXEL = 0.001  # m, of the raster that counts areas


def horizontal_front(run, values):
    """Area in the horizontal section through the axis, in front of the plate's back face, m2."""
    return _areas(run, "z", values["height"], values["back"])[0]


def horizontal_back(run, values):
    """The same behind the back face, m2."""
    return _areas(run, "z", values["height"], values["back"])[1]


def vertical_front(run, values):
    """Area in the plane of symmetry in front of the plate's back face, m2."""
    return _areas(run, "y", 0., values["back"])[0]


def vertical_back(run, values):
    """The same behind the back face, m2."""
    return _areas(run, "y", 0., values["back"])[1]


@functools.lru_cache(maxsize=4)
def _areas(run, plane, at, back):
    """Areas (m2) of mobilised soil in a section, in front of and behind the plate's back face, which began at x = back.
    They include the plate and gaps in the soil."""
    if not run.is_finished:
        raise RunError(f"{run.folder}: has not finished")
    travel = run.body("body1_position_x")[-1] - run.start_of(1)[0]
    grids, step = run.soil()
    section = cut(grids, run.surface(step), plane, at, "displacement magnitude")
    centre = (section.lower + section.upper) / 2.
    between = LinearTriInterpolator(Triangulation(*centre.T), section.values)
    low, high = section.lower.min(axis=0), section.upper.max(axis=0)
    x, y = (np.arange(low[i] + PIXEL / 2., high[i], PIXEL) for i in (0, 1))
    grid = np.meshgrid(x, y)
    # pixels beyond the outermost centres take the value of the nearest place between them
    inside = [np.clip(grid[i], centre[:, i].min() + 1e-6, centre[:, i].max() - 1e-6) for i in (0, 1)]
    moved = between(*inside).filled(0.) > MOVED * travel
    front = grid[0] > back + travel
    return [PIXEL**2 * np.count_nonzero(moved & side) for side in (front, ~front)]
