"""What is kept of a run: its curve, its size and cost, and how much soil moved."""
import json

import numpy as np
from cases import BASE_AT
from kedge_plot.resistance import resistance_curve
from kedge_plot.section import cut
from kedge_runs import RunError
from kedge_runs.run import Run
from matplotlib.tri import LinearTriInterpolator, Triangulation

LAST = 0.01  # m of a way, that mean resistances are taken over
MOVED = 0.1  # of the plate's own displacement: what counts as mobilised soil
PIXEL = 0.001  # m, of the raster that areas are counted on
COUNTS = ("cells", "dofs", "material points", "time steps", "cuts", "deepest penetration")


def of_run(case, work):
    """The run of a case and its record; None for both where it has not come to its end."""
    try:
        run = Run(work / case.name)
        if not run.is_finished:
            return None, None
        curve = resistance_curve(run.bodies(), axis="x", factor=2., start=run.start_of(1))
    except RunError:
        return None, None
    summary, stage = run.summary, run.stages[-1]
    record = {"displacement": [round(d, 7) for d in curve.displacement], "force": [float(f"{f:.5g}") for f in curve.force],
              **{name: stage[name] for name in COUNTS}, "wall time": round(summary["wall time"]["total"], 1),
              "peak memory": summary["peak memory"], "ranks": summary["ranks"]}
    way = curve.displacement.max()
    record["mobilised"] = {"horizontal": mobilised(run, "z", case.height, way), "vertical": mobilised(run, "y", 0., way)}
    return run, record


def as_text(record):
    return json.dumps(record, indent=1, separators=(",", ": ")).replace(",\n  ", ", ") + "\n"


def mobilised(run, plane, at, way):
    """Areas (m2) inside the line of MOVED of the plate's displacement in a section of the half model, in front of and behind its
    back face; plate and gaps that the line encloses belong to them."""
    grids, step = run.soil()
    section = cut(grids, run.surface(step), plane, at, "displacement magnitude")
    centre = (section.lower + section.upper) / 2.
    between = LinearTriInterpolator(Triangulation(*centre.T), section.values)
    low, high = section.lower.min(axis=0), section.upper.max(axis=0)
    x, y = (np.arange(low[i] + PIXEL / 2., high[i], PIXEL) for i in (0, 1))
    grid = np.meshgrid(x, y)
    # beside the outermost centres counts what is next to them
    inside = [np.clip(grid[i], centre[:, i].min() + 1e-6, centre[:, i].max() - 1e-6) for i in (0, 1)]
    moved = between(*inside).filled(0.) > MOVED * way
    front = grid[0] > BASE_AT + way
    return [float(f"{PIXEL**2 * np.count_nonzero(moved & side):.4g}") for side in (front, ~front)]


def mean_between(displacement, values, low, high=np.inf):
    """Mean of the values at displacements above `low` and up to `high`, m."""
    return np.mean(values[(displacement > low) & (displacement <= high + 1e-9)])
