"""Tables and charts of the drag-anchor runs."""
import csv

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from kedge_plot.figures import draw_section, unit_of
from kedge_plot.section import cut
from trajectory import COLUMNS, Trajectory

SECTION_AT = 0.55  # m, through the middle of a fluke


def write_table(trajectories, path):
    """Writes one line per run."""
    write_rows([{"mesh": mesh, **anchor.record} for mesh, anchor in trajectories.items()], path)


def write_rows(rows, path):
    """Writes dictionaries with the same keys to a CSV file."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def write_curves(trajectories, path, every=0.02):
    """Writes the trajectories at intervals of `every` m."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["mesh", *COLUMNS])
        curves = [name for name in COLUMNS.values() if name != "distance"]
        for mesh, anchor in trajectories.items():
            for distance in np.arange(every, anchor.distance[-1] + 0.01 * every, every):
                inside = min(distance, anchor.distance[-1])  # the last distance may exceed the end by round-off
                values = (f"{anchor.at(getattr(anchor, name), inside):.5g}" for name in curves)
                writer.writerow([mesh, f"{distance:.3f}", *values])


def draw_trajectories(trajectories, path):
    figure, panels = plt.subplots(3, 1, figsize=(8., 8.), sharex=True)
    for number, (mesh, anchor) in enumerate(trajectories.items()):
        colour, label = f"C{number}", f"cells of {mesh}"
        panels[0].plot(anchor.distance, anchor.centre_depth, color=colour, label=label)
        panels[0].plot(anchor.distance, anchor.tip_depth, "--", color=colour)
        panels[1].plot(anchor.distance, 1e-3 * anchor.line_force, color=colour, linewidth=0.4, alpha=0.5)
        panels[1].plot(anchor.distance, 1e-3 * anchor.mean_force(), color=colour, label=label)
        panels[2].plot(anchor.distance, anchor.fluke_angle, color=colour, label=label)
        panels[2].plot(anchor.distance, anchor.shank_angle, ":", color=colour)
    panels[0].invert_yaxis()
    for panel, text in zip(panels, ("depth / m\n(full: fluke's centre, dashed: tips)",
                                    "line force / kN\n(mean over 0.2 m)",
                                    "angle / deg, upwards\n(full: fluke, dotted: shank)")):
        panel.set_ylabel(text)
        panel.grid(linewidth=0.3)
    panels[0].legend(fontsize=8)
    panels[2].set_xlabel("drag distance / m")
    figure.tight_layout()
    figure.savefig(path, dpi=100)
    plt.close(figure)


def draw_costs(trajectories, uniform, path, steady=1.):
    """Draws the depth of the anchor at the end and the mean line force from `steady` m on over the core time, for the
    runs that reached the end of the longest. uniform: core time of uniform cells (s), drawn as a vertical line, or
    None."""
    end = max(anchor.distance[-1] for anchor in trajectories.values())
    figure, panels = plt.subplots(1, 2, figsize=(9., 4.), sharex=True)
    for number, (mesh, anchor) in enumerate(trajectories.items()):
        if anchor.distance[-1] < 0.99 * end:
            continue
        cost = float(anchor.record["time / s"]) * int(anchor.record["ranks"])
        force = 1e-3 * anchor.line_force[anchor.distance >= steady].mean()
        for panel, value in zip(panels, (anchor.centre_depth[-1], force)):
            panel.plot(cost, value, "o", color=f"C{number}", label=f"octree, {mesh}")
    for panel, text in zip(panels, (f"depth of the fluke's centre after {end:.3g} m / m",
                                    f"mean line force from {steady:g} m on / kN")):
        if uniform is not None:
            panel.axvline(uniform, color="0.5", linestyle="--", label="uniform, 0.2 m (estimated)")
        panel.set_xscale("log")
        panel.set_ylim(0., 1.3 * panel.get_ylim()[1])
        panel.set_xlabel("core time / s")
        panel.set_ylabel(text)
        panel.grid(which="both", linewidth=0.3)
    panels[0].legend(fontsize=8, loc="lower right")
    figure.tight_layout()
    figure.savefig(path, dpi=100)
    plt.close(figure)


def draw_sections(trajectories, folder, stem, distances=(0., 3., 5., 10., 19.)):
    """Draws soil, fluke and cells at the outputs nearest to these drag distances, for the run that came farthest; of
    two equally far ones, for the one with finer cells. Draws nothing if only tables are left of the runs."""
    lying = {mesh: anchor for mesh, anchor in trajectories.items() if isinstance(anchor, Trajectory)}
    if not lying:
        return
    mesh, anchor = max(reversed(lying.items()), key=lambda item: round(item[1].distance[-1], 1))
    written = [step for step in anchor.run.vtk_steps() if step >= anchor.steps[0] - 1]
    at = np.interp(written, anchor.steps, anchor.distance)
    for distance in distances:
        if not written or distance > anchor.distance[-1] + 0.2:
            continue
        step = written[int(np.argmin(abs(at - distance)))]
        grids, _ = anchor.run.soil(step)
        section = cut(grids, anchor.run.surface(step), "y", SECTION_AT, "displacement magnitude", anchor.run.mesh(step))
        dragged = float(np.interp(step, anchor.steps, anchor.distance))
        centre = dragged + 2.2  # x of the fluke, m
        # A few points that stick to the anchor move much farther than the rest: leave them out of the colours.
        limits = unit_of("displacement magnitude")[1] * np.percentile(section.values, (2., 98.))
        draw_section(section, folder / f"section-{stem}-at-{distance:g}m.png", "displacement magnitude",
                     f"{mesh}, y = {SECTION_AT:g} m, after {dragged:.1f} m", limits=limits,
                     window=(centre - 3., centre + 5., 14.5, 19.5))
