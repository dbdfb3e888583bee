"""The elastic cube (Hencky, nu = 0) under a smooth platen. The strain is uniaxial, so the section keeps its area."""
import numpy as np


def _case(run):
    soil = run.input["material points"]
    layer, = soil["layers"]
    area = np.prod(soil["material size"]["max"])
    weight = layer["material"]["density"] * abs(run.input["domain"]["gravity"][-1])
    return layer["thickness"], area, weight, layer["material"]["E"]


def _mean_stress(run):
    """Mean compressive stress, weighted by the initial volume, Pa."""
    return -np.average(run.points("stress_zz"), weights=run.points("initial volume"))


def _contact_force(run):
    """Force between platen and soil, N: the platen's weight less the reaction, which holds the platen."""
    point = run.input["rigid bodies"][0]["points"][0]
    own_weight = point["mass"] * abs(run.input["domain"]["gravity"][-1])
    return own_weight - run.body("body1_reaction force_z")[-1]


def reached_height(run):
    """Mean height of the upper ends of the uppermost domains, m."""
    start = run.points("initial position_z")
    return np.mean((run.points("position_z") + run.points("lp_z"))[np.isclose(start, start.max())])


def hencky_error(run):
    """Relative error of the mean stress against E ln(L / L0) L0 / L at the height reached."""
    start, _, _, young = _case(run)
    height = reached_height(run)
    return abs(_mean_stress(run) / (-young * np.log(height / start) * start / height) - 1.)


def spread(run):
    """Difference between the largest and the smallest stress, over the mean."""
    return np.ptp(run.points("stress_zz")) / _mean_stress(run)


def balance_error(run):
    """Relative difference between the mean stress and (contact force + half the soil's weight) / area."""
    start, area, weight, _ = _case(run)
    return abs((_contact_force(run) / area + weight * start / 2.) / _mean_stress(run) - 1.)


def penetration(run):
    """Depth of the deepest domain below the platen's lower face, m. The face starts at the soil's surface."""
    start = _case(run)[0]
    point = run.input["rigid bodies"][0]["points"][0]
    face = start + run.body("body1_position_z")[-1] - point["position"][2]
    by_corner = -np.nanmin(run.points("contact gap"))
    return max(by_corner, np.max(run.points("position_z") + run.points("lp_z")) - face)


def mean_stress_difference(first, second):
    """Relative difference of the mean stress between two runs."""
    return abs(_mean_stress(first) / _mean_stress(second) - 1.)


def contact_force_difference(first, second):
    """Relative difference of the contact force between two runs."""
    return abs(_contact_force(first) / _contact_force(second) - 1.)


def penetration_difference(first, second):
    """Relative difference of the penetration between two runs."""
    return abs(penetration(first) / penetration(second) - 1.)
