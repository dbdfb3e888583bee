"""Numbers taken from a curve."""
import numpy as np

from kedge_plot import PlotError
from kedge_plot.resistance import fit_hyperbola

from . import StudyError

NEEDS_ALL = ("mean", "spread")  # of the range
NEEDS_ORDER = ("mean", "spread", "period")
SLACK = 1e-6  # of the range of x, by which a curve may miss the ends of a range


def take(x, y, kind, limits):
    """A number from a curve: None where it does not cover the range. limits: "from", "to" and "x". Throws StudyError
    where x would have to go one way and does not."""
    if len(x) == 0:
        return None
    slack = SLACK * max(np.ptp(x), abs(x).max(), 1e-300)
    if kind == "at":
        return _at(x, y, limits["x"], slack)
    if kind in NEEDS_ALL:  # where x falls, it ends at the lower limit
        ends = limits.get("from", x.min()) >= x.min() - slack if x[-1] < x[0] else \
            limits.get("to", x.max()) <= x.max() + slack
        if not ends:
            return None
    inside = (x >= limits.get("from", x.min()) - slack) & (x <= limits.get("to", x.max()) + slack)
    if not inside.any():
        return None
    x, y = x[inside], y[inside]
    if kind in NEEDS_ORDER and (np.diff(x) < -slack).any() and (np.diff(x) > slack).any():
        raise StudyError(f"x goes to and fro, so y has no {kind} over it")
    return _TAKERS[kind](x, y)


def _at(x, y, place, slack):
    """Where x first reaches a place, from whichever side. What lies before the first row is unknown."""
    near = np.flatnonzero(abs(x - place) <= slack)
    crossed = np.flatnonzero((x[:-1] - place) * (x[1:] - place) < 0.)
    if len(near) and (len(crossed) == 0 or near[0] <= crossed[0] + 1):
        return y[near[0]]
    if len(crossed) == 0:
        return None
    i = crossed[0]
    return y[i] + (y[i + 1] - y[i]) * (place - x[i]) / (x[i + 1] - x[i])


def _mean(x, y):
    """Mean over x, by the trapezoidal rule: the work over the distance."""
    return np.trapz(y, x) / (x[-1] - x[0]) if len(x) > 1 and x[-1] != x[0] else y.mean()


def _limit(x, y):
    try:
        return fit_hyperbola(x, y).limit
    except PlotError:
        return None


def _slope(x, y):
    return np.polyfit(x, y, 1)[0] if len(x) > 1 else None


def _period(x, y):
    """Mean time between rises through the mean, at least two."""
    above = y > _mean(x, y)
    rises = np.flatnonzero(~above[:-1] & above[1:])
    if len(rises) < 2:
        return None
    mean = _mean(x, y)
    at = x[rises] + (mean - y[rises]) / (y[rises + 1] - y[rises]) * (x[rises + 1] - x[rises])
    return abs(at[-1] - at[0]) / (len(at) - 1)


_TAKERS = {"max": lambda x, y: y.max(), "min": lambda x, y: y.min(), "mean": _mean, "start": lambda x, y: y[0],
           "spread": lambda x, y: np.ptp(y) / 2. / abs(_mean(x, y)), "end": lambda x, y: y[-1], "limit": _limit,
           "slope": _slope, "period": _period}


