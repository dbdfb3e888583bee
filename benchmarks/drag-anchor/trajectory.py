"""The trajectory of the anchor in one run: position, angles and line force over the drag distance."""
import csv

import numpy as np
from kedge_runs.run import Run

HALVES = 2.  # the model is one half
DRAG_STAGE = 3
PALMS = 0.4795  # m: lowest point of the fluke below its axis, which rests on the soil at the start
TIP, PIVOT, FLUKE_CENTRE, SHANK_CENTRE = 1.7, 0.489, 0.62, 1.7592  # m: x in the drawings of the parts


class Curves:
    """Arrays over the drag: `distance`, `centre_depth`, `tip_depth`, `line_force`, `fluke_angle` and `shank_angle`.
    Lengths are in m, forces in N for the whole anchor, angles in degrees, positive where tips and eye point upwards."""

    def mean_force(self, width=0.2):
        """The line force averaged over `width` m of drag, which removes the oscillations of the line."""
        return np.array([self.line_force[abs(self.distance - d) <= width / 2.].mean() for d in self.distance])

    def at(self, values, distance):
        """The value at a drag distance; NaN beyond the end of the run."""
        return np.interp(distance, self.distance, values, right=np.nan)


COLUMNS = {"drag / m": "distance", "depth of the fluke's centre / m": "centre_depth",
           "depth of the tips / m": "tip_depth", "line force / N": "line_force", "fluke angle / deg": "fluke_angle",
           "shank angle / deg": "shank_angle"}


class KeptTrajectory(Curves):
    """An earlier run as the tables hold it: `rows` of its curves, and its `record` in the table of runs."""

    def __init__(self, rows, record):
        self.record = record
        for column, name in COLUMNS.items():
            setattr(self, name, np.array([float(row[column]) for row in rows]))


def read_kept(curves, table):
    """The trajectories of earlier runs in two CSV files, by mesh; empty if a file is missing."""
    if not curves.is_file() or not table.is_file():
        return {}
    with open(curves, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    with open(table, newline="", encoding="utf-8") as file:
        return {record["mesh"]: KeptTrajectory([row for row in rows if row["mesh"] == record["mesh"]], record)
                for record in csv.DictReader(file)}


class Trajectory(Curves):
    """The drag of a run whose output folder is there."""

    def __init__(self, folder):
        self.run = Run(folder)
        rows = self.run.bodies()
        drag = rows["stage"] == DRAG_STAGE
        self.surface = rows["body1_position_z"][rows["stage"] == DRAG_STAGE - 1][0] - PALMS  # of the settled soil, m
        column = {name: values[drag] for name, values in rows.items()}
        before = rows["body3_position_x"][~drag]
        self.steps = column["step"]
        self.distance = column["body3_position_x"] - before[-1]
        self.fluke_angle = -np.degrees(column["body1_rotation_y"])
        self.shank_angle = -np.degrees(column["body2_rotation_y"])
        self.centre_depth = self.surface - column["body1_position_z"]
        self.tip_depth = self.centre_depth - (TIP - FLUKE_CENTRE) * np.sin(np.radians(self.fluke_angle))
        self.line_force = HALVES * column["body3_reaction force_x"]
        self.hinge_gap = self._hinge_gap(column)
        self.finished = self.run.is_finished

    def _hinge_gap(self, column):
        """Distance between the pivot on the fluke and the pivot on the shank, by which the hinge's springs yield, m."""
        def pivot(body, centre):
            angle = column[f"body{body}_rotation_y"]
            return np.array([column[f"body{body}_position_x"] + (PIVOT - centre) * np.cos(angle),
                             column[f"body{body}_position_z"] - (PIVOT - centre) * np.sin(angle)])
        return np.linalg.norm(pivot(1, FLUKE_CENTRE) - pivot(2, SHANK_CENTRE), axis=0)

    @property
    def record(self):
        """Line of the table of runs without the mesh: the end of the drag and its cost."""
        summary = self.run.summary
        stages = summary.get("stages", [])
        drag = stages[-1] if len(stages) == 3 else {}
        return {"dragged / m": f"{self.distance[-1]:.2f}", "finished": self.finished,
                "depth of the fluke's centre / m": f"{self.centre_depth[-1]:.3f}",
                "depth of the tips / m": f"{self.tip_depth[-1]:.3f}",
                "line force / kN": f"{1e-3 * self.mean_force()[-1]:.1f}",
                "fluke angle / deg": f"{self.fluke_angle[-1]:.1f}",
                "shank angle / deg": f"{self.shank_angle[-1]:.1f}", "steps": drag.get("steps", ""),
                "cuts": drag.get("cuts", ""), "newton iterations": drag.get("newton iterations", ""),
                "material points": drag.get("material points", ""), "dofs": drag.get("dofs", ""),
                "ranks": summary.get("ranks", ""),
                "time / s": f"{summary.get('wall time', {}).get('total', np.nan):.0f}",
                "time outside Newton / %": f"{100. * self.run.share_outside_newton():.0f}"}
