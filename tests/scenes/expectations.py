"""Reads a file of expectations and compares results with it."""
import importlib
import json
from dataclasses import dataclass

BOUNDS = {
    "at most": lambda measured, bound: measured <= bound,
    "at least": lambda measured, bound: measured >= bound,
}


class ExpectationError(Exception):
    """A file of expectations that cannot be used."""


@dataclass
class Outcome:
    """A measured value and the bounds that it should keep."""

    statement: str
    measured: float
    bounds: dict
    holds: bool


def load(path):
    """Reads a file of expectations and checks its form."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise ExpectationError(f"{path}: {error}") from error
    for key in ("runs", "expect"):
        if not content.get(key):
            raise ExpectationError(f"{path}: \"{key}\" is missing or empty")
    for expectation in content["expect"]:
        for key in ("statement", "measure"):
            if key not in expectation:
                raise ExpectationError(f"{path}: an expectation lacks \"{key}\"")
        if not any(bound in expectation for bound in BOUNDS):
            raise ExpectationError(f"{path}: \"{expectation['statement']}\" states no bound ({', '.join(BOUNDS)})")
        unknown = set(expectation) - {"statement", "measure", "of", "with", *BOUNDS}
        if unknown:
            raise ExpectationError(f"{path}: \"{expectation['statement']}\" has an unknown \"{sorted(unknown)[0]}\"")
        for name in expectation.get("of", []):
            if name not in content["runs"]:
                raise ExpectationError(f"{path}: \"{expectation['statement']}\" names an unknown run \"{name}\"")
    return content


def judge(expectation, runs):
    """Measures the runs that the expectation is `of` (default: all of them, in their order)."""
    measure = _find_measure(expectation["measure"])
    chosen = [runs[name] for name in expectation.get("of", runs)]
    measured = float(measure(*chosen, **expectation.get("with", {})))
    bounds = {name: expectation[name] for name in BOUNDS if name in expectation}
    # NaN fulfils no bound
    holds = all(BOUNDS[name](measured, bound) for name, bound in bounds.items())
    return Outcome(expectation["statement"], measured, bounds, holds)


def table(outcomes):
    """One line per outcome."""
    width = max(len(outcome.statement) for outcome in outcomes)
    return "\n".join(f"{'pass' if outcome.holds else 'FAIL'}  {outcome.statement:<{width}}  {outcome.measured:<12.6g}"
                     + ", ".join(f"{name} {bound:g}" for name, bound in outcome.bounds.items())
                     for outcome in outcomes)


def _find_measure(name):
    module, _, function = name.partition(".")
    try:
        return getattr(importlib.import_module(f"measures.{module}"), function)
    except (ImportError, AttributeError) as error:
        raise ExpectationError(f"there is no measure \"{name}\"") from error
