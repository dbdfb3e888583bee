"""The front of a deposit, without the few points that run ahead of it."""
import numpy as np

SHARE = 0.99  # of the sand


def bulk(run, values):
    """Distance from the column's first edge, in widths of the column, behind which 99 % of the sand lies. Sand that the
    run has deleted counts as ahead. NaN for a run that has failed: its last table shows another time."""
    if not run.is_finished:
        return np.nan
    x, volume = run.points("position_x"), run.points("initial volume")
    order = np.argsort(x)
    behind = np.cumsum(volume[order]) / (values["H"] * values["d"])
    return float(np.interp(SHARE, behind, x[order])) / values["d"] - 1.
