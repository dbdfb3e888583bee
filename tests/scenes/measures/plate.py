"""A plate anchor in sand: a half model, buried at the start, pulled along x."""
import numpy as np
from kedge_plot.resistance import fit_hyperbola


def _start(run):
    """Initial x of the plate's point, m."""
    system = run.input["rigid bodies"][0]
    return system["points"][0]["position"][0] + system.get("offset", [0.])[0]


def _curve(run, area):
    """Displacement (m) from the start of the run and resistance (Pa) of the whole anchor, both along the motion."""
    start = _start(run)
    displacement = run.body("body1_position_x") - start
    direction = np.sign(displacement[-1])
    return direction * displacement, direction * 2. * run.body("body1_reaction force_x") / area


def smallest_growth(run, area):
    """Smallest increment of the resistance from row to row, over the largest resistance."""
    _, resistance = _curve(run, area)
    return np.min(np.diff(resistance)) / np.max(resistance)


def flattening(run, area):
    """Slope of the curve at its end over that at its start."""
    displacement, resistance = _curve(run, area)
    slope = np.diff(resistance, prepend=0.) / np.diff(displacement, prepend=0.)
    return slope[-1] / slope[0]


def resistance(run, area):
    """Resistance at the end, Pa."""
    return _curve(run, area)[1][-1]


def limit(run, area):
    """Asymptote of the hyperbola through the curve, Pa."""
    return fit_hyperbola(*_curve(run, area)).limit


def limit_error(run, area):
    """Standard error of the asymptote, over the asymptote."""
    fit = fit_hyperbola(*_curve(run, area))
    return fit.limit_error / fit.limit


def _surface_motion(run):
    """For the uppermost material points near the plane of symmetry: initial distance ahead of the plate and vertical
    displacement, m."""
    z, y = run.points("initial position_z"), run.points("initial position_y")
    chosen = np.isclose(z, z.max()) & np.isclose(y, y.min())
    start = _start(run)
    direction = np.sign(run.body("body1_position_x")[-1] - start)
    ahead = direction * (run.points("initial position_x")[chosen] - start)
    return ahead, run.points("displacement_z")[chosen]


def rise_in_front(run):
    """Largest rise of the surface ahead of the plate, m."""
    ahead, rise = _surface_motion(run)
    return np.max(rise[ahead > 0.])


def rise_behind(run):
    """Lowest rise of the surface behind the plate, m; negative where it sinks."""
    ahead, rise = _surface_motion(run)
    return np.min(rise[ahead < 0.])
