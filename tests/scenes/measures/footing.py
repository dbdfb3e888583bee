"""A smooth strip footing on a slice of soil between rollers."""


def _pressing_force(run):
    """At the end, over the thickness of the slice, N/m."""
    point = run.input["rigid bodies"][0]["points"][0]
    own_weight = point["mass"] * abs(run.input["domain"]["gravity"][-1])
    thickness = run.input["material points"]["material size"]["max"][1]
    return (own_weight - run.body("body1_reaction force_z")[-1]) / thickness


def excess(coarse, fine):
    """Force of the first run over that of the second, less one."""
    return _pressing_force(coarse) / _pressing_force(fine) - 1.
