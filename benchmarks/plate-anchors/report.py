"""Tables and charts of the plate-anchor study, from the runs that are there and the records of those that are not."""
import dataclasses
import json
import pathlib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import changes  # noqa: E402
import limits  # noqa: E402
import numpy as np  # noqa: E402
import records  # noqa: E402
from cases import STATIC_STEP, WEIGHT, WIDTH, broms_square, limit_strip, rankine_strip, teng_square  # noqa: E402
from kedge_plot import PlotError  # noqa: E402
from kedge_plot.resistance import fit_hyperbola  # noqa: E402
from records import LAST, MOVED, mean_between  # noqa: E402
from sections import draw_sections  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
REFERENCE = json.loads((HERE / "reference.json").read_text(encoding="utf-8"))


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

    def mean_up_to(self, way):
        """Over the last 10 mm of a way (m)."""
        return mean_between(self.displacement, self.pressure, way - LAST, way)


def find_results(cases, work, kept):
    """Those of the cases that ran or, where they did not run here, whose record is kept. Writes the records of the runs."""
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
    """Writes plate-anchors.md and its charts, with what was found if the study is whole; returns the report's path. Records are kept in the
    folder `kept`."""
    target.mkdir(parents=True, exist_ok=True)
    text = (HERE / "introduction.md").read_text(encoding="utf-8")
    for part, cases in parts.items():
        results = find_results(cases, work, kept)
        if len(results) > 1:  # nothing to compare otherwise
            chart = target / f"plate-anchors-{part}.png"
            if part == "sensitivity":
                text += "\n" + _sensitivity(results, chart)
            elif part in _LIMITS:
                text += "\n" + _over_parameter(results, *_LIMITS[part], chart)
            else:
                (_draw_resolution if part == "resolution" else _draw_curves)(results, part, chart)
                text += "\n" + _TEXTS[part](results) + f"\n![Resistance over displacement]({chart.name})\n"
        if part == "shapes" and results:
            text += "\n" + _sections(results, target)
    if is_whole:
        text += (HERE / "findings.md").read_text(encoding="utf-8")
    path = target / "plate-anchors.md"
    path.write_text(text, encoding="utf-8")
    return path


def _table(head, rows):
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def _fit(result):
    return f"{1e-3 * result.fit.limit:.1f} ± {1e-3 * result.fit.limit_error:.1f}" if result.fit else "-"


def _common(result):
    record = result.record
    steps = record["time steps"] or len(record["displacement"])  # explicit ones, or those of an implicit stage
    return [_fit(result), f"{1e-3 * result.at_end:.1f}", f"{record['material points']}", f"{steps}", f"{record['wall time']:.0f}"]


COMMON = ["hyperbola / kPa", "last 10 mm / kPa", "material points", "steps", "wall time / s"]


def _by_analysis(results):
    """A heading and its results: static equilibrium, which is quoted, and explicit dynamics."""
    static = [result for result in results if result.case.analysis == "static"]
    explicit = [result for result in results if result.case.analysis == "explicit"]
    return [pair for pair in ((f"Static equilibrium in steps of {1e3 * STATIC_STEP:g} mm", static), ("Explicit dynamics", explicit)) if pair[1]]


def _shapes(results):
    text = "## Shapes (table 2, figure 7)\n\n"
    for title, group in _by_analysis(results):
        first, rows = group[0], []
        for result in group:
            known = REFERENCE["shapes"][result.case.shape]
            lab, published = known["laboratory"], known["published"]
            rows.append([result.case.shape, *_common(result)[:2], f"{1e-3 * published:.1f}", f"{1e-3 * lab:.1f}",
                         f"{100. * (result.at_end / lab - 1.):+.0f} %", f"{100. * (published / lab - 1.):+.0f} %",
                         f"{result.at_end / first.at_end:.2f}", f"{known['shape factor']:.2f}",
                         f"{lab / REFERENCE['shapes'][first.case.shape]['laboratory']:.2f}", *_common(result)[2:],
                         f"{result.record['cuts']}"])
        text += f"{title}:\n\n" + _table(["shape", *COMMON[:2], "published / kPa", "laboratory / kPa", "last 10 mm against laboratory",
                                           "published against it", f"over {first.case.shape}", "published", "laboratory", *COMMON[2:],
                                           "cuts"], rows) + "\n"
    return text + _mobilised(results)


