"""The resistance of several shapes over one parameter: tables and charts as the authors' figures 11 and 12."""
import matplotlib.pyplot as plt


class Limits:
    """Mean resistance (Pa) by parameter and shape, over the last 10 mm of the distance that all results have in
    common."""

    def __init__(self, results, of):
        self.distance = min(result.case.distance for result in results)
        self.shapes = list(dict.fromkeys(result.case.shape for result in results))
        self.parameters = sorted({of(result.case) for result in results})
        self._results = {(of(result.case), result.case.shape): result for result in results}

    def at(self, parameter, shape):
        """Resistance of one run, Pa; None where there is no such run."""
        result = self._results.get((parameter, shape))
        return result and result.mean_up_to(self.distance)

    def curve(self, shape):
        """Parameters and resistances of the runs that are there."""
        pairs = [(parameter, self.at(parameter, shape)) for parameter in self.parameters]
        return tuple(zip(*(pair for pair in pairs if pair[1] is not None)))

    def wall_time(self, parameter):
        """Wall time of all shapes, s."""
        return sum(result.record["wall time"] for (other, _), result in self._results.items() if other == parameter)


def rows(limits):
    """Head and rows of a table: resistances, their ratios to the first shape's, and what they cost."""
    first, *others = limits.shapes
    head = [*(f"{shape} / kPa" for shape in limits.shapes), *(f"{shape} over {first}" for shape in others),
            "wall time / s"]
    lines = []
    for parameter in limits.parameters:
        values = [limits.at(parameter, shape) for shape in limits.shapes]
        ratios = [value / values[0] if value and values[0] else None for value in values[1:]]
        lines.append([f"{parameter:g}", *(f"{1e-3 * value:.1f}" if value else "-" for value in values),
                      *(f"{ratio:.2f}" if ratio else "-" for ratio in ratios), f"{limits.wall_time(parameter):.0f}"])
    return head, lines


def draw(limits, label, path):
    """Draws a line per shape."""
    figure, axes = plt.subplots(figsize=(7, 4.4))
    for shape in limits.shapes:
        parameters, values = limits.curve(shape)
        axes.plot(parameters, [1e-3 * value for value in values], marker="o", label=shape)
    axes.set_ylim(bottom=0.)
    axes.set_xlabel(label)
    axes.set_ylabel("resistance / kPa")
    axes.legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(path, dpi=90, metadata={"Software": None})
    plt.close(figure)
