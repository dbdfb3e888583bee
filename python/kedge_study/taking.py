"""Numbers taken from a curve."""
import numpy as np

from kedge_plot import PlotError
from kedge_plot.resistance import fit_hyperbola


NEEDS_NO_END = ("max", "min", "end", "start", "limit", "slope", "period")
SLACK = 1e-6  # of the range of x, by which a curve may miss the ends of a range


def take(x, y, kind, limits):
    """A number from a curve with rising x: None where it does not cover the range. limits: "from", "to" and "x"."""
    if len(x) == 0:
        return None
    slack = SLACK * max(np.ptp(x), abs(x).max(), 1e-300)
    low, high = limits.get("from", x[0]), limits.get("to", x[-1])
    if kind == "at":
        low = high = limits["x"]
        if low > x[-1] + slack or low < min(x[0], 0.) - slack:
            return None
        return np.interp(low, x, y) if low >= x[0] else y[0] * (low / x[0] if x[0] else 1.)
    if kind not in NEEDS_NO_END and high > x[-1] + slack:
        return None
    inside = (x >= low - slack) & (x <= high + slack)
    if not inside.any():
        return None
    return _TAKERS[kind](x[inside], y[inside])


def _mean(x, y):
    """Mean over x, by the trapezoidal rule: the work over the distance."""
    return np.trapz(y, x) / (x[-1] - x[0]) if len(x) > 1 and x[-1] > x[0] else y.mean()


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
    return (at[-1] - at[0]) / (len(at) - 1)


_TAKERS = {"max": lambda x, y: y.max(), "min": lambda x, y: y.min(), "mean": _mean, "start": lambda x, y: y[0],
           "spread": lambda x, y: np.ptp(y) / 2. / abs(_mean(x, y)), "end": lambda x, y: y[-1], "limit": _limit,
           "slope": _slope, "period": _period}


