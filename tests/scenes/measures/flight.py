"""Soil and a rigid point that fly freely under gravity, compared with their parabolas."""
import numpy as np


def _gravity(run):
    return np.array(run.input["domain"]["gravity"], dtype=float)


def end_time_error(run):
    """Distance of each stage's last moment from the end that it has in the input, s."""
    stage, time = run.body("stage"), run.body("time")
    return max(abs(np.max(time[stage == i + 1]) - given["final time"])
               for i, given in enumerate(run.input["analysis"]))


def _largest_error(run, field, exact):
    return max(np.max(np.abs(run.points(f"{field}_{axis}") - exact[d])) for d, axis in enumerate("xz"))


def velocity_error(run):
    """Largest error of a material point's velocity at the end, m/s."""
    time = sum(stage["final time"] for stage in run.input["analysis"])
    start = np.array(run.input["material points"]["initial velocity"]["expression"], dtype=float)
    return _largest_error(run, "velocity", start + time * _gravity(run))


def soil_acceleration_error(run):
    """Largest error of a material point's acceleration at the end, m/s2."""
    return _largest_error(run, "acceleration", _gravity(run))


def body_acceleration_error(run):
    """Largest error of the rigid point's acceleration after any step, m/s2."""
    moved = run.body("time") > 0.
    return max(np.max(np.abs(run.body(f"body1_acceleration_{axis}")[moved] - gravity))
               for axis, gravity in zip("xz", _gravity(run)))


def release_error(run):
    """Error of the soil's mean velocity at the end, where the last stage has let it go from rest, m/s."""
    time = run.input["analysis"][-1]["final time"]
    return max(abs(np.mean(run.points(f"velocity_{axis}")) - time * gravity)
               for axis, gravity in zip("xz", _gravity(run)))


def flattening_error(run):
    """Error of the mean height of the lowest row of material points at the end, z = Z (1 - t), relative to it."""
    start = run.points("initial position_z").round(6)
    exact = np.min(start) * (1. - run.input["analysis"][0]["final time"])
    return abs(np.mean(run.points("position_z")[start == np.min(start)]) / exact - 1.)


def removed_mass(run):
    """Mass of the material points that were removed or left the grid, kg/m."""
    return sum(stage["removed mass"] for stage in run.summary["stages"])
