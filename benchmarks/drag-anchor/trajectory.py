"""The trajectory of the anchor in one run: position, angles and line force over the drag distance.

Lengths are in m, angles in degrees, positive where tips and eye point upwards, forces in kN for the whole anchor."""
import numpy as np

HALVES = 2.  # the model is one half
DRAG_STAGE = 3
PALMS = 0.4795  # m: lowest point of the fluke below its axis, which rests on the soil at the start
TIP, FLUKE_CENTRE = 1.7, 0.62  # m: x in the drawing of the fluke
WIDTH = 0.2  # m of drag over which line forces are averaged, which removes the oscillations of the line


def depth(run, values):
    """Depth of the fluke's centre below the settled soil."""
    return distance(run), _surface(run) - _drag(run, "body1_position_z")


def tip_depth(run, values):
    """Depth of the fluke's tips."""
    x, centre = depth(run, values)
    return x, centre - (TIP - FLUKE_CENTRE) * np.sin(np.radians(fluke_angle(run, values)[1]))


def line_force(run, values):
    """Force of the line's end along the drag, averaged over WIDTH."""
    x, force = distance(run), 1e-3 * HALVES * _drag(run, "body3_reaction force_x")
    return x, np.array([force[abs(x - d) <= WIDTH / 2.].mean() for d in x])


def fluke_angle(run, values):
    """Angle of the fluke against the horizontal."""
    return distance(run), -np.degrees(_drag(run, "body1_rotation_y"))


def shank_angle(run, values):
    """Angle of the shank against the horizontal."""
    return distance(run), -np.degrees(_drag(run, "body2_rotation_y"))


def distance(run):
    """Distance by which the line's end has moved, per row of the drag."""
    before = run.body("body3_position_x")[run.body("stage") < DRAG_STAGE]
    return _drag(run, "body3_position_x") - before[-1]


def _drag(run, column):
    return run.body(column)[run.body("stage") == DRAG_STAGE]


def _surface(run):
    """Height of the soil when it had settled under its own weight, m."""
    return run.body("body1_position_z")[run.body("stage") == DRAG_STAGE - 1][0] - PALMS
