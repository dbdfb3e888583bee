"""The anchor of one run: where it is and what pulls, over the drag distance."""
import numpy as np

from kedge_plot.run import Run

HALVES = 2.  # the model is one half
DRAG_STAGE = 3
PALMS = 0.4795  # of the fluke below its axis, m: what rests on the soil as the anchor is placed
TIP, PIVOT, FLUKE_CENTRE, SHANK_CENTRE = 1.7, 0.489, 0.62, 1.7592  # along x where the parts were drawn, m


class Trajectory:
    """Arrays over the steps of the drag; lengths in m, forces in N of the whole anchor, angles in degrees, tips and eye
    upwards positive."""

    def __init__(self, folder):
        self.run = Run(folder)
        rows = self.run.body_history()
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
        self.finished = self.run.summary().get("status") == "finished"

    def _hinge_gap(self, column):
        """Distance between the pivot on the fluke and the pivot on the shank: what the hinge's springs give."""
        def pivot(body, centre):
            angle = column[f"body{body}_rotation_y"]
            return np.array([column[f"body{body}_position_x"] + (PIVOT - centre) * np.cos(angle),
                             column[f"body{body}_position_z"] - (PIVOT - centre) * np.sin(angle)])
        return np.linalg.norm(pivot(1, FLUKE_CENTRE) - pivot(2, SHANK_CENTRE), axis=0)

    def mean_force(self, width=0.2):
        """The line force averaged over `width` m of drag: the line's own swings drop out."""
        return np.array([self.line_force[abs(self.distance - d) <= width / 2.].mean() for d in self.distance])

    def at(self, values, distance):
        """The value at a drag distance; not a number beyond the end of the run."""
        return np.interp(distance, self.distance, values, right=np.nan)
