"""Sections through soil, fluke and cells at some distances of the drag."""
import matplotlib.pyplot as plt
import numpy as np
from kedge_plot.figures import add_soil, rectangle_corners, unit_of
from kedge_plot.section import cut
from matplotlib.collections import LineCollection, PolyCollection

from trajectory import DRAG_STAGE, distance

AT = 0.6  # m: y of the section, through a palm of the fluke
FIELD = "displacement magnitude"
LIMIT = 2.5  # m: what sticks to the anchor moves as far as the anchor


def at_0_and_3m(runs, path):
    """At the start and after 3 m."""
    _draw(runs, (0., 3.), path)


def at_5_10_and_19m(runs, path):
    """After 5, 10 and 19 m."""
    _draw(runs, (5., 10., 19.), path)


def _draw(runs, distances, path):
    """A panel for each distance, of the run with the smallest cells and the largest region."""
    _, run = min(runs, key=lambda pair: (pair[0]["cell"], -pair[0]["region"]))
    steps = run.body("step")[run.body("stage") == DRAG_STAGE]
    written = [step for step in run.vtk_steps() if step >= steps[0] - 1]
    at = np.interp(written, steps, distance(run))
    unit, factor = unit_of(FIELD)
    figure, panels = plt.subplots(len(distances), 1, figsize=(9, 4.6 * len(distances)), layout="constrained")
    for axes, wanted in zip(panels, distances):
        step = written[int(np.argmin(abs(at - wanted)))]
        grids, _ = run.soil(step)
        section = cut(grids, run.surface(step), "y", AT, FIELD, run.mesh(step))
        boxes = add_soil(axes, section, factor, (0., factor * LIMIT))
        axes.add_collection(PolyCollection(rectangle_corners(section.cells[:, 0], section.cells[:, 1]),
                                           facecolors="none", edgecolors="0.6", linewidths=0.4))
        axes.add_collection(LineCollection(section.outline, colors="k", linewidths=1.))
        centre = wanted + 2.2  # x of the fluke, m
        axes.set(xlim=(centre - 3., centre + 5.), ylim=(14.5, 19.5), aspect="equal", xlabel="x / m", ylabel="z / m",
                 title=f"after {at[written.index(step)]:.1f} m, y = {AT:g} m")
        figure.colorbar(boxes, ax=axes, label=f"{FIELD} / {unit}", shrink=0.8, extend="max")
    figure.savefig(path, dpi=90, metadata={"Software": None})
    plt.close(figure)
