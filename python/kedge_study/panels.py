"""Panels of charts. Each gets the axes, the study, the part, the chart's keys, and the results of the part in order."""
import numpy as np
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from . import convergence as orders
from .cases import default_values, described, label, varied
from .expressions import evaluate

MOST_INSIDE = 8  # entries of a legend inside the axes
MARKERS = "osD^v<>ph*"
LINES = ("--", ":", "-.", (0, (5, 1, 1, 1, 1, 1)))  # of references
OF_LEVEL = ("max", "mean", "end", "limit")  # answers that a line at their reference suits


def main_answer(study, chart):
    """The answer that a chart is about: the first with a reference unless it names one."""
    return chart.get("answer") or next(iter(study.references), next(iter(study.answers), None))


def shown(study, chart, results):
    """The results that a chart is about."""
    where = f"{study.path}: charts.only"
    return [result for result in results if evaluate(chart.get("only", 1), result.case.names, where)]


def has_content(study, chart, results):
    """Whether there is anything to draw."""
    if chart["kind"] == "curves":
        name = chart.get("curve") or next(iter(study.curves), None)
        return any(name in result.curves for result in results)
    answer = main_answer(study, chart)
    if chart["kind"] == "cost":
        return any(result.error(answer) is not None for result in results)
    return any(result.answers.get(answer) is not None for result in results)


