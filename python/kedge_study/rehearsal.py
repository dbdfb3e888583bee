"""Evaluates the expressions of a study on made-up numbers, so that a misspelt name ends it before its runs do."""
import numpy as np

from .answers import function_of
from .expressions import evaluate, plain
from .study import BODY_COLUMNS

ROWS = np.array([1., 2., 3.])


def rehearse(study, case):
    """Raises StudyError for the first function that is missing, or expression that cannot be evaluated for a case.
    Columns of other tables than rigid_body.csv are known only after a run, so their expressions are left out."""
    where = str(study.path)
    known = case.names | {plain(name): np.float64(1.) for name in study.answers}
    columns = {name: ROWS for name in (*study.columns, *BODY_COLUMNS)}
    for group, entries in (("curves", study.curves), ("answers", study.answers)):
        for name, entry in entries.items():
            if "function" in entry:
                function_of(study, entry["function"], f"{where}: {group}.{name}")
    with np.errstate(all="ignore"):
        for name, curve in study.curves.items():
            if curve.get("table", "bodies") == "bodies" and "function" not in curve:
                for key in ("x", "y", *(["where"] if "where" in curve else [])):
                    evaluate(curve[key], case.names | columns, f"{where}: curves.{name}.{key}")
            for text, line in curve.get("lines", {}).items():
                evaluate(line, case.names | {"x": ROWS}, f"{where}: curves.{name}.lines.{text}")
        for name, answer in study.answers.items():
            if not evaluate(answer.get("only", 1), known, f"{where}: answers.{name}.only"):
                continue
            for key in ("from", "to", "x", "expression"):
                if key in answer:
                    evaluate(answer[key], known, f"{where}: answers.{name}.{key}")
        for name, references in study.references.items():
            for index, reference in enumerate(references):
                place = f"{where}: references.{name}[{index}]"
                if evaluate(reference.get("only", 1), case.names, f"{place}.only"):
                    evaluate(reference.get("value", 1), case.names, f"{place}.value")
        for name, part in study.parts.items():
            for index, chart in enumerate(part.get("charts", [])):
                evaluate(chart.get("only", 1), case.names, f"{where}: parts.{name}.charts[{index}].only")
