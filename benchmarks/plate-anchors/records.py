"""The record of a run: its curve, its size and cost, and how much soil moved."""
import json

import numpy as np
from cases import BASE_AT
from kedge_plot.resistance import resistance_curve
from kedge_plot.section import cut
from kedge_runs import RunError
from kedge_runs.run import Run
from matplotlib.tri import LinearTriInterpolator, Triangulation

LAST = 0.01  # m: mean resistances cover this last part of a distance
MOVED = 0.1  # soil that moves by more than this share of the plate's displacement counts as mobilised
PIXEL = 0.001  # m, of the raster that counts areas
COUNTS = ("cells", "dofs", "material points", "time steps", "cuts", "deepest penetration")


def of_run(case, work):
    """The run of a case and its record; both None where the run has not finished."""
    try:
        run = Run(work / case.name)
        if not run.is_finished:
            return None, None
        curve = resistance_curve(run.bodies(), axis="x", factor=2., start=run.start_of(1))
    except RunError:
        return None, None
    summary, stage = run.summary, run.stages[-1]
    record = {"displacement": [round(d, 7) for d in curve.displacement],
              "force": [float(f"{f:.5g}") for f in curve.force],
              **{name: stage[name] for name in COUNTS}, "wall time": round(summary["wall time"]["total"], 1),
              "peak memory": summary["peak memory"], "ranks": summary["ranks"]}
    travel = curve.displacement.max()
    record["mobilised"] = {"horizontal": mobilised(run, "z", case.height, travel),
                           "vertical": mobilised(run, "y", 0., travel)}
    return run, record


def as_text(record):
    return json.dumps(record, indent=1, separators=(",", ": ")).replace(",\n  ", ", ") + "\n"


def mobilised(run, plane, at, travel):
    """Areas (m2) of mobilised soil in a section of the half model, in front of and behind the plate's back face. They
    include the plate and gaps in the soil. travel: displacement of the plate, m."""
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
    front = grid[0] > BASE_AT + travel
    return [float(f"{PIXEL**2 * np.count_nonzero(moved & side):.4g}") for side in (front, ~front)]


def mean_between(displacement, values, low, high=np.inf):
    """Mean of the values at displacements above `low` and up to `high`, m."""
    return np.mean(values[(displacement > low) & (displacement <= high + 1e-9)])
