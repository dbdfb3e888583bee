"""The column under its own weight, uniaxial and elastic (Hencky, nu = 0), against its exact solution.

The section keeps its area, so the Cauchy stress in a slice that started at height z0 is sigma = -rho g (L - z0) for
any stretch. The stretch l follows from E ln(l) / l = sigma. The slice's height is x = int l dz0 =
E / (rho g) [ln(l) - ln(l)^2 / 2] between the base and the slice.
"""
import numpy as np


def _case(run):
    soil = run.input["material points"]
    layer, = soil["layers"]
    weight = layer["material"]["density"] * abs(run.input["domain"]["gravity"][-1])
    return layer["thickness"], weight, layer["material"]["E"]


def _stretch(stress_over_young):
    """Solves ln(l) / l = s for s <= 0 by Newton's method on ln(l), which converges from l = 1 for every s."""
    s = np.asarray(stress_over_young, dtype=float)
    logarithm = np.zeros_like(s)
    for _ in range(50):
        stretch = np.exp(logarithm)
        logarithm -= (logarithm - s * stretch) / (1. - s * stretch)
    return np.exp(logarithm)


def exact_height(start, length, weight, young):
    """Final height of a slice that started at a given height."""
    def antiderivative(z):
        logarithm = np.log(_stretch(-weight * (length - z) / young))
        return young / weight * (logarithm - logarithm**2 / 2.)
    return antiderivative(np.asarray(start, dtype=float)) - antiderivative(0.)


def _stress_errors(run):
    length, weight, _ = _case(run)
    exact = -weight * (length - run.points("initial position_z"))
    return (run.points("stress_zz") - exact) / (weight * length)


def largest_stress_error(run):
    """Largest stress error of any material point, over the base stress rho g L."""
    return np.max(np.abs(_stress_errors(run)))


def mean_stress_error(run):
    """Sum |sigma - exact| V0 / (rho g L sum V0)."""
    return np.average(np.abs(_stress_errors(run)), weights=run.points("initial volume"))


def _largest_jump(run, interface, distance):
    """Largest jump over all steps written, over the final base stress."""
    length, weight, _ = _case(run)
    steps, largest = run.input["analysis"][0]["load steps"], 0.
    for step in run.csv_steps():
        start, load = run.points("initial position_z", step), (step - 1) / steps
        _, rows = np.unique(np.round(start / length, 6), return_index=True)
        error = (run.points("stress_zz", step) / weight + load * (length - start))[rows] / length
        height = run.points("position_z", step)[rows]
        near = np.abs((height[1:] + height[:-1]) / 2. - interface) < distance
        largest = max(largest, *np.abs(np.diff(error))[near])
    return largest


def jump_ratio(first, second, interface, distance):
    """Largest jump of the stress error between neighbouring rows of material points, first run over second. Only rows
    count whose mean height is less than the distance (m) away from the interface (a height, m)."""
    return _largest_jump(first, interface, distance) / _largest_jump(second, interface, distance)


def largest_height_error(run):
    """Largest error of the height of any material point, m."""
    exact = exact_height(run.points("initial position_z"), *_case(run))
    return np.max(np.abs(run.points("position_z") - exact))


def length(run):
    """Height of the upper end of the uppermost domain, m."""
    return np.max(run.points("position_z") + run.points("lp_z"))


def length_error(run):
    """Error of the length, m."""
    start, *rest = _case(run)
    return abs(length(run) - exact_height(start, start, *rest))


def lowest_order(*runs):
    """Lowest observed order of convergence of the mean stress error from run to run, each with half the size."""
    errors = [mean_stress_error(run) for run in runs]
    return min(np.log2(coarse / fine) for coarse, fine in zip(errors, errors[1:]))


def stress_difference(run, heights, stresses):
    """Largest relative difference to given values of |sigma_zz| at given initial heights."""
    start, stress = run.points("initial position_z"), np.abs(run.points("stress_zz"))
    return max(np.max(np.abs(stress[np.isclose(start, height)] / expected - 1.))
               for height, expected in zip(heights, stresses))
