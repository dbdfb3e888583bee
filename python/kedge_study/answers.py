"""What a run answers: its curves, and numbers taken from them, from its points, or from its summary."""
import csv
import functools
import hashlib
import importlib.util
import json
import pathlib
import re
import sys

import numpy as np

from kedge_runs import RunError
from kedge_runs.run import Run

from . import StudyError
from .expressions import evaluate, plain
from .study import BODY_COLUMNS
from .taking import take

SUMMED = ("steps", "cuts", "newton iterations", "krylov iterations", "time steps", "deleted")
COSTS = ("steps", "cuts", "newton iterations", "krylov iterations", "material points", "dofs")
CODE = [pathlib.Path(__file__), pathlib.Path(__file__).with_name("taking.py")]
N_KEPT = 400  # points of a curve that a chart needs
DISPLACEMENT = re.compile(r"body(\d+)_displacement_([xyz])")  # a column made of the position


class _Folder:
    """Output of a command that is no run of kedge, or of a run that wrote none."""

    def __init__(self, folder):
        self.folder, self.summary, self.is_finished = folder, {}, False

    def __getattr__(self, name):
        raise RunError(f"{self.folder}: no output of kedge")


def read(study, case, folder):
    """Answers, curves and costs of a run, from its folder: {"answers": {...}, "curves": {name: [x, y]}, "costs": {...},
    "reached": x, "notes": [why an answer is missing]}. Keeps them beside the run and reads them again as long as the
    study asks for the same."""
    kept, key = folder / "answers.json", _key(study, case, folder)
    try:
        content = json.loads(kept.read_text(encoding="utf-8"))
        if content["key"] == key:
            return content
    except (OSError, ValueError, KeyError):
        pass
    content = {"key": key} | _read(study, case, folder)
    kept.write_text(json.dumps(content) + "\n", encoding="utf-8")
    return content


def _key(study, case, folder):
    """Hash of the questions, of the run's end, and of the code that answers."""
    files = CODE + [study.folder / entry["function"].partition(":")[0]
                    for entry in [*study.answers.values(), *study.curves.values()] if "function" in entry]
    sources = [path.read_text(encoding="utf-8") for path in files]
    record = (folder / "record.json").read_text(encoding="utf-8")
    content = [study.columns, study.curves, study.answers, {name: repr(value) for name, value in case.names.items()},
               sources, record]
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def _read(study, case, folder):
    if study.command or not (folder / "output").is_dir():  # it failed before it wrote anything
        run = _Folder(folder)
    else:
        run = Run(folder / "output")
    curves = {name: _curve(study, name, run, case.names) for name in study.curves}
    answers = {}
    notes = [f"the curve {name} has no finite value" for name, curve in curves.items()
             if curve and len(curve[1]) and not np.isfinite(curve[1]).any()]
    for name in study.answers:
        answers[name] = _answer(study, name, run, case.names, curves, answers, notes)
    first = next(iter(curves.values()), None)
    return {"answers": answers, "costs": costs(run.summary), "notes": notes,
            "reached": float(first[0][-1]) if first and len(first[0]) else None,
            "curves": {name: [[float(value) for value in side] for side in thinned(*curve)] if curve else None
                       for name, curve in curves.items()}}


def costs(summary):
    """Sums over the stages, and the sizes of the last."""
    stages = summary.get("stages", [])
    result = {name: sum(stage.get(name, 0) for stage in stages) for name in COSTS[:4]}
    last = stages[-1] if stages else {}
    return result | {name: last.get(name, 0) for name in COSTS[4:]} | {"peak memory": summary.get("peak memory", 0.)}


def thinned(x, y, n=N_KEPT):
    """At most n points of a curve, the ends among them."""
    if len(x) <= n:
        return x, y
    chosen = np.unique(np.linspace(0, len(x) - 1, n).round().astype(int))
    return x[chosen], y[chosen]


def _curve(study, name, run, names):
    """x and y of a curve; None where the run did not write its table."""
    curve, where = study.curves[name], f"{study.path}: curves.{name}"
    try:
        if "function" in curve:
            sides = function_of(study, curve["function"], where)(run, names)
            return tuple(np.asarray(side, dtype=float) for side in sides)
        columns = _table(curve.get("table", "bodies"), run)
    except RunError:
        return None
    bound = columns if curve.get("table", "bodies") != "bodies" else _bound(study, columns, run, curve)
    rows = np.ones(len(next(iter(columns.values()))), dtype=bool)
    if "stage" in curve and "stage" in columns:
        rows &= columns["stage"] == curve["stage"]
    if "where" in curve:
        rows &= np.asarray(evaluate(curve["where"], names | bound, f"{where}.where"), dtype=bool)
    bound = {key: values[rows] for key, values in bound.items()}
    with np.errstate(all="ignore"):  # a value that is not finite leaves a gap
        x, y = (np.broadcast_to(np.asarray(evaluate(curve[side], names | bound, f"{where}.{side}"), dtype=float),
                                (np.count_nonzero(rows),)) for side in ("x", "y"))
    return x, y


