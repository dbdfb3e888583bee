"""An elastic bar along z (nu = 0, sides on rollers, foot held) that vibrates lengthwise because gravity sets in at
once. u(z, t) is the static shortening less the sum of modes sin(k z), k = pi (2 n - 1) / (2 L), which start at rest."""
from dataclasses import dataclass

import numpy as np

from kedge_runs import RunError

MODES = 20


@dataclass
class Bar:
    """The bar of the input; units m, m2, kg/m3, Pa, m/s2."""

    length: float
    area: float
    density: float
    young: float
    gravity: float

    @classmethod
    def of(cls, run):
        soil = run.input["material points"]
        layer, = soil["layers"]
        return cls(layer["thickness"], np.prod(soil["material size"]["max"]), layer["material"]["density"],
                   layer["material"]["E"], -run.input["domain"]["gravity"][-1])

    @property
    def period(self):
        """Period of the lowest mode, s."""
        return 4. * self.length * np.sqrt(self.density / self.young)

    @property
    def static_shortening(self):
        """Static shortening of the whole bar, m."""
        return self.density * self.gravity * self.length**2 / (2. * self.young)

    @property
    def energy(self):
        """Energy of the vibration: kinetic, strain and potential energy above those of the static state, J."""
        return (self.density * self.gravity)**2 * self.area * self.length**3 / (6. * self.young)

    def shortening(self, time):
        """Exact motion of the free end (positive down), m. Its velocity is a triangular wave: the end falls freely for
        a quarter of a period, until the wave that starts at the foot arrives."""
        phase = np.asarray(time) / self.period % 1.
        phase = np.where(phase < 0.5, phase, 1. - phase)  # a period is symmetric about its middle
        return 2. * self.static_shortening * np.where(phase < 0.25, 8. * phase**2, 1. - 8. * (0.5 - phase)**2)


@dataclass
class History:
    """The course of the vibration: one value per step, from the start at rest."""

    time: np.ndarray
    shortening: np.ndarray  # of the uppermost material points' centres, m
    modal_velocity: np.ndarray  # share of the lowest mode, m/s
    kinetic: np.ndarray  # J
    strain: np.ndarray
    weight: np.ndarray

    @property
    def energy(self):
        return self.kinetic + self.strain + self.weight


def history(run):
    bar, stage = Bar.of(run), run.input["analysis"][0]
    steps = run.csv_steps()
    if run.stages[0]["cuts"] or steps != list(range(2, 2 + len(steps))):
        raise RunError(f"{run.folder}: a step was cut or not written")
    rows = [_row(run, step, bar) for step in steps]
    return History(stage.get("basis step", stage["dt"]) * np.arange(len(steps) + 1), *np.array([[0.] * 5, *rows]).T)


def _row(run, step, bar):
    volume, z = run.points("initial volume", step), run.points("initial position_z", step)
    motion, velocity = run.points("displacement_z", step), [run.points(f"velocity_{axis}", step) for axis in "xyz"]
    strain = {axes: run.points(f"strain_{axes}", step) for axes in ("xx", "yy", "zz", "xy", "yz", "xz")}
    # Hencky's energy per initial volume; the shears count twice
    density = bar.young / 2. * sum((1. if axes[0] == axes[1] else 2.) * strain[axes]**2 for axes in strain)
    return (-np.mean(motion[np.isclose(z, z.max())]),
            np.average(np.sin(0.5 * np.pi * z / bar.length) * velocity[2], weights=volume),
            bar.density * np.sum(volume * sum(component**2 for component in velocity)) / 2.,
            np.sum(volume * density),
            bar.density * bar.gravity * np.sum(volume * motion))


def period_of(course):
    """Period from the slope of a line through the times at which the velocity of the lowest mode changes sign, s."""
    value, time = course.modal_velocity[1:], course.time[1:]
    at = np.flatnonzero(np.sign(value[:-1]) != np.sign(value[1:]))
    if len(at) < 2:
        return np.nan
    crossings = time[at] - value[at] * (time[at + 1] - time[at]) / (value[at + 1] - value[at])
    return 2. * np.polyfit(np.arange(len(crossings)), crossings, 1)[0]


def period_error(run):
    """Relative error of the period."""
    return abs(period_of(history(run)) / Bar.of(run).period - 1.)


def end_error(run):
    """Largest error of the free end's motion, over the largest motion."""
    course, bar = history(run), Bar.of(run)
    return np.max(np.abs(course.shortening - bar.shortening(course.time))) / (2. * bar.static_shortening)


def energy_left(run):
    """Share of the energy of the vibration that is left at the end."""
    bar = Bar.of(run)
    return 1. + history(run).energy[-1] / bar.energy


def expected_energy_left(run):
    """The same share for the bar's modes, each stepped by Newmark's method as one mass on a spring."""
    stage, bar = run.input["analysis"][0], Bar.of(run)
    beta, gamma, dt = stage["beta"], stage["gamma"], stage["dt"]
    left = 0.
    for odd in range(1, 2 * MODES, 2):
        x, v, square = 1., 0., (2. * np.pi * odd * dt / bar.period)**2  # dt is the unit of time
        a = -square
        for _ in range(round(stage["final time"] / dt)):
            old = a
            a = -square * (x + v + (0.5 - beta) * old) / (1. + beta * square)
            x, v = x + v + (0.5 - beta) * old + beta * a, v + (1. - gamma) * old + gamma * a
        left += 96. / (np.pi * odd)**4 * (x**2 + v**2 / square)
    return left


def energy_left_error(run):
    """Difference between the energy left and that of the modes, over the energy of the vibration."""
    return abs(energy_left(run) - expected_energy_left(run))


def energy_drift(run):
    """Largest change of the energy since the start, over the energy of the vibration."""
    return np.max(np.abs(history(run).energy)) / Bar.of(run).energy


def energy_growth(run):
    """Largest rise of the energy above any earlier value, over the energy of the vibration. Newmark's method conserves
    or dissipates the energy plus (beta - gamma / 2) dt^2 times half the sum of m a^2 (Krenk 2006, Comput. Methods Appl.
    Mech. Eng. 195); that is the energy itself if 2 beta = gamma."""
    energy = history(run).energy
    return np.max(energy - np.minimum.accumulate(energy)) / Bar.of(run).energy
