"""The page of the plate-anchor study: tables and charts of the runs that are there and of the records of the others."""
import dataclasses
import json
import pathlib
import textwrap

import matplotlib

matplotlib.use("Agg")
import changes  # noqa: E402  (matplotlib's back end is chosen first)
import limits  # noqa: E402
import numpy as np  # noqa: E402
import records  # noqa: E402
from cases import STATIC_STEP, WEIGHT, WIDTH, broms_square, limit_strip, rankine_strip, teng_square  # noqa: E402
from curves import draw_curves, draw_resolution  # noqa: E402
from kedge_plot import PlotError  # noqa: E402
from kedge_plot.resistance import fit_hyperbola  # noqa: E402
from labels import label, tolerance  # noqa: E402
from records import LAST, MOVED, mean_between  # noqa: E402
from sections import draw_sections  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
REFERENCE = json.loads((HERE / "reference.json").read_text(encoding="utf-8"))
LABORATORY = {shape: known["laboratory"] for shape, known in REFERENCE["shapes"].items()}  # Pa


@dataclasses.dataclass
class Result:
    """One run's record with pressures over the projected area in Pa."""
    case: object
    record: dict
    run: object  # the kept run, or None where only its record is there

    def __post_init__(self):
        self.displacement = np.array(self.record["displacement"])
        self.pressure = np.array(self.record["force"]) / self.case.area
        self.at_end = self.mean_up_to(self.displacement.max())
        try:
            self.fit = fit_hyperbola(self.displacement, self.pressure)
        except PlotError:
            self.fit = None

    def mean_up_to(self, distance):
        """Mean pressure over the last 10 mm of a distance (m), Pa."""
        return mean_between(self.displacement, self.pressure, distance - LAST, distance)


def find_results(cases, work, kept):
    """Results of the cases that ran here or whose record is in the folder `kept`; writes there the records of the
    runs."""
    results = []
    for case in cases:
        run, record = records.of_run(case, work)
        path = kept / f"{case.name}.json"
        if record:
            kept.mkdir(parents=True, exist_ok=True)
            path.write_text(records.as_text(record), encoding="utf-8")
        elif path.is_file():
            record = json.loads(path.read_text(encoding="utf-8"))
        if record:
            results.append(Result(case, record, run))
    return results


def write(parts, work, target, kept, is_whole):
    """Writes plate-anchors.md and its charts into the folder `target`, with the findings if the study is whole; returns
    the path of the page. The folder `kept` holds the records."""
    target.mkdir(parents=True, exist_ok=True)
    text = (HERE / "introduction.md").read_text(encoding="utf-8")
    for part, cases in parts.items():
        results = find_results(cases, work, kept)
        if len(results) > 1:  # a single result has no comparison
            text += "\n" + _part(part, results, target / f"plate-anchors-{part}.png")
        if part == "shapes" and results:
            text += "\n" + _sections(results, target)
    if is_whole:
        text += (HERE / "findings.md").read_text(encoding="utf-8")
    path = target / "plate-anchors.md"
    path.write_text(text, encoding="utf-8")
    return path


def _part(part, results, chart):
    """Text of one part; draws its chart."""
    if part == "sensitivity":
        return _sensitivity(results, chart)
    if part in _LIMITS:
        return _over_parameter(results, *_LIMITS[part], chart)
    if part == "resolution":
        draw_resolution(results, LABORATORY, chart)
    else:
        draw_curves(results, LABORATORY if part == "shapes" else None, chart)
    return _TEXTS[part](results) + f"\n![Resistance over displacement]({chart.name})\n"


def _paragraph(text):
    """A paragraph of the page, or nothing."""
    return textwrap.fill(text, 120, break_long_words=False, break_on_hyphens=False) + "\n\n" if text else ""


def _table(head, rows):
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def _fit(result):
    return f"{1e-3 * result.fit.limit:.1f} ± {1e-3 * result.fit.limit_error:.1f}" if result.fit else "-"


def _common(result):
    record = result.record
    steps = record["time steps"] or len(record["displacement"])  # explicit ones, or those of an implicit stage
    return [_fit(result), f"{1e-3 * result.at_end:.1f}", f"{record['material points']}", f"{steps}",
            f"{record['wall time']:.0f}"]


COMMON = ["hyperbola / kPa", "last 10 mm / kPa", "material points", "steps", "wall time / s"]


def _by_analysis(results):
    """A heading and its results: static equilibrium, which is quoted, and explicit dynamics."""
    static = [result for result in results if result.case.analysis == "static"]
    explicit = [result for result in results if result.case.analysis == "explicit"]
    pairs = ((f"Static equilibrium in steps of {1e3 * STATIC_STEP:g} mm", static), ("Explicit dynamics", explicit))
    return [pair for pair in pairs if pair[1]]


