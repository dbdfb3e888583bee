"""Tables and charts of the plate-anchor study, from the runs that are there."""
import dataclasses
import json
import pathlib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from cases import mean_at_end  # noqa: E402
from kedge_plot import PlotError  # noqa: E402
from kedge_plot.resistance import fit_hyperbola, resistance_curve  # noqa: E402
from kedge_plot.run import Run  # noqa: E402
from kedge_plot.section import cut  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
REFERENCE = json.loads((HERE / "reference.json").read_text(encoding="utf-8"))
MOVED = 0.1  # of the plate's own displacement: what counts as mobilised soil


@dataclasses.dataclass
class Result:
    """One run. Pressures over the projected area in Pa, areas in m2."""
    case: object
    run: Run
    curve: object
    at_end: float  # mean over the last 10 mm
    fit: object  # or None

    @classmethod
    def of(cls, case, work):
        """None where the run is not there."""
        try:
            run = Run(work / case.name)
            curve = resistance_curve(run.body_history(), axis="x", factor=2., start=run.start_of(1))
        except PlotError:
            return None
        curve.force = curve.force / case.area
        try:
            fit = fit_hyperbola(curve.displacement, curve.force)
        except PlotError:
            fit = None
        return cls(case, run, curve, mean_at_end(curve), fit)

    @property
    def is_whole(self):
        return self.curve.displacement.max() > 0.999 * self.case.distance

    def cost(self):
        """Material points, time steps and seconds."""
        summary = self.run.summary()
        stage = summary["stages"][-1]
        return stage["material points"], stage["time steps"], summary["wall time"]["total"]

    def mobilised(self, plane, at):
        """Areas in a section of the half model with more than MOVED of the plate's displacement, in front of and behind
        its back face."""
        grids, step = self.run.soil()
        section = cut(grids, self.run.surface(step), plane, at, "displacement magnitude")
        moved = section.values > MOVED * self.curve.displacement.max()
        centre = (section.lower[:, 0] + section.upper[:, 0]) / 2.
        front = centre > 0.4 + self.curve.displacement.max()
        areas = section.areas()
        return areas[moved & front].sum(), areas[moved & ~front].sum()


def write(parts, work, target):
    """Writes plate-anchors.md and its charts; returns the report's path."""
    target.mkdir(parents=True, exist_ok=True)
    text = (HERE / "introduction.md").read_text(encoding="utf-8")
    for part, cases in parts.items():
        results = [result for case in cases if (result := Result.of(case, work))]
        if results:
            _draw_curves(results, part, target / f"plate-anchors-{part}.png")
            text += "\n" + _TEXTS[part](results) + f"\n![Resistance over displacement](plate-anchors-{part}.png)\n"
    path = target / "plate-anchors.md"
    path.write_text(text, encoding="utf-8")
    return path


def _table(head, rows):
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def _fit(result):
    return f"{1e-3 * result.fit.limit:.1f} ± {1e-3 * result.fit.limit_error:.1f}" if result.fit else "-"


def _state(result):
    return "" if result.is_whole else f" (up to {1e3 * result.curve.displacement.max():.0f} mm)"


def _common(result):
    points, steps, seconds = result.cost()
    return [_fit(result), f"{1e-3 * result.at_end:.1f}", f"{points}", f"{steps}", f"{seconds:.0f}"]


COMMON = ["hyperbola / kPa", "last 10 mm / kPa", "material points", "time steps", "wall time / s"]


def _shapes(results):
    text = "## Shapes (table 2, figure 7)\n\n"
    first = results[0]
    rows = []
    for result in results:
        known = REFERENCE["shapes"][result.case.shape]
        lab, published = known["laboratory"], known["published"]
        rows.append([result.case.shape + _state(result), *_common(result)[:2], f"{1e-3 * published:.1f}", f"{1e-3 * lab:.1f}",
                     f"{100. * (result.at_end / lab - 1.):+.0f} %", f"{result.at_end / first.at_end:.2f}",
                     f"{known['shape factor']:.2f}", f"{lab / REFERENCE['shapes']['TS']['laboratory']:.2f}",
                     *_common(result)[2:]])
    text += _table(["shape", *COMMON[:2], "published / kPa", "laboratory / kPa", "last 10 mm against laboratory",
                    f"over {first.case.shape}", "published", "laboratory", *COMMON[2:]], rows)
    return text + "\n" + _mobilised(results)


