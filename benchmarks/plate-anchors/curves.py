"""Charts of resistance over displacement."""
import matplotlib.pyplot as plt
from labels import has_own_tolerance, label, tolerance


def draw_resolution(results, laboratory, path):
    """A panel per shape. laboratory: the measured resistance by shape, Pa."""
    shapes = list(dict.fromkeys(result.case.shape for result in results))
    n_rows = (len(shapes) + 1) // 2
    figure, panels = plt.subplots(n_rows, 2, figsize=(10, 3.6 * n_rows), squeeze=False, layout="constrained")
    for panel, shape in zip(panels.flat, shapes):
        for result in (result for result in results if result.case.shape == shape):
            _add_resolution(panel, result)
        panel.axhline(1e-3 * laboratory[shape], color="0.4", linestyle="--", linewidth=0.8, label="laboratory")
        panel.set(title=shape, xlim=(0., None), ylim=(0., None), xlabel="displacement / mm", ylabel="resistance / kPa")
        panel.legend(fontsize=7, loc="lower right")
    figure.savefig(path, dpi=90, metadata={"Software": None})
    plt.close(figure)


def _add_resolution(panel, result):
    """One curve; its style says the analysis and the tolerance, its colour the cells."""
    case = result.case
    is_fine_beyond = case.base < type(case).base
    style = ":" if case.analysis == "explicit" else "--" if has_own_tolerance(case) else "-"
    beyond = f", beyond {1e3 * case.base:g} mm" if is_fine_beyond else ""
    panel.plot(1e3 * result.displacement, 1e-3 * result.pressure, linestyle=style,
               linewidth=0.7 if has_own_tolerance(case) else 1.,
               color=f"C{(0.02, 0.01, 0.005).index(case.cell) + (3 if is_fine_beyond else 0)}",
               label=f"{case.analysis}, {1e3 * case.cell:g} mm{tolerance(case, ', ')}{beyond}")


def draw_curves(results, laboratory, path):
    """All curves in one chart. laboratory: None, or the measured resistance by shape, Pa; curves of the same shape then
    share a colour, and those of explicit dynamics are dotted."""
    figure, axes = plt.subplots(figsize=(9, 4.4))
    cases = [result.case for result in results]
    shapes = list(dict.fromkeys(case.shape for case in cases))
    for number, result in enumerate(results):
        is_dotted = laboratory is not None and result.case.analysis == "explicit"
        colour = shapes.index(result.case.shape) if laboratory is not None else number
        axes.plot(1e3 * result.displacement, 1e-3 * result.pressure, color=f"C{colour}",
                  linestyle=":" if is_dotted else "-", linewidth=1. if is_dotted else 1.5,
                  label=label(result.case, cases))
    if laboratory is not None:
        for number, shape in enumerate(shapes):
            axes.axhline(1e-3 * laboratory[shape], color=f"C{number}", linestyle="--", linewidth=0.8)
        axes.plot([], [], color="0.4", linestyle="--", linewidth=0.8, label="laboratory, at large displacement")
    axes.set_xlim(left=0.)
    axes.set_ylim(bottom=0.)
    axes.set_xlabel("displacement / mm")
    axes.set_ylabel("resistance / kPa")
    axes.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.01, 1.))
    figure.tight_layout()
    figure.savefig(path, dpi=90, metadata={"Software": None})
    plt.close(figure)
