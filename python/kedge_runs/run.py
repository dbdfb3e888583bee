"""Finds the files of a run and reads them."""
import functools
import json
import pathlib
import re

import numpy as np

from . import RunError
from .vtu import read_grid


class Run:
    """The output folder of one run. input.json names the CSV and VTK folders below it; without that file they may have
    any name. Files are read when they are first needed, JSON and CSV files only once; a later change of such a file
    shows in a new Run."""

    def __init__(self, folder, log=""):
        """folder: of --output. log: what the program printed, where the caller has it."""
        self.folder = pathlib.Path(folder)
        self.log = log
        self._tables = {}
        if not self.folder.is_dir():
            raise RunError(f"{folder}: no such folder")

    @functools.cached_property
    def input(self):
        """The content of input.json: the effective input."""
        return self._json("input.json")

    @property
    def scene(self):
        """The effective input; empty where the folder does not hold it."""
        return self.input if (self.folder / "input.json").is_file() else {}

    @functools.cached_property
    def summary(self):
        """The content of summary.json; empty where the run has not written it yet."""
        return self._json("summary.json") if (self.folder / "summary.json").is_file() else {}

    @property
    def is_finished(self):
        """Whether the run reached its end."""
        return self.summary.get("status") == "finished"

    @property
    def stages(self):
        """The entries of summary.json for the stages, in order."""
        if not self.summary.get("stages"):
            raise RunError(f"{self.folder}: holds no summary.json that lists stages")
        return self.summary["stages"]

    def step_before(self, stage):
        """The step counter at the start of a stage, from 1: the number of the last step before it."""
        if not 0 < stage <= len(self.stages):
            raise RunError(f"{self.folder}: has no stage {stage}; it has stages 1 to {len(self.stages)}")
        return 1 + sum(entry["steps"] for entry in self.stages[:stage - 1])

    def stage_of(self, step):
        """The stage, from 1, that a step belongs to; None where the summary does not say."""
        stages = self.summary.get("stages") or []
        for stage in range(1, len(stages)):
            if step <= self.step_before(stage + 1):
                return stage
        return len(stages) or None  # the last one may not know its steps yet

    def time_of(self, step):
        """Time within its stage of a step whose material points were written as VTK: s, in static stages the load
        fraction. None where the lists of files do not hold it."""
        stage, times = self.stage_of(step), self._vtk_times
        if stage is None or step not in times:
            return None
        start = 0. if stage == 1 else times.get(self.step_before(stage))
        return None if start is None else times[step] - start

    @property
    def newton_iterations(self):
        """Newton iterations of every step that the log shows."""
        return [int(number) for number in re.findall(r"\bNR (\d+)", self.log)]

    def share_outside_newton(self):
        """Share of the wall time that the run spends outside residuals, tangents, linear systems and explicit time
        steps; NaN where the summary holds no times yet."""
        time = self.summary.get("wall time", {})
        phases = time.get("phases", {})
        inside = sum(phases.get(name, 0.) for name in ("residual", "tangent", "linear solver", "time steps"))
        return (sum(phases.values()) - inside) / time.get("total", np.nan)

    def start_of(self, body, stage=1):
        """Position of a body at the start of a stage, after it was placed there, m; None where the summary does not
        say."""
        stages = self.summary.get("stages") or []
        points = stages[stage - 1].get("rigid points at start", []) if 0 < stage <= len(stages) else []
        return points[body - 1] if 0 < body <= len(points) else None

    def bodies(self):
        """The columns of rigid_body.csv by name. Where a restart has changed them, the earlier rows of
        rigid_body-<n>.csv come first, and only columns that all these tables have."""
        last = self._csv_folder / "rigid_body.csv" if self._csv_folder else None
        if last is None or not last.is_file():
            raise RunError(f"{self._csv_folder or self.folder}: holds no rigid_body.csv; was \"csv\" on and is there a "
                           "rigid body?")
        earlier = {int(match[1]): path for path in self._csv_folder.glob("rigid_body-*.csv")
                   if (match := re.fullmatch(r"rigid_body-(\d+)\.csv", path.name))}
        columns = _joined([self._table(path) for path in [*(earlier[n] for n in sorted(earlier)), last]])
        if not len(next(iter(columns.values()))):
            raise RunError(f"{last}: holds no rows yet")
        return columns

    def body(self, name):
        """A column of rigid_body.csv, such as "body1_position_z"."""
        return _column(self.bodies(), name, "rigid_body.csv")

    def csv_steps(self):
        """Numbers of the steps at which the run wrote the tables of the material points, in order."""
        return sorted(self._layers)

    def points(self, name, step=None):
        """A column of the tables of the material points, such as "stress_zz", of all layers; default: at the last step
        written."""
        steps = self.csv_steps()
        if not steps:
            raise RunError(f"{self._csv_folder or self.folder}: holds no mps_*.csv; was \"csv\" on?")
        paths = self._layers[steps[-1] if step is None else step]
        return np.concatenate([_column(self._table(path, skip=1), name, path) for path in paths])

    def point_columns(self):
        """Names of the columns that the tables of all layers have in common; none where there is no table."""
        if not self._layers:
            return []
        names = [list(self._table(path, skip=1)) for path in self._layers[max(self._layers)]]
        return [name for name in names[0] if all(name in others for others in names)]

    def vtk_steps(self, series="mps_1"):
        """Numbers of the steps at which the run wrote a series of VTK files, in order."""
        return sorted({step for step, _ in self._vtk_files(series)})

    def soil(self, step=None):
        """The material points of all layers at a step (default: the last) and that step, as a list of grids."""
        steps = self.vtk_steps()
        if not steps:
            raise RunError(f"{self._vtk_folder or self.folder}: holds no mps_1_*.vtu; was \"vtk\" on?")
        step = steps[-1] if step is None else step
        if step not in steps:
            raise RunError(f"no material points were written at step {step}; "
                           f"written: {', '.join(map(str, steps[:20]))}{' ...' if len(steps) > 20 else ''}")
        grids = []
        layer = 1
        while files := dict(self._vtk_files(f"mps_{layer}")):
            if step in files:
                grids.append(read_grid(files[step]))
            layer += 1
        return grids, step

    def surface(self, step):
        """The surfaces of the bodies at the last output up to a step; None without bodies."""
        files = {number: path for number, path in self._vtk_files("surface") if number <= step}
        return read_grid(files[max(files)]) if files else None

    def mesh(self, step):
        """The cells that hold soil at a step."""
        files = dict(self._vtk_files("mesh"))
        if step not in files:
            raise RunError(f"{self.folder}: holds no mesh of step {step}")
        return read_grid(files[step])

    def _vtk_files(self, series):
        """Step and path of every whole file of a series; of a file in pieces only the .pvtu."""
        name = re.compile(re.escape(series) + r"_(\d+)\.p?vtu")
        found = {}
        for path in sorted(self._vtk_folder.glob(series + "_*vtu")) if self._vtk_folder else []:
            if match := name.fullmatch(path.name):
                step = int(match[1])
                if path.suffix == ".pvtu" or step not in found:
                    found[step] = path
        return sorted(found.items())

    @functools.cached_property
    def _vtk_times(self):
        """Times by step from the list of the first layer's files, over all stages."""
        path = self._vtk_folder / "mps_1.pvd" if self._vtk_folder else None
        text = path.read_text(encoding="utf-8", errors="replace") if path and path.is_file() else ""
        return {int(step): float(time)
                for time, step in re.findall(r'timestep="([^"]+)"[^>]*file="mps_1_(\d+)\.p?vtu"', text)}

    @functools.cached_property
    def _vtk_folder(self):
        return self._folder_of("vtk", "mps_*vtu", "surface_*vtu", "mesh_*vtu")

    @functools.cached_property
    def _csv_folder(self):
        return self._folder_of("csv", "mps_*.csv", "rigid_body.csv")

    def _folder_of(self, kind, *names):
        """The folder of this run's files of a kind, "vtk" or "csv"; None where it writes none. input.json names it, for
        others may hold what an earlier run has left; without input.json there must be only one with such files."""
        output = self.scene.get("output", {})
        if self.scene:
            is_on = output.get(kind) == "on" and f"{kind} directory" in output
            return self.folder / output[f"{kind} directory"] if is_on else None
        folders = {path.parent for path in self.folder.rglob("input.json")}
        if len(folders) < 2:
            folders = {path.parent for name in names for path in self.folder.rglob(name)}
        if len(folders) > 1:
            raise RunError(f"{self.folder}: holds several runs ({', '.join(map(str, sorted(folders)))}); name one of "
                           "them")
        return next(iter(folders), None)

    @functools.cached_property
    def _layers(self):
        """By step, the CSV files of the layers in their order. Searched only once: a run may write hundreds."""
        result = {}
        for path in self._csv_folder.glob("mps_*.csv") if self._csv_folder else []:
            result.setdefault(int(path.stem.rsplit("_", 1)[1]), []).append(path)
        for paths in result.values():
            paths.sort(key=lambda path: int(path.stem.split("_")[1]))
        return result

    def _table(self, path, skip=0):
        if path not in self._tables:
            self._tables[path] = _read_table(path, skip)
        return self._tables[path]

    def _json(self, name):
        path = self.folder / name
        try:
            return json.loads(path.read_text(encoding="utf-8"))
        except OSError as error:
            raise RunError(f"{path}: cannot be read ({error.strerror})") from error
        except ValueError as error:
            raise RunError(f"{path}: cannot be read ({error})") from error


