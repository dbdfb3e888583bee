"""Errors against the generalised vortex: every point turns by alpha = A sin(pi t / T) h(R) about the centre."""
import numpy as np

CENTRE, PERIOD = 1.5, 1.  # m, s


def vortex_error(run, values):
    """Root of the mean square error of displacement, over the largest displacement."""
    error, volume, largest = _errors(run, values)
    return np.sqrt(np.sum(volume * error**2) / np.sum(volume)) / largest


def largest_vortex_error(run, values):
    """Largest error of displacement over the largest displacement."""
    error, _, largest = _errors(run, values)
    return error.max() / largest


def _errors(run, values):
    """Errors (m) and initial volumes of the points of the ring, and the largest exact displacement (m)."""
    X, Z = (run.points(f"initial position_{axis}") - CENTRE for axis in "xz")
    R = np.hypot(X, Z)
    ring = abs(R - 1.) < 0.25
    alpha = values["A"] * np.sin(np.pi * values["end"] / PERIOD) * (1. - 32. * (R - 1.)**2 + 256. * (R - 1.)**4)
    alpha = np.where(ring, alpha, 0.)
    x, z = X * np.cos(alpha) - Z * np.sin(alpha), X * np.sin(alpha) + Z * np.cos(alpha)
    error = np.hypot(run.points("position_x") - CENTRE - x, run.points("position_z") - CENTRE - z)
    moved = np.hypot(x - X, z - Z)
    return error[ring], run.points("initial volume")[ring], moved.max()
