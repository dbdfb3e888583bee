"""Pictures of stress and displacement around the plates."""
import matplotlib.pyplot as plt
import numpy as np
from kedge_plot.figures import add_soil
from kedge_plot.section import cut
from matplotlib.collections import LineCollection
from matplotlib.tri import Triangulation

WINDOW = {"z": (0.2, 0.9, 0., 0.2), "y": (0.2, 0.9, 0., 0.36)}  # m
LONGEST_EDGE = 0.05  # m: contour lines cross only triangles between material points with shorter edges
SMOOTHED = 0.015  # m: stresses oscillate from one point to the next, their means over this radius do not
# Field, label, factor from SI, contour line, limits of the colours, planes, radius of means (m).
KINDS = {"stress": ("stress_xx", "−σxx (compression) / kPa", -1e-3, 5., (0., 40.), "z", SMOOTHED),
         "displacement": ("displacement magnitude", "displacement / mm", 1e3, 5., (0., 50.), "zy", 0.)}


def stress(runs, path):
    """Horizontal pressure in the horizontal section. runs: pairs of values and run."""
    _draw_sections(runs, "stress", path)


def displacement(runs, path):
    """Displacement in the horizontal and the vertical section."""
    _draw_sections(runs, "displacement", path)


def _draw_sections(runs, kind, path):
    """Draws a row per run and a column per section."""
    field, label, factor, line, limits, planes, radius = KINDS[kind]
    shape = (len(runs), 1) if len(planes) > 1 else ((len(runs) + 1) // 2, 2)
    columns = len(planes) * shape[1]
    height = 2.2 * shape[0] * (1.2 if len(planes) > 1 else 1.)
    figure, axes = plt.subplots(shape[0], columns, figsize=(5.2 * columns, height), squeeze=False, layout="constrained")
    for place, (values, run) in zip(axes.reshape(-1, len(planes)), runs):
        grids, step = run.soil()
        for panel, plane in zip(place, planes):
            at = values["height"] if plane == "z" else 0.
            section = cut(grids, run.surface(step), plane, at, field)
            boxes = _draw(panel, section, factor, line, limits, WINDOW[plane], radius)
            panel.set_title(f"{values['shape']}, {plane} = {at:g} m", fontsize=9)
    for panel in axes.flat[len(runs) * len(planes):]:
        panel.set_axis_off()
    figure.colorbar(boxes, ax=axes, label=label, shrink=0.8)
    figure.savefig(path, dpi=80, metadata={"Software": None})
    plt.close(figure)


def _draw(axes, section, factor, line, limits, window, radius):
    boxes = add_soil(axes, section, factor, limits)
    axes.add_collection(LineCollection(section.outline, colors="k", linewidths=1.))
    centre = (section.lower + section.upper) / 2.
    triangles = Triangulation(*centre.T)
    edges = centre[triangles.triangles] - np.roll(centre[triangles.triangles], 1, axis=1)
    triangles.set_mask(np.linalg.norm(edges, axis=2).max(axis=1) > LONGEST_EDGE)
    axes.tricontour(triangles, factor * _mean_within(radius, centre, section.values), [line], colors="r", linewidths=1.)
    axes.set(xlim=window[:2], ylim=window[2:], aspect="equal", xlabel=f"{section.axes[0]} / m",
             ylabel=f"{section.axes[1]} / m")
    return boxes


def _mean_within(radius, centre, values):
    """Mean of the values of all points within a radius (m) of each."""
    if not radius:
        return values
    return np.array([values[np.hypot(*(centre - x).T) < radius].mean() for x in centre])