def _shapes(results):
    text = "## Shapes (table 2, figure 7)\n\n"
    for title, group in _by_analysis(results):
        first, rows = group[0], []
        for result in group:
            known, lab = REFERENCE["shapes"][result.case.shape], LABORATORY[result.case.shape]
            published = known["published"]
            rows.append([result.case.shape, *_common(result)[:2], f"{1e-3 * published:.1f}", f"{1e-3 * lab:.1f}",
                         f"{100. * (result.at_end / lab - 1.):+.0f} %", f"{100. * (published / lab - 1.):+.0f} %",
                         f"{result.at_end / first.at_end:.2f}", f"{known['shape factor']:.2f}",
                         f"{lab / LABORATORY[first.case.shape]:.2f}", *_common(result)[2:],
                         f"{result.record['cuts']}"])
        head = ["shape", *COMMON[:2], "published / kPa", "laboratory / kPa", "last 10 mm against laboratory",
                "published against laboratory", f"over {first.case.shape}", "published", "laboratory", *COMMON[2:],
                "cuts"]
        text += f"{title}:\n\n" + _table(head, rows) + "\n"
    return text + _mobilised(results)


def _mobilised(results):
    text = "### Mobilised soil (tables 3 and 4)\n\n" + _paragraph(
        f"The areas lie inside the line of {100. * MOVED:.0f} % of the plate's displacement, plate included, in front "
        "of the plate's back face and behind it. The mobilisation factor is the difference of the two over the area of "
        "the plate, divided by the same ratio of the thin square plate. The numbers in brackets are the paper's. It "
        "prints mm², but the areas would then be a few hundredths of the plate's own area, so it must mean cm²; its "
        "horizontal areas are those of the half model, as here.")
    for title, group in _by_analysis(results):
        rows, first = [], {}
        for result in group:
            row = [result.case.shape]
            for name in ("horizontal", "vertical"):
                front, back = result.record["mobilised"][name]
                published = REFERENCE["mobilised area"][result.case.shape][name]
                ratio = (front - back) / result.case.area
                factor = ratio / first.setdefault(name, ratio)
                known = REFERENCE["mobilisation factor"].get(result.case.shape, {})
                row += [f"{1e4 * front:.0f} ({published[0]:.0f})", f"{1e4 * back:.0f} ({published[1]:.0f})",
                        f"{factor:.2f}", f"{known.get(name, 1.):.2f}"]
                if name == "vertical":
                    row.append(f"{known.get('laboratory, vertical', 1.):.2f}")
            rows.append(row)
        head = ["shape", "horizontal, front / cm²", "behind / cm²", "factor", "published", "vertical, front / cm²",
                "behind / cm²", "factor", "published", "laboratory"]
        text += f"{title}:\n\n" + _table(head, rows) + "\n"
    return text


_SECTIONS = {
    "stress": "Horizontal pressure −σxx in the horizontal section, line at 5 kPa of its mean over 15 mm",
    "displacement": "Displacement in the horizontal (left) and vertical section, line at 5 mm",
}


def _sections(results, target):
    """Stress and displacement of the runs that are there; the pictures of earlier ones stay."""
    text = "### Stress and displacement (figures 8 to 10)\n\n"
    runs = [(result.case, result.run) for result in _by_analysis(results)[0][1] if result.run]
    for name, caption in _SECTIONS.items():
        path = target / f"plate-anchors-{name}.png"
        if runs:
            draw_sections(runs, name, path)
        if path.is_file():
            text += f"{caption}, at the end of the pull.\n\n![{caption}]({path.name})\n\n"
    return text


def _over_distances(title, name, of, note="", columns=()):
    """Text with a row per run: beside its own means, those over the end of the distance that all have in common."""
    def text(results):
        distance = min(result.case.distance for result in results)
        rows = []
        for result in results:
            fit, at_end, *others = _common(result)
            rows.append([of(result.case), f"{1e3 * result.case.distance:g}", fit, at_end,
                         f"{1e-3 * result.mean_up_to(distance):.1f}", *others, *(show(result) for _, show in columns)])
        head = [name, "distance / mm", *COMMON[:2], f"{1e3 * (distance - LAST):g} to {1e3 * distance:g} mm / kPa",
                *COMMON[2:], *(head for head, _ in columns)]
        return f"## {title}\n\n{_paragraph(note)}" + _table(head, rows)
    return text


