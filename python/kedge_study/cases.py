"""The runs of a study: what varies, the settings that follow, and the key by which a run is known."""
import hashlib
import itertools
import json
import pathlib
import re
from dataclasses import dataclass

from . import StudyError
from .expressions import evaluate, resolve


MADE = "$SURFACES"  # stands for the folder of a run in which "geometry" makes surfaces


@dataclass
class Case:
    """One run to make. values: parameters; names: these, constants and derived values; scene: path; settings: (path,
    value) in the order of the study; surfaces: words of kedge geometry by file name; words: of a command; input: hash
    of all that decides the result."""
    values: dict
    names: dict
    scene: object
    settings: list
    surfaces: dict
    words: list
    ranks: int
    program: pathlib.Path
    name: str
    input: str

    @property
    def key(self):
        """Tells the cases of a study apart, also those of equal input that differ in how a run is read."""
        return self.input, self.name

    def folder(self, work, version):
        """Folder of the run by one version of the program."""
        key = hashlib.sha256(f"{self.input} {version}{self.name[60:]}".encode()).hexdigest()[:8]
        return work / f"{self.name[:60]}-{key}"


def cases_of(study, program, parts=None):
    """The cases of each part, by its name. Equal cases are the same object."""
    known, result = {}, {}
    for name in parts or study.parts:
        if name not in study.parts:
            raise StudyError(f"{study.path}: there is no part \"{name}\"; there are {', '.join(study.parts)}")
        result[name] = []
        for values in _combinations(study, study.parts[name]):
            values = {key: _whole(value) for key, value in values.items()}
            key = json.dumps(values, sort_keys=True)
            if key not in known:
                known[key] = make_case(study, values, program)
            if known[key] not in result[name]:
                result[name].append(known[key])
    return result


def _whole(value):
    """Whole numbers without a point, so that 1e6 and 1000000 are the same value."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def default_values(study, part):
    """Values of all parameters where a part changes none."""
    return {name: parameter["default"] for name, parameter in study.parameters.items()} | part.get("fixed", {})


def _combinations(study, part):
    """Values of all parameters for each run of a part."""
    default = default_values(study, part)
    if "grid" in part:
        for values in itertools.product(*part["grid"].values()):
            yield default | dict(zip(part["grid"], values))
    elif "one at a time" in part:
        yield default
        for name, values in part["one at a time"].items():
            yield from (default | {name: value} for value in values)
    else:
        yield from (default | values for values in part["runs"])


def make_case(study, values, program):
    """The case with these values of the parameters."""
    where = str(study.path)
    values, names = {key: _whole(value) for key, value in values.items()}, {}
    for name, value in study.constants.items():
        names[name] = resolve(value, names, f"{where}: constants.{name}")
    names |= values
    for name, expression in study.derived.items():
        names[name] = evaluate(expression, names, f"{where}: derived.{name}")
    surfaces = {file: _words(resolve(words, names, f"{where}: geometry.{file}"))
                for file, words in study.geometry.items()}

    def surface(file):
        if file not in surfaces:
            raise StudyError(f"{where}: surface('{file}') is not made by \"geometry\"")
        return f"{MADE}/{file}"

    groups = [study.set] + [entry["set"] for index, entry in enumerate(study.when)
                            if evaluate(entry["if"], names, f"{where}: when[{index}].if")]
    settings = [(path, resolve(value, names, f"{where}: set.{path}", surface=surface))
                for group in groups for path, value in group.items()]
    words = _words(resolve(study.command, names, f"{where}: command"))
    scene = study.folder / resolve(study.scene, names, f"{where}: scene") if study.scene else None
    ranks = int(evaluate(study.ranks, names, f"{where}: ranks"))
    if ranks < 1:
        raise StudyError(f"{where}: ranks: {ranks}; a run needs at least 1")
    chosen = resolve(study.program, names, f"{where}: program") if study.program else ""
    chosen = study.folder / chosen if chosen else pathlib.Path(program).resolve()
    read = content_of(scene)
    files = [file for system in read.get("rigid bodies", []) for file in _files_of_surfaces("", system)]
    files += [file for path, value in settings for file in _files_of_surfaces(path, value)
              if not file.startswith(MADE)]
    content = {"scene": _without_comments(read), "settings": settings, "surfaces": surfaces,
               "words": words, "ranks": ranks, "files": [_hash_of(scene.parent / file) for file in files]}
    key = hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:12]
    return Case(values, names, scene, settings, surfaces, words, ranks, chosen, _name(study, values), key)


def _words(values):
    """Words of a command from values and lists of values."""
    return [str(word) for value in values for word in (value if isinstance(value, (list, tuple)) else [value])]


def content_of(scene):
    """Content of an input file; empty without one."""
    if not scene:
        return {}
    try:
        return json.loads(scene.read_text(encoding="utf-8"))
    except OSError as error:
        raise StudyError(f"{scene}: cannot be read ({error.strerror})") from error
    except ValueError as error:
        raise StudyError(f"{scene}: not JSON ({error})") from error


def _without_comments(value):
    if isinstance(value, dict):
        return {key: _without_comments(entry) for key, entry in value.items() if key not in ("comment", "$schema")}
    return [_without_comments(entry) for entry in value] if isinstance(value, list) else value


def _files_of_surfaces(path, value):
    """The files of surfaces that a value at a path of an input names, in their order."""
    if isinstance(value, dict):
        return [file for key, entry in value.items() for file in _files_of_surfaces(key, entry)]
    if isinstance(value, list):
        return [file for entry in value for file in _files_of_surfaces("", entry)]
    return [value] if path.rpartition(".")[2] == "stl" and isinstance(value, str) else []


def _hash_of(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()[:12] if path.is_file() else ""


def _name(study, values):
    """A name for the run's folder: what differs from the defaults."""
    parts = [f"{name}-{value}" for name, value in values.items() if value != study.parameters[name]["default"]]
    return re.sub(r"[^A-Za-z0-9.,_+-]+", "_", ",".join(parts)) or "default"


def label(study, case, cases):
    """What distinguishes a case from the others of its part, for legends."""
    return described(study, case, varied(study, cases)) or study.title


def described(study, case, names, with_units=True):
    """The values of some parameters as text; a value that has a name of its own stands alone."""
    parts = []
    for name in names:
        text = study.text(name, case.values[name])
        head, unit = study.head_and_unit(name)
        is_named = text in study.parameters[name].get("names", {}).values()
        parts.append(text if is_named else f"{head} {text} {unit if with_units else ''}".strip())
    return ", ".join(parts)


def varied(study, cases):
    """Names of the parameters that differ between cases."""
    return [name for name in study.parameters if len({json.dumps(case.values[name]) for case in cases}) > 1]
