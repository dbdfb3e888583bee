"""The results of a study: of runs that are there, and of those that the kept tables hold."""
import csv
from dataclasses import dataclass, field

import numpy as np

from . import answers, records
from .expressions import evaluate
from .study import RELATIVE_COSTS

PROVENANCE = ("commit", "input", "ranks", "machine", "date")
NUMBERS = ("CPU time / s", "wall time / s", "memory / MB")
N_KEPT = 120  # points of a curve in the kept table


@dataclass
class Result:
    """Of one run. answers: numbers or None in SI; curves: (x, y) by name; costs: as answers.costs."""
    case: object
    status: str
    message: str
    reached: object
    answers: dict
    curves: dict
    costs: dict
    cpu: float
    wall: float
    memory: float  # B
    provenance: dict
    notes: list = field(default_factory=list)  # why answers are missing
    references: dict = field(default_factory=dict)  # by answer, pairs of name and value

    @property
    def is_finished(self):
        """Whether the run reached its end."""
        return self.status == "finished"

    def error(self, answer):
        """The answer over its first reference less one; the answer itself where the reference is zero; None without."""
        known = [value for _, value in self.references.get(answer, [])]
        value = self.answers.get(answer)
        if value is None or not known or known[0] is None:
            return None
        return value / known[0] - 1. if known[0] else value


def of_runs(study, cases, work):
    """Results of the runs that ended, by the present version of their programs."""
    results = {}
    for case in cases:
        folder = case.folder(work, records.version_of(case.program))
        record = records.read(folder)
        if record and record.is_result:
            found = answers.read(study, case, folder)
            results[case.key] = Result(
                case, record.status, record.message, found["reached"], found["answers"],
                {name: tuple(map(np.array, curve)) for name, curve in found["curves"].items()
                 if curve and curve[0]},
                found["costs"], record.cpu, record.wall, max(record.memory, found["costs"].get("peak memory") or 0.),
                {name: getattr(record, name) for name in PROVENANCE}, found["notes"])
    return results


def of_table(study, cases, folder):
    """Results of the kept table in a folder whose input is still that of a case."""
    path = folder / f"{study.name}.csv"
    if not path.is_file():
        return {}
    with open(path, newline="", encoding="utf-8") as file:
        rows = {(row.get("input"), row.get("run")): row for row in csv.DictReader(file)}
    curves = _kept_curves(folder / f"{study.name}-curves.csv")
    return {case.key: _of_row(study, case, rows[case.key], curves.get(case.key, {})) for case in cases
            if case.key in rows}


def _of_row(study, case, row, curves):
    numbers = {name: _number(row.get(name)) for name in [*study.answers, *answers.COSTS, *NUMBERS, "reached"]}
    return Result(case, row["status"], row["message"], numbers["reached"],
                  {name: numbers[name] for name in study.answers}, curves,
                  {name: numbers[name] for name in answers.COSTS},
                  *(numbers[name] or 0. for name in ("CPU time / s", "wall time / s")),
                  1e6 * (numbers["memory / MB"] or 0.), {name: row[name] for name in PROVENANCE})


def _number(text):
    return float(text) if text not in (None, "") else None


def _kept_curves(path):
    """Curves by input and run, and by name."""
    if not path.is_file():
        return {}
    points = {}
    with open(path, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if "run" not in row:
                return {}  # of another program, or of another study
            key = (row["input"], row["run"]), row["curve"]
            points.setdefault(key, []).append((float(row["x"]), float(row["y"])))
    curves = {}
    for (key, name), values in points.items():
        curves.setdefault(key, {})[name] = tuple(np.array(values).T)
    return curves


def write_table(study, results, folder):
    """Writes the table of all runs and their curves."""
    rows = [{"run": result.case.name, **result.case.values, "status": result.status, "message": result.message,
             "reached": _text(result.reached), **{name: _text(result.answers.get(name)) for name in study.answers},
             **{name: _text(result.costs.get(name)) for name in answers.COSTS},
             **{"CPU time / s": f"{result.cpu:.4g}", "wall time / s": f"{result.wall:.4g}",
                "memory / MB": f"{1e-6 * result.memory:.4g}"}, **result.provenance} for result in results.values()]
    _write(folder / f"{study.name}.csv", rows)
    points = [{"input": result.case.input, "run": result.case.name, "curve": name, "x": f"{x:.6g}", "y": f"{y:.5g}"}
              for result in results.values() for name, curve in result.curves.items()
              for x, y in zip(*answers.thinned(*curve, N_KEPT))]
    if points:
        _write(folder / f"{study.name}-curves.csv", points)


def _write(path, rows):
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def _text(value):
    return "" if value is None else f"{value:.9g}"


def add_references(study, results):
    """Gives each result what its answers should be."""
    for result in results.values():
        for name, references in study.references.items():
            pairs = []
            for index, reference in enumerate(references):
                where = f"{study.path}: references.{name}[{index}]"
                if "only" in reference and not evaluate(reference["only"], result.case.names, f"{where}.only"):
                    continue
                pairs.append((reference.get("name", "exact"), _reference(name, reference, result, results, where)))
            result.references[name] = [pair for pair in pairs if pair[1] is not None]


def _reference(name, reference, result, results, where):
    values = result.case.values
    if "value" in reference:
        return float(evaluate(reference["value"], result.case.names, f"{where}.value"))
    if "table" in reference:
        key = values[reference["by"]]
        return reference["table"].get(format(key, "g") if isinstance(key, (int, float)) else str(key))
    if "run" in reference:
        other = _with_values(results, values | reference["run"])
        return other.answers.get(name) if other and other is not result else None
    refined = reference["finest"]
    others = {key: value for key, value in values.items() if key != refined}
    alike = [other for other in results.values() if other.is_finished and other.answers.get(name) is not None
             and {key: value for key, value in other.case.values.items() if key != refined} == others]
    finest = min(alike, key=lambda other: other.case.values[refined], default=None)
    return finest.answers[name] if finest and finest is not result else None


def _with_values(results, values):
    """The result of the run with these values of the parameters; None without."""
    return next((result for result in results.values() if result.case.values == values), None)


def add_relatives(study, results):
    """Gives each result the answers that are ratios to another run."""
    for name, answer in study.answers.items():
        if "relative" not in answer:
            continue
        wanted, field_name = answer["relative"], RELATIVE_COSTS.get(answer["relative"])

        def of(result):
            return getattr(result, field_name) if field_name else result.answers.get(wanted)

        for result in results.values():
            other = _with_values(results, result.case.values | answer["run"])
            below = of(other) if other else None
            result.answers[name] = of(result) / below if below and of(result) is not None else None


def mixed_versions(study, results):
    """The versions of the program that results come from, where there are several and the study compares none; for a
    message, else empty."""
    commits = sorted({result.provenance["commit"] for result in results.values()})
    return ", ".join(commits) if len(commits) > 1 and not study.program else ""
