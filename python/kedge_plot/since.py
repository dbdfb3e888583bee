"""Displacement and deformation since the start of a stage."""
import numpy as np

from . import PlotError
from .fields import GRADIENT, SHEAR_STRAIN
from .section import box_bounds
from .smoothing import interpolate

FIELDS = ("displacement", SHEAR_STRAIN)


def output_before(run, stage, step):
    """The step of the last output of material points up to the start of a stage, and the step at which that stage
    starts; step: the one to draw."""
    start = run.step_before(stage)
    if step <= start:
        raise PlotError(f"step {step} is not later than step {start}, at which stage {stage} starts; name a later "
                        "--step or an earlier stage with --since")
    written = [number for number in run.vtk_steps() if number <= start]
    if not written:
        raise PlotError(f"--since {stage}: no material points were written up to step {start}, at which stage {stage} "
                        f"starts, but only from step {run.vtk_steps()[0]} on")
    return written[-1], start


def subtract(grids, references):
    """Makes displacement and deformation gradient of grids (one per layer) those since the state of `references`, grids
    of the same layers.

    Points are split and merged, so they have no lasting numbers: what they are known by is their position at the start
    of the run. The fields of the reference, at those positions of its points, are interpolated.
    """
    for grid, reference in zip(grids, references):
        if len(grid.types) == 0 or len(reference.types) == 0:
            continue
        places, points = start_positions(grid), start_positions(reference)
        data, before = grid.cell_data, reference.cell_data
        data["displacement"] = data["displacement"] - interpolate(places, points, before["displacement"].astype(float))
        if GRADIENT in data and GRADIENT in before:
            gradient = interpolate(places, points, before[GRADIENT].astype(float))
            total = data[GRADIENT].astype(float).reshape(-1, 3, 3)
            data[GRADIENT] = (total @ np.linalg.inv(gradient.reshape(-1, 3, 3))).reshape(-1, 9)


def start_positions(grid):
    """Centres of the material points at the start of the run, (n, 3), m."""
    if "displacement" not in grid.cell_data:
        raise PlotError("--since needs the field \"displacement\", which the run has not written; add it to \"vtk "
                        "material point fields\" in the input")
    lower, upper = box_bounds(grid)
    return (lower + upper) / 2. - grid.cell_data["displacement"]