def _octree(results):
    """Compares all runs with the first."""
    rows, first = [], results[0]
    last = slice(len(first.pressure) // 2, None)
    for result in results:
        record, case = result.record, result.case
        reference = np.interp(result.displacement, first.displacement, first.pressure)
        mesh = "uniform" if case.uniform else (f"{1e3 * case.around:g} mm up to {1e3 * case.reach:g} mm, "
                                               f"then {1e3 * case.base:g} mm")
        rows.append([mesh, f"{record['cells']}", f"{record['dofs']}",
                     f"{record['material points']}", f"{record['time steps']}", f"{1e-6 * record['peak memory']:.0f}",
                     f"{record['wall time']:.0f}", f"{first.record['wall time'] / record['wall time']:.1f}",
                     f"{1e-3 * result.pressure[last].mean():.1f}",
                     f"{100. * (result.pressure[last].mean() / reference[last].mean() - 1.):+.1f} %"])
    return "## Octree against a uniform mesh\n\n" + _paragraph(
        "The box of 0.8 x 0.12 x 0.32 m is small enough for cells of 10 mm everywhere; the pull goes over 10 mm. "
        "Resistances are means over the second half, because the uniform mesh rings for longer.") + _table(
            ["mesh", "cells", "dofs", "material points", "time steps", "peak memory / MB", "wall time / s",
             "times faster", "resistance / kPa", "difference"], rows)


def _variation(title, name, of, note="", columns=()):
    """Text with a row per run. columns: further ones, each a head and what a result shows there."""
    def text(results):
        rows = [[of(result.case), *_common(result), *(show(result) for _, show in columns)] for result in results]
        return f"## {title}\n\n{_paragraph(note)}" + _table([name, *COMMON, *(head for head, _ in columns)], rows)
    return text


def _static_means(distance):
    return ("Static equilibrium, cells of 10 mm at the plate and along its path; "
            f"means from {1e3 * (distance - LAST):g} to {1e3 * distance:g} mm")


def _over_parameter(results, title, name, of, note, chart):
    """A row per value of a parameter with all shapes, and their chart."""
    found = limits.Limits(results, of)
    limits.draw(found, name, chart)
    head, rows = limits.rows(found)
    note = _paragraph(f"{note}{_static_means(found.distance)}; the wall time is that of all shapes.")
    return f"## {title}\n\n{note}" + _table([name, *head], rows) + f"\n![{title}]({chart.name})\n"


def _sensitivity(results, chart):
    """The effect of each case compared with the first one of its shape."""
    first = {result.case.shape: result.case for result in reversed(results)}
    found = changes.Changes(results, lambda case: label(case, [case, first[case.shape]]))
    changes.draw(found, chart)
    title = "What the long frustum's resistance depends on"
    note = _paragraph("Each row changes one thing; the plate's friction stays as it is unless it is the change. "
                      f"{_static_means(found.distance)}.")
    return f"## {title}\n\n{note}" + _table(*changes.rows(found)) + f"\n![{title}]({chart.name})\n"


def _cells(case):
    return (f"{case.shape}, {case.analysis}, {1e3 * case.cell:g}, {1e3 * case.around:g}, {1e3 * case.base:g}"
            + tolerance(case, "; "))


def _rate(case):
    if case.analysis == "static":
        return "static"
    return f"{1e3 * case.velocity:g} mm/s, {case.mass_scaling:g}, {case.analysis}"


def _embedment(case):
    return f"{case.depth / WIDTH:g}" + (", strip" if 2. * case.half_width < WIDTH else "")


def _formula(of):
    return lambda result: f"{1e-3 * of(result.case):.1f}"


def _per_overburden(result):
    return f"{result.at_end / (WEIGHT * result.case.depth):.1f}"


_TEXTS = {
    "shapes": _shapes,
    "resolution": _over_distances(
        "Resolution", "shape, analysis, cells at the plate, around it, beyond / mm", _cells,
        "The first column gives the cells at the plate's surface, around it or its path, and beyond. In explicit "
        "dynamics cells of 20 mm beyond begin 80 mm from the plate.",
        [("cuts", lambda result: f"{result.record['cuts']}")]),
    "rate": _over_distances("Loading rate (figure 6)", "velocity, mass scaling", _rate),
    "stiffness": _variation("Young's modulus (figure 13)", "E / MPa", lambda case: f"{1e-6 * case.young:g}"),
    "dilatancy": _variation("Dilatancy", "angle / °", lambda case: f"{case.dilation_angle:g}"),
    "interface": _variation("Friction of plate and sand", "tan δ / tan φ", lambda case: f"{case.roughness:g}"),
    "embedment": _variation(
        "Embedment", "depth of the axis / B", _embedment,
        "The last columns give formulas for limit loads: limit analysis of a rough strip in plane strain that cannot "
        "rise (φ = ψ = 35°, within 8 % to either side), Rankine's wedges on an infinitely wide wall, the same with "
        "friction on the sides of a square plate (Teng 1962), and three times Rankine's passive pressure (Broms 1964).",
        [("last 10 mm / γ depth", _per_overburden), ("strip, limit analysis / kPa", _formula(limit_strip)),
         ("strip, Rankine / kPa", _formula(rankine_strip)), ("square, Teng / kPa", _formula(teng_square)),
         ("square, Broms / kPa", _formula(broms_square))]),
    "octree": _octree,
}

_LIMITS = {
    "friction": ("Friction angle (figure 12)", "friction angle / °", lambda case: case.friction_angle,
                 "The plate's friction is the tangent of the same angle. "),
    "group": ("Group effect (figure 11)", "spacing / B", lambda case: round(2. * case.half_width / WIDTH, 6),
              "One of a row of plates, whose spacing is the box's width. "),
}