def curves(axes, study, part, chart, results):
    """All runs over each other; a cross where a run failed; lines to compare with."""
    name = chart.get("curve") or next(iter(study.curves))
    curve, cases = study.curves[name], [result.case for result in results]
    ends = []
    for index, result in enumerate(results):
        if name not in result.curves:
            continue
        x, y = result.curves[name]
        are_points = curve.get("style") == "points"
        axes.plot(x, y, color=f"C{index % 10}", linewidth=1.2 if index < 10 else 0.8, markersize=3,
                  marker="." if are_points else "", linestyle="" if are_points else ("-", "--", ":")[index // 10 % 3],
                  label=label(study, result.case, cases))
        if not result.is_finished and len(x):
            axes.plot(x[-1], y[-1], "x", color=f"C{index % 10}", markersize=8, markeredgewidth=2)
        ends += [x[0], x[-1]]
    _lines(axes, study, curve, f"{study.path}: curves.{name}", results, ends)
    _levels(axes, study, name, results)
    axes.set(xlabel=curve.get("x label", "x"), ylabel=curve.get("y label", name))
    _scale(axes, curve.get("scales"))
    if "x range" in curve:
        axes.set_xlim(curve["x range"])
    if "y range" in curve:
        axes.set_ylim(curve["y range"])
    if any(not result.is_finished for result in results):
        axes.plot([], [], "x", color="0.3", label="failed here")
    _legend(axes)


def _lines(axes, study, curve, where, results, ends):
    """Curves to compare with, once for each set of parameters that changes them."""
    if not curve.get("lines") or not ends:
        return
    low, high = curve.get("x range", (min(ends), max(ends)))
    x = np.linspace(low, high, 300)
    for number, (text, expression) in enumerate(curve["lines"].items()):
        drawn = []
        for result in results:
            with np.errstate(all="ignore"):
                y = evaluate(expression, result.case.names | {"x": x}, f"{where}.lines.{text}") + 0. * x
            if not any(np.allclose(y, other, equal_nan=True) for other in drawn):
                axes.plot(x, y, color="0.35", linewidth=1., linestyle=LINES[number % len(LINES)],
                          label=None if drawn else text)
                drawn.append(y)


def _levels(axes, study, curve, results):
    """Horizontal lines at the first reference of the answers that are levels of this curve, in the colour of the run
    where runs have references of their own."""
    for name, answer in study.answers.items():
        if answer.get("curve") != curve or answer.get("take") not in OF_LEVEL:
            continue
        known = [(index, *result.references[name][0]) for index, result in enumerate(results)
                 if result.references.get(name)]
        values = {f"{value:.5g}" for _, _, value in known}
        drawn = set()
        for index, source, value in known:
            if f"{value:.5g}" not in drawn:
                drawn.add(f"{value:.5g}")
                is_common = len(values) == 1
                axes.axhline(value, color="0.4" if is_common else f"C{index % 10}", linestyle="--", linewidth=0.9,
                             label=f"{source} {value:.4g}" if is_common else None)
        return  # one answer is enough


def cost(axes, study, part, chart, results):
    """Error over CPU time, the Pareto front, the default ringed. Runs that differ in the refined parameter alone are
    joined by a line."""
    answer, cases = main_answer(study, chart), [result.case for result in results]
    known = [result for result in results if result.error(answer) is not None]
    errors = {id(result): 100. * abs(result.error(answer)) for result in known}
    floor = max(1e-6, 0.3 * min([error for error in errors.values() if error > 0.], default=1.))
    errors = {key: max(error, floor) for key, error in errors.items()}
    refined = _refined(study, part, chart)
    for number, group in enumerate(series(study, known, refined) if refined else [[result] for result in known]):
        index = number if refined else results.index(group[0])
        text = _label_without(study, group[0].case, cases, refined) if refined else label(study, group[0].case, cases)
        style = {"color": f"C{index % 10}", "linestyle": "-" if refined else "none", "linewidth": 0.8}
        if refined:
            group = sorted(group, key=lambda result: result.case.values[refined])
        axes.plot([result.cpu for result in group], [errors[id(result)] for result in group],
                  MARKERS[index // 10 % len(MARKERS)], markersize=6, label=text, **style)
        for result in group:
            _mark(axes, result, errors[id(result)], f"C{index % 10}")
    costs = [result.cpu for result in known]
    front = orders.pareto_front(costs, [errors[id(result)] for result in known])
    axes.step([costs[i] for i in front], [errors[id(known[i])] for i in front], where="post", color="0.5",
              linewidth=1., linestyle="--", label="best of all")
    for index, result in enumerate(results):  # the runs that serve as reference
        if result.error(answer) is None and result.answers.get(answer) is not None:
            axes.axvline(result.cpu, color=f"C{index % 10}", linewidth=1., linestyle=":",
                         label=label(study, result.case, cases))
    head = _head(study, answer)
    axes.set(xscale="log", yscale="log", xlabel="CPU time / s",
             ylabel=f"{head if 'error' in head else 'error of ' + head} / %")
    _plain_ticks(axes)
    lost = sum(result.answers.get(answer) is None for result in results)
    if lost:
        axes.set_title(f"{lost} of {len(results)} runs have no answer", color="C3")
    _legend(axes)


def _mark(axes, result, error, colour):
    """A cross on a failed run, a ring around the default."""
    if not result.is_finished:
        axes.plot(result.cpu, error, "x", color=colour, markersize=11, markeredgewidth=1.5)
    if result.case.name == "default":
        axes.plot(result.cpu, error, "o", markersize=13, markerfacecolor="none", markeredgecolor="k",
                  linestyle="none", label="default")


def _refined(study, part, chart):
    """The parameter along which points are joined: that of the chart, or of a convergence chart beside it."""
    return chart.get("over") or next((other["over"] for other in part.get("charts", []) if "over" in other), None)


def convergence(axes, study, part, chart, results):
    """An answer over a refined parameter with Richardson's limit, a line for each set of the other parameters."""
    over_, answer = chart["over"], main_answer(study, chart)
    is_log = chart.get("scales") == "log"
    cases = [result.case for result in results]
    factor = study.scale(answer)
    heights = []  # of points, limits and references: uncertainties may leave the panel
    for index, group in enumerate(series(study, results, over_)):
        sizes, values = points_of(group, over_, answer)
        if not len(sizes):
            continue
        heights += [*(values * factor), *(value * factor for _, value in group[0].references.get(answer, []))]
        text = _label_without(study, group[0].case, cases, over_)
        ended = points_of(finished(group), over_, answer)
        found = orders.richardson(*ended) if not is_log else None
        if is_log and (order := orders.order_of_errors(*ended)):
            text += f" (order {order:.2f})"
        axes.plot(sizes * study.scale(over_), values * factor, "o-", color=f"C{index % 10}", markersize=5, linewidth=1.,
                  label=text)
        for result in group:
            if not result.is_finished and result.answers.get(answer) is not None:
                axes.plot(result.case.values[over_] * study.scale(over_), result.answers[answer] * factor, "x",
                          color=f"C{index % 10}", markersize=9)
        if found:
            heights += [found.limit * factor]
            axes.errorbar(0., found.limit * factor, abs(found.uncertainty * factor), color=f"C{index % 10}", marker="*",
                          capsize=4, linestyle="none", label="  " + found.text())
        _reference_lines(axes, group, answer, factor, f"C{index % 10}")
    axes.set(xlabel=study.label(over_), ylabel=study.label(answer))
    if is_log:
        axes.set(xscale="log", yscale="log")
        _plain_ticks(axes)
    else:
        margin = 0.08 * (max(heights) - min(heights)) or 0.1 * abs(heights[0])
        axes.set(xlim=(-0.04 * axes.get_xlim()[1], None), ylim=(min(heights) - margin, max(heights) + margin))
    _legend(axes)


def _reference_lines(axes, group, answer, factor, colour):
    for number, (source, value) in enumerate(group[0].references.get(answer, [])):
        if value:
            axes.axhline(value * factor, color=colour, linewidth=0.9, linestyle=LINES[number % len(LINES)],
                         label=f"  {source} {value * factor:.4g}")


def over(axes, study, part, chart, results):
    """An answer over a parameter, with what it should be."""
    over_, answer = chart["over"], main_answer(study, chart)
    cases = [result.case for result in results]
    for index, group in enumerate(series(study, results, over_)):
        sizes, values = points_of(group, over_, answer)
        axes.plot(sizes * study.scale(over_), values * study.scale(answer), "o-", color=f"C{index % 10}",
                  markersize=5, linewidth=1.2, label=_label_without(study, group[0].case, cases, over_))
        for number in range(max(len(result.references.get(answer, [])) for result in group)):
            known = [(result.case.values[over_], *result.references[answer][number]) for result in group
                     if number < len(result.references.get(answer, []))]
            at, sources, wanted = zip(*known)
            axes.plot(np.array(at) * study.scale(over_), np.array(wanted) * study.scale(answer), color=f"C{index % 10}",
                      linestyle=LINES[number % len(LINES)], marker="+", linewidth=0.9, label="  " + sources[0])
    axes.set(xlabel=study.label(over_), ylabel=study.label(answer))
    _scale(axes, chart.get("scales"))
    _legend(axes)


def changes(axes, study, part, chart, results):
    """Bars: by how much each single change changes the answer."""
    answer, cases = main_answer(study, chart), [result.case for result in results]
    default = default_values(study, part) if "one at a time" in part else cases[0].values
    base = next((result for result in results if result.case.values == default), None)  # missing over a budget
    others = [result for result in results if result is not base]
    start = base.answers.get(answer) if base else None
    texts = [label_of_change(study, default, other.case) or label(study, other.case, cases) for other in others]
    for row, other in enumerate(others):
        value = other.answers.get(answer)
        if value is None or not start:
            axes.text(0., row, " no answer", va="center", color="C3", fontsize=8)
            continue
        axes.barh(row, 100. * (value / start - 1.), 0.5, color="C0" if other.is_finished else "C3", alpha=0.6)
        note = f" {value * study.scale(answer):.4g}" + ("" if other.is_finished else f", {other.status}")
        axes.text(0., row, note, va="center", fontsize=7)
    axes.axvline(0., color="0.3", linewidth=0.8)
    axes.set_yticks(range(len(others)), texts, fontsize=7)
    axes.invert_yaxis()
    shown = "none" if start is None else f"{start * study.scale(answer):.4g}"
    axes.set_xlabel(f"change of {_head(study, answer)} / % of {shown}")


def label_of_change(study, base, other):
    """What differs between the values of a case and others."""
    parts = []
    for name, value in other.values.items():
        if value != base[name]:
            head, unit = study.head_and_unit(name)
            parts.append(f"{head} {study.text(name, value)} {unit}".strip())
    return ", ".join(parts)


def series(study, results, over_):
    """Results that differ only in one parameter, as lists in the order of the results."""
    groups = {}
    for result in results:
        key = tuple((name, str(value)) for name, value in result.case.values.items() if name != over_)
        groups.setdefault(key, []).append(result)
    return list(groups.values())


def finished(group):
    """The results of runs that reached their end: others answer for another moment."""
    return [result for result in group if result.is_finished]


def points_of(group, over_, answer):
    """Values of a parameter, and the answers of the runs that have one."""
    known = sorted((float(result.case.values[over_]), result.answers[answer]) for result in group
                   if result.answers.get(answer) is not None)
    return np.array(known).reshape(-1, 2).T


def _label_without(study, case, cases, name):
    """What distinguishes a series along one parameter from the others."""
    others = [other for other in varied(study, cases) if other != name]
    return described(study, case, others, with_units=False) or "computed"


def _head(study, name):
    return study.head_and_unit(name)[0]


def _plain_ticks(axes):
    """Plain numbers at the ticks of logarithmic axes, at a few places between powers of ten, too."""
    for axis in (axes.xaxis, axes.yaxis):
        low, high = axis.get_view_interval()
        places = (1., 2., 5.) if high / max(low, 1e-300) < 300. else (1.,)
        axis.set_major_locator(LogLocator(base=10., subs=places))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())


def _scale(axes, scales):
    if scales in ("log", "log x"):
        axes.set_xscale("log")
    if scales in ("log", "log y"):
        axes.set_yscale("log")


def _legend(axes):
    """A legend inside the axes, or beside them where it is long."""
    handles, labels = axes.get_legend_handles_labels()
    unique = dict(zip(labels, handles))
    if not unique:
        return
    beside = {"loc": "upper left", "bbox_to_anchor": (1.01, 1.)} if len(unique) > MOST_INSIDE else {}
    axes.legend(unique.values(), unique.keys(), fontsize=7 if len(unique) < 25 else 5, **beside)
