"""Finds the files of a run and reads its tables."""
import csv
import json
import pathlib
import re

import numpy as np

from . import PlotError
from .vtu import read_grid


class Run:
    """The output folder of one run; the CSV and VTK folders below it may have any name."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        if not self.folder.is_dir():
            raise PlotError(f"{folder}: no such folder")

    def summary(self):
        """The content of summary.json; empty where the run has not ended."""
        path = self.folder / "summary.json"
        if not path.is_file():
            return {}
        try:
            return json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise PlotError(f"{path}: cannot be read ({error})") from error

    def share_outside_newton(self):
        """Share of the wall time that went into anything but residuals, tangents and linear systems, or explicit time steps; not a
        number where the run has not said yet."""
        time = self.summary().get("wall time", {})
        inside = sum(time.get("phases", {}).get(name, 0.) for name in ("residual", "tangent", "linear solver", "time steps"))
        return (sum(time.get("phases", {}).values()) - inside) / time.get("total", np.nan)

    def start_of(self, body):
        """Position of a body at the start of the first stage; None where the summary does not say."""
        stages = self.summary().get("stages") or [{}]
        points = stages[0].get("rigid points at start", [])
        return points[body - 1] if 0 < body <= len(points) else None

    def body_history(self):
        """The columns of rigid_body.csv by name."""
        paths = sorted(self.folder.rglob("rigid_body.csv"))
        if not paths:
            raise PlotError(f"{self.folder}: holds no rigid_body.csv; was \"csv\" on and is there a rigid body?")
        if len(paths) > 1:
            raise PlotError(f"{self.folder}: holds several runs ({', '.join(map(str, paths))}); name one of them")
        return read_columns(paths[0])

    def steps(self, series="mps_1"):
        """Numbers of the steps at which a series of VTK files was written, in order."""
        return sorted({step for step, _ in self._files(series)})

    def soil(self, step=None):
        """The material points of all layers at a step (default: the last) and that step, as a list of grids."""
        steps = self.steps()
        if not steps:
            raise PlotError(f"{self.folder}: holds no mps_1_*.vtu; was \"vtk\" on?")
        step = steps[-1] if step is None else step
        if step not in steps:
            raise PlotError(f"no material points were written at step {step}; "
                            f"written: {', '.join(map(str, steps[:20]))}{' ...' if len(steps) > 20 else ''}")
        grids = []
        layer = 1
        while files := dict(self._files(f"mps_{layer}")):
            if step in files:
                grids.append(read_grid(files[step]))
            layer += 1
        return grids, step

    def surface(self, step):
        """The surfaces of the bodies at the last output up to a step; None without bodies."""
        files = {number: path for number, path in self._files("surface") if number <= step}
        return read_grid(files[max(files)]) if files else None

    def mesh(self, step):
        """The cells that hold soil at a step."""
        files = dict(self._files("mesh"))
        if step not in files:
            raise PlotError(f"{self.folder}: holds no mesh of step {step}")
        return read_grid(files[step])

    def _files(self, series):
        """Step and path of every whole file of a series; of a file in pieces only the .pvtu."""
        name = re.compile(re.escape(series) + r"_(\d+)\.p?vtu")
        found = {}
        for path in sorted(self.folder.rglob(series + "_*vtu")):
            if match := name.fullmatch(path.name):
                step = int(match[1])
                if path.suffix == ".pvtu" or step not in found:
                    found[step] = path
        return sorted(found.items())


def read_columns(path):
    """Columns of a CSV file with one line of names. Rows that were cut off while being written are left out."""
    try:
        with open(path, newline="", encoding="utf-8") as stream:
            rows = list(csv.reader(stream))
    except OSError as error:
        raise PlotError(f"{path}: cannot be read ({error.strerror})") from error
    if len(rows) < 2:
        raise PlotError(f"{path}: holds no rows yet")
    names, rows = rows[0], [row for row in rows[1:] if len(row) == len(rows[0])]
    try:
        values = np.array(rows, dtype=float).reshape(-1, len(names))
    except ValueError as error:
        raise PlotError(f"{path}: {error}") from error
    return dict(zip(names, values.T))