def _joined(tables):
    """The rows of tables one after the other, with the columns that all have. A restart may begin before the end of the
    table before: its own rows replace those from there on."""
    tables = [table for table in tables if len(next(iter(table.values())))] or tables[-1:]
    if len(tables) == 1:
        return tables[0]
    names = [name for name in tables[-1] if all(name in table for table in tables)]
    parts, end = [], np.inf
    for table in reversed(tables):
        step = _column(table, "step", "rigid_body-<n>.csv")
        parts.insert(0, {name: table[name][step < end] for name in names})
        end = min(end, step.min())
    return {name: np.concatenate([part[name] for part in parts]) for name in names}


def _read_table(path, skip):
    """Columns by name of a CSV file whose names stand below `skip` lines. A row that the program has written only in
    part, with fewer columns or without the end of its line, is left out."""
    try:
        lines = path.read_text(encoding="utf-8").split("\n")[skip:-1]
    except OSError as error:
        raise RunError(f"{path}: cannot be read ({error.strerror})") from error
    except UnicodeDecodeError as error:
        raise RunError(f"{path}: is not text ({error})") from error
    if not lines or not lines[0]:
        raise RunError(f"{path}: holds no names of columns yet")
    names = lines[0].split(",")
    rows = [line for line in lines[1:] if line and line.count(",") == len(names) - 1]
    if not rows:
        return {name: np.empty(0) for name in names}
    try:
        values = np.loadtxt(rows, delimiter=",", comments=None, ndmin=2)
    except ValueError as error:
        raise RunError(f"{path}: {error}") from error
    return dict(zip(names, values.T))


def _column(columns, name, path):
    if name not in columns:
        raise RunError(f"{path}: has no column \"{name}\"; it has {', '.join(columns)}")
    return columns[name]
