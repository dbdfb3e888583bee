"""Order, limit and uncertainty of an answer under refinement, and the runs that nothing beats."""
from dataclasses import dataclass

import numpy as np

SAFETY, SAFETY_WITHOUT_ORDER = 1.25, 3.  # factors of Roache's grid convergence index
ORDERS = (0.1, 8.)  # an order beyond these says that the answers do not converge
HIGHEST_TRUSTED = 2.  # order for the uncertainty: higher ones are luck, since linear elements have no more


@dataclass
class Convergence:
    """order: None where the answers swing or diverge. limit: Richardson's, else the finest answer. uncertainty: of the
    limit, in the unit of the answer."""
    order: object
    limit: float
    uncertainty: float

    def text(self, form="{:.4g}"):
        """For tables and legends."""
        order = f"order {self.order:.2g}" if self.order else "no order"
        return f"{order}, limit {form.format(self.limit)} ± {self.uncertainty:.2g}"


def richardson(sizes, answers):
    """Convergence of the answers on the three smallest sizes. The order solves f1 - f2 = C (h1^p - h2^p), so the sizes
    may have any ratios. The uncertainty is the grid convergence index of the finest size with the safety factor 1.25
    and an order of at most 2, or 3 with order 1 where there is none (Roache 1994, doi 10.1115/1.2910291; Celik et al.
    2008, doi 10.1115/1.2960953). None with fewer than three sizes."""
    order_of_sizes = np.argsort(sizes)[:3]
    if len(order_of_sizes) < 3:
        return None
    h, f = np.asarray(sizes, float)[order_of_sizes], np.asarray(answers, float)[order_of_sizes]
    order = _order(h, f)
    ratio = h[1] / h[0]
    if order is None:
        return Convergence(None, f[0], SAFETY_WITHOUT_ORDER * abs(f[1] - f[0]) / (ratio - 1.))
    correction = (f[0] - f[1]) / (ratio**order - 1.)
    careful = (f[0] - f[1]) / (ratio**min(order, HIGHEST_TRUSTED) - 1.)
    return Convergence(order, f[0] + correction, SAFETY * abs(careful))


def _order(h, f):
    """The p for which (f3 - f2) / (f2 - f1) = (h3^p - h2^p) / (h2^p - h1^p), by bisection."""
    fine, coarse = f[1] - f[0], f[2] - f[1]
    if fine == 0. or coarse / fine <= 0.:
        return None

    def excess(p):
        return (h[2]**p - h[1]**p) / (h[1]**p - h[0]**p) - coarse / fine

    low, high = ORDERS
    if excess(low) > 0. or excess(high) < 0.:
        return None
    for _ in range(60):
        middle = (low + high) / 2.
        low, high = (middle, high) if excess(middle) < 0. else (low, middle)
    return (low + high) / 2.


def order_of_errors(sizes, errors):
    """Slope of log error over log size, by least squares; None where an error is zero or there are fewer than two."""
    sizes, errors = np.asarray(sizes, float), np.abs(np.asarray(errors, float))
    if len(sizes) < 2 or (errors == 0.).any():
        return None
    return float(np.polyfit(np.log(sizes), np.log(errors), 1)[0])


def pareto_front(costs, errors):
    """Positions of the points that no other beats in both, by rising cost."""
    front, best = [], np.inf
    for index in sorted(range(len(costs)), key=lambda i: (costs[i], errors[i])):
        if errors[index] < best:
            front.append(index)
            best = errors[index]
    return front