def _table(name, run):
    """Columns of a table by name; those of material points and files with _ for all but letters and digits."""
    if name == "bodies":
        return run.bodies()
    if name == "points":
        return {plain(key): run.points(key) for key in run.point_columns()}
    path = run.folder / name
    try:
        with open(path, newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
    except OSError as error:
        raise RunError(f"{path}: cannot be read ({error.strerror})") from error
    if not rows:
        raise RunError(f"{path}: holds no rows")
    return {plain(key): _numbers([row[key] for row in rows]) for key in rows[0]}


def _numbers(texts):
    try:
        return np.array(texts, dtype=float)
    except ValueError:
        return np.array(texts)


def _bound(study, columns, run, curve):
    """The columns that the study names, and time, step and stage."""
    result = {name: columns[name] for name in BODY_COLUMNS if name in columns}
    check_columns(study, columns)
    for name, column in study.columns.items():
        found = DISPLACEMENT.fullmatch(column)
        result[name] = (_displacement(columns, run, int(found[1]), found[2], curve.get("stage", 1)) if found
                        else columns[column])
    return result


def check_columns(study, known):
    """Raises StudyError where a study names a column that rigid_body.csv does not have."""
    for name, column in study.columns.items():
        found = DISPLACEMENT.fullmatch(column)
        if (f"body{found[1]}_position_{found[2]}" if found else column) not in known:
            raise StudyError(f"{study.path}: columns.{name}: rigid_body.csv has no column \"{column}\"; it has "
                             f"{', '.join(known)}")


def _displacement(columns, run, body, axis, stage):
    """Displacement of a body since the start of a stage, m."""
    position = columns[f"body{body}_position_{axis}"]
    start = run.start_of(body, stage)
    return position - (start["xyz".index(axis)] if start else position[0])


def _answer(study, name, run, names, curves, answers, notes):
    """A number; None where the run does not hold it. Adds to `notes` why, unless the run did not come so far."""
    answer, where = study.answers[name], f"{study.path}: answers.{name}"
    known = names | {plain(key): np.float64(np.nan if value is None else value) for key, value in answers.items()}
    if "only" in answer and not evaluate(answer["only"], known, f"{where}.only"):
        return None
    try:
        if "curve" in answer:
            limits = {key: evaluate(answer[key], known, f"{where}.{key}") for key in ("from", "to", "x")
                      if key in answer}
            value = _of_curve(name, answer, limits, curves[answer["curve"]], notes,
                              may_end_early=run.summary and not run.is_finished)
        elif "summary" in answer:
            value = _of_summary(run.summary, answer["summary"])
        elif "points" in answer and run.summary and not run.is_finished:
            value = None  # the last table of a run that failed shows another time
        elif "points" in answer:
            value = evaluate(answer["points"], known | _table("points", run), f"{where}.points")
        elif "relative" in answer:
            value = None  # results.add_relatives knows the other run
        elif "expression" in answer:
            with np.errstate(all="ignore"):
                value = evaluate(answer["expression"], known, f"{where}.expression")
        else:
            value = function_of(study, answer["function"], where)(run, names)
    except StudyError:
        raise
    except RunError:  # the run did not come so far
        return None
    if value is not None and np.isinf(value):
        notes.append(f"no {name}: it is infinite")
    return float(value) if value is not None and np.isfinite(value) else None


def _of_curve(name, answer, limits, curve, notes, may_end_early):
    if not curve:
        return None
    try:
        value = take(*curve, answer["take"], limits)
        reason = "" if value is not None or may_end_early else f"there is none{_range_of(limits, curve[0])}"
    except StudyError as error:
        value, reason = None, error
    if reason:
        notes.append(f"no {name} of the curve {answer['curve']}: {reason}")
    return value


def _range_of(limits, x):
    """Where an answer is looked for, and where its curve lies, as a text."""
    wanted = "".join(f" {'at' if key == 'x' else key} {float(limit):.4g}" for key, limit in limits.items())
    return wanted + (f"; x lies between {x.min():.4g} and {x.max():.4g}" if len(x) else "; it has no rows")


def _of_summary(summary, path):
    if path in SUMMED:
        return sum(stage.get(path, 0) for stage in summary.get("stages", []))
    value = summary
    for step in path.split("."):
        try:
            value = value[int(step) if isinstance(value, list) else step]
        except (KeyError, IndexError, ValueError, TypeError):
            return None
    return value if isinstance(value, (int, float)) else None


def function_of(study, text, where):
    """A function from a Python file beside the study."""
    file, _, name = text.partition(":")
    try:
        return getattr(_module(study.folder / file), name)
    except (OSError, AttributeError) as error:
        raise StudyError(f"{where}.function: {text}: {getattr(error, 'strerror', None) or error}") from error


@functools.lru_cache(maxsize=None)
def _module(path):
    """A Python file as a module, loaded once, so that what it keeps serves all answers of a run."""
    spec = importlib.util.spec_from_file_location(f"study_{path.stem}", path)
    if str(path.parent) not in sys.path:
        sys.path.insert(0, str(path.parent))  # for what the file imports from its neighbours
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
