"""Starts the program on a scene and reads back what it wrote."""
import csv
import functools
import json
import os
import pathlib
import re
import subprocess

import numpy as np


class RunError(Exception):
    """The program could not be run, or did not write what a measure asks for."""


def execute(program, root, folder, scene, ranks=1, **changes):
    """Runs a scene (a path relative to the root), with the values in `set` replaced; returns the Run."""
    folder.mkdir(parents=True, exist_ok=True)
    command = [str(program.resolve()), "run", str(root / scene), "--output", str(folder / "output")]
    for change in changes.pop("set", []):
        command += ["--set", change]
    if changes:
        raise RunError(f"a run has no \"{next(iter(changes))}\"")
    if ranks > 1:
        command = [str(root / "scripts" / "mpirun"), "-n", str(ranks), *command]
    environment = {"OMP_NUM_THREADS": "1", **os.environ}
    try:
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, encoding="utf-8",
                              errors="replace", check=False)
    except OSError as error:
        raise RunError(f"{program}: cannot be started ({error.strerror})") from error
    if done.returncode:
        raise RunError(f"{scene}: exit code {done.returncode}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return Run(folder / "output", done.stdout)


class Run:
    """Results of one finished run."""

    def __init__(self, folder, log=""):
        self.folder = pathlib.Path(folder)
        self.log = log
        self._tables = {}

    @property
    def input(self):
        """The effective input."""
        return self._json("input.json")

    @property
    def summary(self):
        """The content of summary.json."""
        return self._json("summary.json")

    @property
    def newton_iterations(self):
        """Newton iterations of every step that the log shows."""
        return [int(number) for number in re.findall(r"\bNR (\d+)", self.log)]

    def steps(self):
        """Numbers of the steps whose material points were written."""
        return sorted(self._layers)

    def points(self, name, step=None):
        """A column of the material points of all layers, such as "stress_zz"; default: the last step written."""
        steps = self.steps()
        if not steps:
            raise RunError(f"{self.folder}: holds no mps_*.csv")
        step = steps[-1] if step is None else step
        return np.concatenate([self._column(path, name, skip=1) for path in self._layers[step]])

    def body(self, name):
        """A column of rigid_body.csv, such as "body1_position_z"."""
        return self._column(next(iter(self.folder.rglob("rigid_body.csv")), self.folder / "rigid_body.csv"), name)

    @functools.cached_property
    def _layers(self):
        """By step, the files of the layers in their order. Looked for once: a run may write hundreds."""
        result = {}
        for path in self.folder.rglob("mps_*.csv"):
            result.setdefault(int(path.stem.rsplit("_", 1)[1]), []).append(path)
        for paths in result.values():
            paths.sort(key=lambda path: int(path.stem.split("_")[1]))
        return result

    def _json(self, name):
        try:
            return json.loads((self.folder / name).read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise RunError(f"{self.folder / name}: {error}") from error

    def _column(self, path, name, skip=0):
        if path not in self._tables:
            self._tables[path] = _read_table(path, skip)
        columns = self._tables[path]
        if name not in columns:
            raise RunError(f"{path}: has no column \"{name}\"; it has {', '.join(columns)}")
        return columns[name]


def _read_table(path, skip):
    try:
        with open(path, newline="", encoding="utf-8") as stream:
            rows = list(csv.reader(stream))[skip:]
        values = np.array(rows[1:], dtype=float).reshape(-1, len(rows[0]))
    except (OSError, ValueError, IndexError) as error:
        raise RunError(f"{path}: {error}") from error
    return dict(zip(rows[0], values.T))
