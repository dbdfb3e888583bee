"""The effect of single changes of a scene on the resistance of several shapes: table and chart."""
import matplotlib.pyplot as plt
import numpy as np


class Changes:
    """Mean resistance (Pa) by shape and change, over the last 10 mm of the distance that all results have in common.
    The first result of a shape is its unchanged scene."""

    def __init__(self, results, label):
        self.distance = min(result.case.distance for result in results)
        self.shapes = list(dict.fromkeys(result.case.shape for result in results))
        self.unchanged, self._changed = {}, {}
        for result in results:
            case, value = result.case, result.mean_up_to(self.distance)
            if case.shape not in self.unchanged:
                self.unchanged[case.shape] = value
            else:
                self._changed[case.shape, label(case)] = value
        self.labels = list(dict.fromkeys(change for _, change in self._changed))

    def difference(self, shape, change):
        """Change over the unchanged resistance; None where there is no such run."""
        value = self._changed.get((shape, change))
        return value and value / self.unchanged[shape] - 1.


def rows(changes):
    """Head and rows of a table."""
    lines = [["none", *(f"{1e-3 * changes.unchanged[shape]:.1f} kPa" for shape in changes.shapes)]]
    for change in changes.labels:
        found = [changes.difference(shape, change) for shape in changes.shapes]
        lines.append([change, *("-" if difference is None else f"{100. * difference:+.1f} %" for difference in found)])
    return ["change", *changes.shapes], lines


def draw(changes, path):
    """Draws a group of bars per change, the first on top."""
    figure, axes = plt.subplots(figsize=(8, 0.8 + 0.45 * len(changes.labels)), layout="constrained")
    height = 0.8 / len(changes.shapes)
    at = np.arange(len(changes.labels))
    for number, shape in enumerate(changes.shapes):
        values = [100. * (changes.difference(shape, change) or 0.) for change in changes.labels]
        axes.barh(at + (number - (len(changes.shapes) - 1) / 2.) * height, values, height, label=shape)
    axes.axvline(0., color="0.3", linewidth=0.8)
    axes.set_yticks(at, changes.labels)
    axes.invert_yaxis()
    axes.set_xlabel("change of resistance / %")
    axes.legend(fontsize=8)
    figure.savefig(path, dpi=90, metadata={"Software": None})
    plt.close(figure)
