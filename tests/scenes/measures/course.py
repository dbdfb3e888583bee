"""Measures of any run: iterations, cuts, differences."""
import numpy as np


def most_iterations(*runs):
    """Largest number of Newton iterations of any step."""
    return max(max(run.newton_iterations) for run in runs)


def mean_iterations(*runs):
    """Newton iterations per step."""
    stages = [stage for run in runs for stage in run.stages]
    return sum(stage["newton iterations"] for stage in stages) / sum(stage["steps"] for stage in stages)


def cuts(*runs):
    """Number of steps that were cut."""
    return sum(stage["cuts"] for run in runs for stage in run.stages)


def middle_of_cuts(*runs):
    """Number of steps that were cut in the middle one of runs that differ so little that only chance tells them apart:
    a step that fails may fail again in its parts."""
    return float(np.median([cuts(run) for run in runs]))


def deepest_penetration(*runs):
    """Deepest penetration of any corner into a body at the end of any step, m."""
    return max(stage["deepest penetration"] for run in runs for stage in run.stages)


def largest_difference(first, second, columns):
    """Largest difference between two runs in the given columns of the material points, over each column's largest
    value."""
    return max(np.max(np.abs(first.points(name) - second.points(name))) / np.max(np.abs(first.points(name)))
               for name in columns)


def largest_body_difference(first, second, columns):
    """The same for columns of the table of rigid bodies, at the times that both runs have: one may have cut a step."""
    times, here, there = np.intersect1d(np.round(first.body("time"), 9), np.round(second.body("time"), 9),
                                        return_indices=True)
    if len(times) < 0.9 * len(first.body("time")):
        raise ValueError("the runs have few times in common")
    return max(np.max(np.abs(first.body(name)[here] - second.body(name)[there])) / np.max(np.abs(first.body(name)))
               for name in columns)


def mean_body_difference(first, second, column):
    """Mean of a column of the table of rigid bodies in the first run over that in the second, less one."""
    return np.mean(first.body(column)) / np.mean(second.body(column)) - 1.


def largest_value(run, column):
    """Largest size of a number in a column of the material points at the end, in its unit."""
    return float(np.max(np.abs(run.points(column))))


def share_of_points(first, second):
    """Number of material points at the end of the first run, over that of the second."""
    counts = [run.stages[-1]["material points"] for run in (first, second)]
    return counts[0] / counts[1]
