"""A smooth strip footing, on a slice of soil between rollers or in plane strain."""
import math


def _pressing_force(run):
    """Force on the soil at the end, over the thickness of the slice, N/m."""
    point = run.input["rigid bodies"][0]["points"][0]
    own_weight = point["mass"] * abs(run.input["domain"]["gravity"][-1])
    thickness = run.input["material points"]["material size"]["max"][1]
    return (own_weight - run.body("body1_reaction force_z")[-1]) / thickness


def excess(coarse, fine):
    """Force of the first run over that of the second, minus one."""
    return _pressing_force(coarse) / _pressing_force(fine) - 1.


def prandtl_excess(run):
    """Load at the end over Prandtl's (1920) limit (2 + pi) c of a strip on clay without friction, minus one. Half model
    in plane strain, per metre of length."""
    width = max(x for x, _ in run.input["rigid bodies"][0]["outline"][0]["polygon"])
    layer, = run.input["material points"]["layers"]
    cohesion = layer["material"]["yield stress"] / math.sqrt(3.)
    return -run.body("body1_reaction force_z")[-1] / ((2. + math.pi) * cohesion * width) - 1.


def last_rise(run):
    """Growth of the load over the last tenth of the rows, over its final value."""
    load = run.body("body1_reaction force_z")
    return 1. - load[-1 - len(load) // 10] / load[-1]
