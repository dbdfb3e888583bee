"""Reads a study: the file, its schema, and that its names fit together."""
import copy
import difflib
import json
import pathlib
import re
from dataclasses import dataclass, field

import jsonschema

from . import StudyError
from .expressions import names_in, plain

SCHEMA = pathlib.Path(__file__).with_name("study.schema.json")
BODY_COLUMNS = ("time", "step", "stage")  # of rigid_body.csv, known by these names
RELATIVE_COSTS = {"CPU time": "cpu", "wall time": "wall", "memory": "memory"}


@dataclass
class Study:
    """One *.study.json. Expressions in it are not evaluated yet."""
    path: pathlib.Path
    title: str
    question: str
    parts: dict
    source: str = ""
    scene: str = ""
    command: list = field(default_factory=list)
    constants: dict = field(default_factory=dict)
    parameters: dict = field(default_factory=dict)
    derived: dict = field(default_factory=dict)
    set: dict = field(default_factory=dict)
    when: list = field(default_factory=list)
    geometry: dict = field(default_factory=dict)
    ranks: object = 1
    program: str = ""
    time_limit: str = ""
    columns: dict = field(default_factory=dict)
    curves: dict = field(default_factory=dict)
    answers: dict = field(default_factory=dict)
    references: dict = field(default_factory=dict)
    quick: dict = field(default_factory=dict)
    expect: dict = field(default_factory=dict)
    may_fail: bool = True

    @property
    def name(self):
        """Name of the study's files: that of its own file without endings."""
        return self.path.name.split(".")[0]

    def stem_of(self, part):
        """Beginning of the names of a part's files."""
        return f"{self.name}-{re.sub(r'[ /]', '-', part)}"

    @property
    def folder(self):
        """Folder of the study, to which its paths are relative."""
        return self.path.resolve().parent

    def label(self, name):
        """Text for a parameter or an answer in tables and charts."""
        known = self.parameters.get(name) or self.answers.get(name) or {}
        return known.get("label", name)

    def head_and_unit(self, name):
        """The two parts of a label; an empty unit where it has none."""
        head, _, unit = self.label(name).partition(" / ")
        return head, unit

    def scale(self, name):
        """Factor from SI to the unit of a label."""
        known = self.parameters.get(name) or self.answers.get(name) or {}
        return known.get("scale", 1.)

    def text(self, name, value):
        """A parameter's value as text."""
        known = self.parameters[name].get("names", {})
        plain = format(value, "g") if isinstance(value, (int, float)) and not isinstance(value, bool) else str(value)
        if plain in known:
            return known[plain]
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            return format(value * self.scale(name), ".4g")
        return plain


def load(path, quick=False):
    """The study in a file; quick: its smallest form."""
    path = pathlib.Path(path)
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise StudyError(f"{path}: cannot be read ({error.strerror})") from error
    except ValueError as error:
        raise StudyError(f"{path}: not JSON ({error})") from error
    schema = json.loads(SCHEMA.read_text(encoding="utf-8"))
    problems = sorted(jsonschema.Draft7Validator(schema).iter_errors(content), key=lambda error: list(error.path))
    if problems:
        raise StudyError(f"{path}: {_message(problems[0])}")
    if quick:
        content = _smallest(content)
    known = {key.replace(" ", "_"): value for key, value in content.items() if key not in ("$schema", "comment")}
    study = Study(path=path, **known)
    _check_names(study)
    return study


def _smallest(content):
    """The content with what `quick` says in place of the rest."""
    content = copy.deepcopy(content)
    quick = content.pop("quick", {})
    for name, value in quick.get("parameters", {}).items():
        if name not in content.get("parameters", {}):
            raise StudyError(f"quick.parameters: unknown parameter {name}{_near(name, content['parameters'])}")
        content["parameters"][name]["default"] = value
    content["set"] = content.get("set", {}) | quick.get("set", {})
    content["parts"] = quick.get("parts", {"quick": {"runs": [{}]}})
    return content | {"expect": quick.get("expect", {}), "may fail": quick.get("may fail", False)}


