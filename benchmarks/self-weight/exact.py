"""The exact displacement of an elastic column under its own weight (Hencky, nu = 0), and the error of a run.

The stretch l of a slice at the initial height Z follows from E ln(l) / l = -w (L - Z). Its displacement is the
integral of l - 1 from the base to Z. With q = ln(l), the integral of l dZ is E / w (q - q^2 / 2).
"""
import numpy as np


def _logarithm(stress_over_young):
    """Solves q exp(-q) = s for s <= 0 by Newton's method from q = 0, which converges for every such s."""
    s = np.asarray(stress_over_young, dtype=float)
    q = np.zeros_like(s)
    for _ in range(60):
        q -= (q - s * np.exp(q)) / (1. - s * np.exp(q))
    return q


def displacement(height, length, weight, young):
    """Displacement of slices, m, upwards. height: initial, m; weight: of a unit volume, N/m3; young: modulus, Pa."""
    def antiderivative(z):
        q = _logarithm(-weight * (length - z) / young)
        return young / weight * (q - q**2 / 2.)
    height = np.asarray(height, dtype=float)
    return antiderivative(height) - antiderivative(0.) - height


def _errors(run, values):
    """Initial heights over the length, errors of the displacement over the settlement of the top, initial volumes."""
    length, column = values["L"], (values["L"], values["weight"], values["E"])
    start = run.points("initial position_z")
    errors = run.points("displacement_z") - displacement(start, *column)
    return start / length, errors / displacement(length, *column), run.points("initial volume")


def displacement_error(run, values):
    """Curve: initial height over the length, and the error of the displacement over the settlement of the top."""
    height, errors, _ = _errors(run, values)
    return height, errors


def mean_displacement_error(run, values):
    """Mean error of the displacement over the settlement of the top, weighted by initial volumes."""
    _, errors, volumes = _errors(run, values)
    return float(np.average(np.abs(errors), weights=volumes))
