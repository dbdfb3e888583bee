"""Resistance of a body over its displacement, and a fitted hyperbola."""
from dataclasses import dataclass

import numpy as np

from . import PlotError


@dataclass
class Curve:
    """Displacement (m) and resistance (N) along one axis; the resistance of a body that is pulled along its motion is
    positive."""
    displacement: np.ndarray
    force: np.ndarray
    axis: str
    body: int


def resistance_curve(columns, choice, factor=1., zero=False, start=None):
    """The curve from the columns of rigid_body.csv.

    choice: a choice.Choice of body, axis and stages. factor: 2 for a half model. zero: subtract the first value of the
    force. start: position of the body before the first of these rows, m; default: that of the row before, if it belongs
    to the same motion, or of the first one.
    """
    body, axis = choice.body, choice.axis

    def column(field, axis):
        name = f"body{body}_{field}_{axis}"
        if name not in columns:
            bodies = sorted({key.split("_")[0] for key in columns if key.startswith("body")})
            raise PlotError(f"rigid_body.csv, or an earlier part of it, has no column \"{name}\"; bodies in it: "
                            f"{', '.join(bodies) or 'none'}")
        return columns[name]

    rows = np.ones(len(columns["time"]), dtype=bool)
    first = 0
    if choice.stages:
        rows = np.isin(columns["stage"], choice.stages) if "stage" in columns else np.zeros_like(rows)
        if not rows.any():
            raise PlotError(f"rigid_body.csv has no rows of stage {', '.join(map(str, choice.stages))}")
        first = max(np.flatnonzero(rows)[0] - choice.is_continued, 0)
    if axis is None:
        axis = max("xyz", key=lambda a: np.ptp(column("position", a)[rows]))
    origin = column("position", axis)[first]
    if start is not None:
        origin = start["xyz".index(axis)]
    travel = column("position", axis) - origin
    force = factor * column("reaction force", axis)
    if zero:
        force = force - force[first]
    direction = -1. if travel[rows][np.argmax(abs(travel[rows]))] < 0. else 1.
    return Curve(direction * travel[rows], direction * force[rows], axis, body)


@dataclass
class Hyperbola:
    """q = d / (1/stiffness + d/limit) with standard errors; the limit is the horizontal asymptote."""
    limit: float
    limit_error: float
    stiffness: float
    stiffness_error: float

    def __call__(self, displacement):
        return displacement / (1. / self.stiffness + displacement / self.limit)

    def displacement_at(self, share):
        """Displacement that reaches a share of the limit."""
        return share / (1. - share) * self.limit / self.stiffness


def fit_hyperbola(displacement, resistance):
    """Least squares of q = d / (a + b d) in q itself (Kondner 1963; Das & Seeley 1975 for anchors).

    The usual straight line through d/q is only the first guess: dividing by q would give the first, smallest values the
    largest weight. The standard errors assume independent residuals, so they are a lower bound for a curve with waves.
    """
    used = (displacement > 0.) & (resistance > 0.)
    d, q = displacement[used], resistance[used]
    if len(d) < 3:
        raise PlotError(f"a hyperbola needs three points with positive displacement and resistance, not {len(d)}")
    b, a = np.polyfit(d, d / q, 1)
    if b <= 0.:
        b = 0.5 / q.max()  # a curve that still grows like a straight line: start well above it
    a = max(a, 1e-3 * (d / q).max())

    def residual_and_slope(parameters):
        a, b = np.exp(parameters)  # both stay positive
        model = d / (a + b * d)
        return q - model, -(model**2 / d)[:, None] * np.column_stack([np.full_like(d, a), b * d])

    parameters, damping = np.log([a, b]), 1e-3  # Levenberg-Marquardt
    residual, slope = residual_and_slope(parameters)
    for _ in range(500):
        if parameters[1] + np.log(d.max()) < parameters[0] - 7.:  # b d < 0.001 a
            raise PlotError("no hyperbola fits: the curve does not bend towards an asymptote")
        normal = slope.T @ slope
        step = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), slope.T @ residual)
        trial, trial_slope = residual_and_slope(parameters + np.clip(step, -2., 2.))
        if trial @ trial <= residual @ residual:
            parameters, residual, slope = parameters + np.clip(step, -2., 2.), trial, trial_slope
            damping = max(damping / 5., 1e-12)
            if abs(step).max() < 1e-12:
                break
        else:
            damping *= 5.
            if damping > 1e12:
                break
    a, b = np.exp(parameters)
    variance = residual @ residual / (len(d) - 2)
    error_a, error_b = np.sqrt(np.diag(variance * np.linalg.pinv(slope.T @ slope)))  # relative: of log a, log b
    return Hyperbola(1. / b, error_b / b, 1. / a, error_a / a)
