"""Motion and energy of the bar, by the measures of the scene tests."""
import pathlib
import sys

sys.path.append(str(pathlib.Path(__file__).resolve().parents[2] / "tests" / "scenes"))

from measures import bar  # noqa: E402  (found only after the line above)


def motion(run, values):
    """Time (s) and shortening over the static one."""
    course = bar.history(run)
    return course.time, course.shortening / bar.Bar.of(run).static_shortening


def energy(run, values):
    """Time (s) and energy above that of the static state, in percent of its start."""
    course = bar.history(run)
    return course.time, 100. * (1. + course.energy / bar.Bar.of(run).energy)


def period(run, values):
    """Period, s."""
    return bar.period_of(bar.history(run))


def end_error(run, values):
    """Largest error of the free end's motion over the largest motion."""
    return bar.end_error(run)


def energy_left(run, values):
    """Share of the energy that is left at the end."""
    return bar.energy_left(run)


def energy_left_of_modes(run, values):
    """The same share for the bar's modes, each stepped by Newmark's method."""
    return bar.expected_energy_left(run)


def energy_growth(run, values):
    """Largest rise of the energy above any earlier value, as a share."""
    return bar.energy_growth(run)
