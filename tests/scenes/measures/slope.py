"""A free rigid body on a slope that rises along -x. Gravity is tilted by the slope's angle; z is normal to the soil. A
body with a `radius` (m) is a ball, which rolls if friction suffices; without one it is a block, which then sticks."""
import numpy as np


class _Exact:
    """Constant accelerations of a body on a rigid slope: along x (m/s2) and about y (rad/s2)."""

    def __init__(self, run, radius):
        point = run.input["rigid bodies"][0]["points"][0]
        along, _, normal = run.input["domain"]["gravity"]
        friction = -normal * run.input["contact"]["friction coefficient"]
        inertia = 0. if radius is None else point["rotational inertia"][1] / (point["mass"] * radius**2)
        # acceleration that keeps the point of contact at rest; for a block all of gravity along the slope
        holding = along if radius is None else along * inertia / (1. + inertia)
        self.acceleration = along - min(friction, holding)
        self.turning = 0. if radius is None else min(friction, holding) / (inertia * radius)


def _motion(run, name):
    """Times of the last stage (s), and a column of the body in it, less the value at the start of that stage."""
    stage, values = run.body("stage"), run.body(f"body1_{name}")
    last = stage == stage[-1]
    start = 0.
    if not np.all(last):
        start = values[~last][-1]
    elif name.startswith("position"):
        system, axis = run.input["rigid bodies"][0], "xyz".index(name[-1])
        start = system["points"][0]["position"][axis] + system.get("offset", [0., 0., 0.])[axis]
    return run.body("time")[last], values[last] - start


def distance_error(run, radius=None):
    """Relative error of the distance along the slope at the end."""
    time, distance = _motion(run, "position_x")
    return abs(distance[-1] / (0.5 * _Exact(run, radius).acceleration * time[-1]**2) - 1.)


def speed_error(run, radius=None):
    """Relative error of the speed at the end."""
    time, speed = _motion(run, "velocity_x")
    return abs(speed[-1] / (_Exact(run, radius).acceleration * time[-1]) - 1.)


def turn_error(run, radius):
    """Relative error of a ball's angle at the end."""
    time, angle = _motion(run, "rotation_y")
    return abs(angle[-1] / (0.5 * _Exact(run, radius).turning * time[-1]**2) - 1.)


def largest_distance(run):
    """Largest distance of the body from its start along the slope, up or down, m."""
    return np.max(np.abs(_motion(run, "position_x")[1]))


def largest_turn(run):
    """Largest angle of the body about y, rad."""
    return np.max(np.abs(_motion(run, "rotation_y")[1]))
