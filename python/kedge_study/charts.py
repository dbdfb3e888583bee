"""Charts of a part of a study: one figure with a panel for each question."""
import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402  (after the choice of the back end)

from . import panels  # noqa: E402

WIDTH, HEIGHT = 5.4, 3.9  # of a panel, inches
PER_ROW = 3
STYLE = {"font.size": 9, "axes.titlesize": 9, "legend.fontsize": 7, "legend.frameon": False, "svg.fonttype": "none",
         "svg.hashsalt": "kedge", "xtick.direction": "in", "ytick.direction": "in", "axes.grid": True,
         "grid.linewidth": 0.3, "axes.prop_cycle": plt.cycler(color=plt.get_cmap("tab10").colors)}
DRAW = {"curves": panels.curves, "cost": panels.cost, "convergence": panels.convergence, "over": panels.over,
        "changes": panels.changes}


def charts_of(study, part):
    """The panels of a part: those that it names, or those that suit it."""
    if "charts" in part:
        return part["charts"]
    result = [{"kind": "curves"}] if study.curves else []
    if "one at a time" in part and study.answers:
        result.append({"kind": "changes"})
    if study.references:
        result.append({"kind": "cost"})
    return result


def draw(study, part, results, path):
    """Draws a part into PATH.png and PATH.svg; returns whether there was anything to draw."""
    drawable = [(chart, shown) for chart in charts_of(study, part)
                if panels.has_content(study, chart, shown := panels.shown(study, chart, results))]
    if not drawable:
        return False
    rows = -(-len(drawable) // PER_ROW)
    columns = min(len(drawable), PER_ROW)
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(rows, columns, figsize=(WIDTH * columns, HEIGHT * rows), squeeze=False,
                                    layout="constrained")
        for panel, (chart, shown) in zip(axes.flat, drawable):
            DRAW[chart["kind"]](panel, study, part, chart, shown)
            if "title" in chart:
                panel.set_title(chart["title"])
        for panel in axes.flat[len(drawable):]:
            panel.set_axis_off()
        figure.savefig(path.with_suffix(".png"), dpi=100, metadata={"Software": None})
        figure.savefig(path.with_suffix(".svg"), metadata={"Date": None, "Creator": None})
        plt.close(figure)
    return True