def _mobilised(results):
    text = f"""### Mobilised soil (tables 3 and 4)

Area inside the line of {100. * MOVED:.0f} % of the plate's way, plate included, in front of the plate's back face and behind it, and the
mobilisation factor: the difference of the two over the area of the plate, over the same ratio of the thin square plate. In
brackets what the paper prints, in mm²: a few hundredths of the plate's own area, so that cm² must be meant, and the horizontal
ones of the half model, as here.

"""
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
                row += [f"{1e4 * front:.0f} ({published[0]:.0f})", f"{1e4 * back:.0f} ({published[1]:.0f})", f"{factor:.2f}",
                        f"{known.get(name, 1.):.2f}"]
                if name == "vertical":
                    row.append(f"{known.get('laboratory, vertical', 1.):.2f}")
            rows.append(row)
        text += f"{title}:\n\n" + _table(["shape", "horizontal, front / cm²", "behind / cm²", "factor", "published",
                                           "vertical, front / cm²", "behind / cm²", "factor", "published", "laboratory"], rows) + "\n"
    return text


def _sections(results, target):
    """Stress and displacement of the runs that are there; the pictures of earlier ones stay."""
    text = "### Stress and displacement (figures 8 to 10)\n\n"
    runs = [(result.case, result.run) for result in _by_analysis(results)[0][1] if result.run]
    for name, caption in (("stress", "Horizontal pressure −σxx in the horizontal section, line at 5 kPa of its mean over 15 mm"),
                          ("displacement", "Displacement in the horizontal (left) and vertical section, line at 5 mm")):
        path = target / f"plate-anchors-{name}.png"
        if runs:
            draw_sections(runs, name, path)
        if path.is_file():
            text += f"{caption}, at the end of the pull.\n\n![{caption}]({path.name})\n\n"
    return text


def _has_own_tolerance(case):
    return case.tolerance != type(case).tolerance


def _tolerance(case, separator=""):
    """Said only where it is not the study's own."""
    return f"{separator}residuals {100. * case.tolerance:g} %" if _has_own_tolerance(case) else ""


def _over_ways(title, name, of, note="", columns=()):
    """A row per run, with the mean over the end of the way that all have gone beside those of each run's own."""
    def text(results):
        way = min(result.case.distance for result in results)
        rows = []
        for result in results:
            fit, at_end, *others = _common(result)
            rows.append([of(result.case), f"{1e3 * result.case.distance:g}", fit, at_end, f"{1e-3 * result.mean_up_to(way):.1f}", *others,
                         *(show(result) for _, show in columns)])
        return f"## {title}\n\n{note}" + _table([name, "way / mm", *COMMON[:2], f"{1e3 * (way - LAST):g} to {1e3 * way:g} mm / kPa",
                                                 *COMMON[2:], *(head for head, _ in columns)], rows)
    return text