def _message(error):
    """What is wrong, where, and the nearest key."""
    while error.context:
        error = max(error.context, key=lambda inner: len(inner.path))
    where = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in error.path).lstrip(".")
    where = where or "top level"
    if error.validator == "additionalProperties":
        known = error.schema.get("properties", {})
        unknown = next(key for key in error.instance if key not in known)
        return f"{where}: unknown key \"{unknown}\"{_near(unknown, known)}"
    meaning = error.schema.get("description") if error.validator != "required" else None
    return f"{where}: {error.message}" + (f"; expected: {meaning}" if meaning else "")


def _near(name, known):
    close = difflib.get_close_matches(name, known, 1)
    return f"; did you mean \"{close[0]}\"?" if close else f"; known: {', '.join(known)}"


def _check_meanings(study):
    """No name means two things in an expression."""
    declared = {}
    groups = {"constants": study.constants, "parameters": study.parameters, "derived": study.derived,
              "columns": study.columns, "answers": [plain(name) for name in study.answers]}
    for group, names in groups.items():
        for name in names:
            if name in declared and (declared[name], group) != ("columns", "answers"):  # these two never meet
                raise StudyError(f"{study.path}: {group}.{name}: {declared[name]} has that name, too")
            declared[name] = group
    for name, curve in study.curves.items():
        if curve.get("table", "bodies") != "bodies":
            continue
        for side in ("x", "y", "where"):
            where = f"{study.path}: curves.{name}.{side}"
            for used in names_in(curve.get(side, 0), where):
                if used in BODY_COLUMNS and declared.get(used) in ("constants", "parameters", "derived"):
                    raise StudyError(f"{where}: {used} is a column of rigid_body.csv and one of {declared[used]}; "
                                     f"give the column another name under \"columns\"")


def _check_names(study):
    """Every name that one key uses another one declares."""
    def require(name, known, what, where):
        if name not in known:
            raise StudyError(f"{study.path}: {where}: there is no {what} \"{name}\"{_near(name, known)}")

    _check_meanings(study)
    for name, answer in study.answers.items():
        if "curve" in answer:
            if answer["take"] == "at" and "x" not in answer:
                raise StudyError(f"{study.path}: answers.{name}: \"at\" needs \"x\"")
            require(answer["curve"], study.curves, "curve", f"answers.{name}.curve")
        if answer.get("relative", "CPU time") not in RELATIVE_COSTS:
            require(answer["relative"], study.answers, "answer", f"answers.{name}.relative")
        for parameter in answer.get("run", {}):
            require(parameter, study.parameters, "parameter", f"answers.{name}.run")
    for name, references in study.references.items():
        require(name, study.answers, "answer", f"references.{name}")
        for index, reference in enumerate(references):
            for key in ("by", "finest"):
                if key in reference:
                    require(reference[key], study.parameters, "parameter", f"references.{name}[{index}].{key}")
            for parameter in reference.get("run", {}):
                require(parameter, study.parameters, "parameter", f"references.{name}[{index}].run")
            if "table" in reference and "by" not in reference:
                raise StudyError(f"{study.path}: references.{name}[{index}]: a table needs \"by\", a parameter's name")
    for name, part in study.parts.items():
        where = f"parts.{name}"
        for values in [part.get("fixed", {}), part.get("grid", {}), part.get("one at a time", {}),
                       *part.get("runs", [])]:
            for parameter in values:
                require(parameter, study.parameters, "parameter", where)
        for answer in part.get("columns", []):
            require(answer, study.answers, "answer", f"{where}.columns")
        for index, chart in enumerate(part.get("charts", [])):
            place = f"{where}.charts[{index}]"
            if "answer" in chart:
                require(chart["answer"], study.answers, "answer", place)
            if "curve" in chart:
                require(chart["curve"], study.curves, "curve", place)
            if chart["kind"] in ("convergence", "over"):
                require(chart.get("over", ""), study.parameters, "parameter", f"{place}.over")
                if isinstance(study.parameters[chart["over"]]["default"], (str, list, dict)):
                    raise StudyError(f"{study.path}: {place}.over: {chart['over']} is no number")
    for name in study.expect:
        require(name, study.answers, "answer", f"quick.expect.{name}")