def _mobilised(results):
    text = f"""### Mobilised soil (tables 3 and 4)

Area that moved by more than {100. * MOVED:.0f} % of the plate's way, in front of the plate's back face and behind it, and the
mobilisation factor: the difference of the two over the area of the plate, over the same ratio of the thin square plate. In
brackets what the paper prints, in mm²: less than a hundredth of the plate's own area, so that cm² must be meant, and the horizontal
ones of the half model, as here.

"""
    rows, first = [], {}
    for result in results:
        row = [result.case.shape]
        for name, plane, at in (("horizontal", "z", 0.32 - result.case.depth), ("vertical", "y", 0.)):
            try:
                front, back = result.mobilised(plane, at)
            except PlotError:
                row += ["-"] * (5 if name == "vertical" else 4)
                continue
            published = REFERENCE["mobilised area"][result.case.shape][name]
            ratio = (front - back) / result.case.area
            factor = ratio / first.setdefault(name, ratio)
            known = REFERENCE["mobilisation factor"].get(result.case.shape, {})
            row += [f"{1e4 * front:.0f} ({published[0]:.0f})", f"{1e4 * back:.0f} ({published[1]:.0f})", f"{factor:.2f}", f"{known.get(name, 1.):.2f}"]
            if name == "vertical":
                row.append(f"{known.get('laboratory, vertical', 1.):.2f}")
        rows.append(row)
    return text + _table(["shape", "horizontal, front / cm²", "behind / cm²", "factor", "published", "vertical, front / cm²",
                          "behind / cm²", "factor", "published", "laboratory"], rows)


def _octree(results):
    """The first run is what the others are compared with."""
    rows, first = [], results[0]
    for result in results:
        stage, summary = result.run.summary()["stages"][-1], result.run.summary()
        reference = np.interp(result.curve.displacement, first.curve.displacement, first.curve.force)
        difference = result.curve.force - reference
        rows.append(["uniform" if result.case.uniform else "octree", f"{stage['cells']}", f"{stage['dofs']}",
                     f"{stage['material points']}", f"{stage['time steps']}", f"{1e-6 * summary['peak memory']:.0f}",
                     f"{result.cost()[2]:.0f}", f"{first.cost()[2] / result.cost()[2]:.1f}",
                     f"{1e-3 * result.curve.force[-1]:.2f}", f"{100. * difference[-1] / reference[-1]:+.1f} %",
                     f"{100. * np.abs(difference).sum() / reference.sum():.1f} %"])
    return "## Octree against a uniform mesh\n\nThe same scene over 3 mm.\n\n" + _table(
        ["mesh", "cells", "dofs", "material points", "time steps", "peak memory / MB", "wall time / s", "times faster",
         "resistance at the end / kPa", "difference there", "mean difference"], rows)


def _variation(title, name, of, note=""):
    def text(results):
        rows = [[of(result.case) + _state(result), *_common(result)] for result in results]
        return f"## {title}\n\n{note}" + _table([name, *COMMON], rows)
    return text


_TEXTS = {
    "shapes": _shapes,
    "resolution": _variation("Resolution", "cells / mm", lambda case: f"{1e3 * case.cell:g}"),
    "rate": _variation("Loading rate (figure 6)", "velocity, mass scaling",
                       lambda case: f"{1e3 * case.velocity:g} mm/s, {case.mass_scaling:g}"),
    "friction": _variation("Friction angle (figure 12)", "angle / °", lambda case: f"{case.friction_angle:g}",
                           "The plate's friction is the tangent of the same angle.\n\n"),
    "stiffness": _variation("Young's modulus (figure 13)", "E / MPa", lambda case: f"{1e-6 * case.young:g}"),
    "group": _variation("Group effect (figure 11)", "spacing / B", lambda case: f"{2. * case.half_width / 0.1:g}"),
    "octree": _octree,
    "embedment": _variation("Where the plate lies", "depth of the axis / m", lambda case: f"{case.depth:g}"),
}


def _label(case, cases):
    """What tells a case from the others of its part."""
    fields = [field.name for field in dataclasses.fields(case) if len({getattr(other, field.name) for other in cases}) > 1]
    return ", ".join(f"{name.replace('_', ' ')} {getattr(case, name)}" for name in fields) or case.name


def _draw_curves(results, part, path):
    figure, axes = plt.subplots(figsize=(7, 4.4))
    cases = [result.case for result in results]
    for number, result in enumerate(results):
        axes.plot(1e3 * result.curve.displacement, 1e-3 * result.curve.force, color=f"C{number}",
                  label=_label(result.case, cases))
        if part == "shapes":
            axes.axhline(1e-3 * REFERENCE["shapes"][result.case.shape]["laboratory"], color=f"C{number}", linestyle="--",
                         linewidth=0.8)
    if part == "shapes":
        axes.plot([], [], color="0.4", linestyle="--", linewidth=0.8, label="laboratory, at large displacement")
    axes.set_xlim(left=0.)
    axes.set_ylim(bottom=0.)
    axes.set_xlabel("displacement / mm")
    axes.set_ylabel("resistance / kPa")
    axes.legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(path, dpi=90, metadata={"Software": None})
    plt.close(figure)