def _octree(results):
    """The first run is what the others are compared with."""
    rows, first = [], results[0]
    last = slice(len(first.pressure) // 2, None)
    for result in results:
        record, case = result.record, result.case
        reference = np.interp(result.displacement, first.displacement, first.pressure)
        mesh = "uniform" if case.uniform else f"{1e3 * case.around:g} mm up to {1e3 * case.reach:g} mm, then {1e3 * case.base:g} mm"
        rows.append([mesh, f"{record['cells']}", f"{record['dofs']}",
                     f"{record['material points']}", f"{record['time steps']}", f"{1e-6 * record['peak memory']:.0f}",
                     f"{record['wall time']:.0f}", f"{first.record['wall time'] / record['wall time']:.1f}",
                     f"{1e-3 * result.pressure[last].mean():.1f}",
                     f"{100. * (result.pressure[last].mean() / reference[last].mean() - 1.):+.1f} %"])
    return """## Octree against a uniform mesh

In a box of 0.8 x 0.12 x 0.32 m, small enough for cells of 10 mm everywhere, over 10 mm; resistances are means over the second half, for the
uniform mesh rings for longer.

""" + _table(["mesh", "cells", "dofs", "material points", "time steps", "peak memory / MB", "wall time / s", "times faster",
              "resistance / kPa", "difference"], rows)


def _variation(title, name, of, note="", columns=()):
    """A row per run; `of` tells its case, `columns` are further ones: a head and what a result shows there."""
    def text(results):
        rows = [[of(result.case), *_common(result), *(show(result) for _, show in columns)]
                for result in results]
        return f"## {title}\n\n{note}" + _table([name, *COMMON, *(head for head, _ in columns)], rows)
    return text


_STATIC_MEANS = "Static equilibrium, cells of 10 mm at the plate and along its way; means from {:g} to {:g} mm"


def _over_parameter(results, title, name, of, note, chart):
    """A row per value of a parameter with all shapes, and their chart."""
    found = limits.Limits(results, of)
    limits.draw(found, name, chart)
    head, rows = limits.rows(found)
    note += f"{_STATIC_MEANS.format(1e3 * (found.way - LAST), 1e3 * found.way)}; the wall time is that of all shapes.\n\n"
    return f"## {title}\n\n{note}" + _table([name, *head], rows) + f"\n![{title}]({chart.name})\n"


def _sensitivity(results, chart):
    """What each case changes of the first one of its shape."""
    first = {result.case.shape: result.case for result in reversed(results)}
    found = changes.Changes(results, lambda case: _label(case, [case, first[case.shape]]))
    changes.draw(found, chart)
    title = "What the long frustum's resistance hangs on"
    return f"""## {title}

Single changes, the plate's friction staying as it is unless it is the change. {_STATIC_MEANS.format(1e3 * (found.way - LAST), 1e3 * found.way)}.

""" + _table(*changes.rows(found)) + f"\n![{title}]({chart.name})\n"


def _formula(of):
    return lambda result: f"{1e-3 * of(result.case):.1f}"


def _per_overburden(result):
    return f"{result.at_end / (WEIGHT * result.case.depth):.1f}"


_TEXTS = {
    "shapes": _shapes,
    "resolution": _over_ways("Resolution", "shape, analysis, cells at the plate, around it, beyond / mm",
                             lambda case: f"{case.shape}, {case.analysis}, {1e3 * case.cell:g}, {1e3 * case.around:g}, {1e3 * case.base:g}"
                             + _tolerance(case, "; "),
                             "Cells at the plate's surface, around it or its way, and beyond. In explicit dynamics cells of 20 mm beyond begin "
                             "80 mm from the plate.\n\n", [("cuts", lambda result: f"{result.record['cuts']}")]),
    "rate": _over_ways("Loading rate (figure 6)", "velocity, mass scaling",
                       lambda case: "static" if case.analysis == "static" else
                       f"{1e3 * case.velocity:g} mm/s, {case.mass_scaling:g}, {case.analysis}"),
    "stiffness": _variation("Young's modulus (figure 13)", "E / MPa", lambda case: f"{1e-6 * case.young:g}"),
    "dilatancy": _variation("Dilatancy", "angle / °", lambda case: f"{case.dilation_angle:g}"),
    "interface": _variation("Friction of plate and sand", "tan δ / tan φ", lambda case: f"{case.roughness:g}"),
    "embedment": _variation("Embedment", "depth of the axis / B", lambda case: f"{case.depth / WIDTH:g}" + (", strip" if 2. * case.half_width < WIDTH else ""),
                            "Beside formulas for limit loads: limit analysis of a rough strip in plane strain that cannot rise (φ = ψ = 35°, "
                            "within 8 % either way), Rankine's wedges on an infinitely wide wall and the same with friction on the sides "
                            "of a square plate (Teng 1962), and three times Rankine's passive pressure (Broms 1964).\n\n",
                            [("last 10 mm / γ depth", _per_overburden), ("strip, limit analysis / kPa", _formula(limit_strip)),
                             ("strip, Rankine / kPa", _formula(rankine_strip)),
                             ("square, Teng / kPa", _formula(teng_square)), ("square, Broms / kPa", _formula(broms_square))]),
    "octree": _octree,
}

_LIMITS = {
    "friction": ("Friction angle (figure 12)", "friction angle / °", lambda case: case.friction_angle,
                 "The plate's friction is the tangent of the same angle. "),
    "group": ("Group effect (figure 11)", "spacing / B", lambda case: round(2. * case.half_width / WIDTH, 6),
              "One of a row of plates, whose spacing is the box's width. "),
}


_NAMES = {"cell": ("cells at the plate", 1e3, "mm"), "around": ("around it", 1e3, "mm"), "reach": ("up to", 1e3, "mm"),
          "base": ("beyond", 1e3, "mm"), "depth": ("depth", 1., "m"), "half_width": ("half width", 1., "m"), "velocity": ("", 1e3, "mm/s"),
          "mass_scaling": ("mass scaling", 1., ""), "young": ("E", 1e-6, "MPa"), "dilation_angle": ("ψ", 1., "°"),
          "roughness": ("tan δ / tan φ", 1., ""), "edge_radius": ("edges rounded by", 1e3, "mm"), "box_length": ("box", 1., "m long"),
          "friction_angle": ("φ", 1., "°"), "K0": ("K0", 1., "")}
_DYNAMIC = ("velocity", "mass_scaling")  # mean nothing in static equilibrium


def _label(case, cases):
    """What tells a case from the others of its part."""
    fields = [field.name for field in dataclasses.fields(case) if len({getattr(other, field.name) for other in cases}) > 1]
    said = []
    for name in (name for name in fields if name not in ("ahead", "distance")):  # the analysis and the curve's length say it
        value = getattr(case, name)
        if name == "tolerance":
            said += [_tolerance(case)] if _has_own_tolerance(case) else []
        elif isinstance(value, bool):
            said += [name] if value else []
        elif isinstance(value, str):
            said.append(value)
        elif case.analysis != "static" or name not in _DYNAMIC:
            text, factor, unit = _NAMES.get(name, (name.replace("_", " "), 1., ""))
            said.append(f"{text} {factor * value:g} {unit}".strip())
    return ", ".join(said) or case.name


def _draw_resolution(results, _, path):
    """A panel per shape."""
    shapes = list(dict.fromkeys(result.case.shape for result in results))
    figure, panels = plt.subplots((len(shapes) + 1) // 2, 2, figsize=(10, 3.6 * ((len(shapes) + 1) // 2)), squeeze=False, layout="constrained")
    for panel, shape in zip(panels.flat, shapes):
        for result in (result for result in results if result.case.shape == shape):
            case = result.case
            fine_beyond = case.base < type(case).base
            style = ":" if case.analysis == "explicit" else "--" if _has_own_tolerance(case) else "-"
            label = f"{case.analysis}, {1e3 * case.cell:g} mm{_tolerance(case, ', ')}" + (f", beyond {1e3 * case.base:g} mm" if fine_beyond else "")
            panel.plot(1e3 * result.displacement, 1e-3 * result.pressure, linestyle=style, linewidth=0.7 if _has_own_tolerance(case) else 1.,
                       color=f"C{(0.02, 0.01, 0.005).index(case.cell) + (3 if fine_beyond else 0)}", label=label)
        panel.axhline(1e-3 * REFERENCE["shapes"][shape]["laboratory"], color="0.4", linestyle="--", linewidth=0.8, label="laboratory")
        panel.set(title=shape, xlim=(0., None), ylim=(0., None), xlabel="displacement / mm", ylabel="resistance / kPa")
        panel.legend(fontsize=7, loc="lower right")
    figure.savefig(path, dpi=90, metadata={"Software": None})
    plt.close(figure)


def _draw_curves(results, part, path):
    figure, axes = plt.subplots(figsize=(9, 4.4))
    cases = [result.case for result in results]
    shapes = list(dict.fromkeys(case.shape for case in cases))
    for number, result in enumerate(results):
        color = f"C{shapes.index(result.case.shape) if part == 'shapes' else number}"
        dotted = part == "shapes" and result.case.analysis == "explicit"
        axes.plot(1e3 * result.displacement, 1e-3 * result.pressure, color=color, linestyle=":" if dotted else "-",
                  linewidth=1. if dotted else 1.5, label=_label(result.case, cases))
    if part == "shapes":
        for number, shape in enumerate(shapes):
            axes.axhline(1e-3 * REFERENCE["shapes"][shape]["laboratory"], color=f"C{number}", linestyle="--", linewidth=0.8)
        axes.plot([], [], color="0.4", linestyle="--", linewidth=0.8, label="laboratory, at large displacement")
    axes.set_xlim(left=0.)
    axes.set_ylim(bottom=0.)
    axes.set_xlabel("displacement / mm")
    axes.set_ylabel("resistance / kPa")
    axes.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.01, 1.))
    figure.tight_layout()
    figure.savefig(path, dpi=90, metadata={"Software": None})
    plt.close(figure)
