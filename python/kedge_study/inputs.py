"""The input file of one run: the scene with the settings of its case."""
import copy
import json
import os
import subprocess

from kedge_runs.program import ROOT

from . import StudyError
from .cases import MADE, content_of


def write_input(study, case, folder):
    """Writes scene.json and the surfaces of a case into a folder; returns the path of scene.json."""
    for file, words in case.surfaces.items():
        make = [str(case.program), "geometry", *words, "--output", str(folder / file)]
        result = subprocess.run(make, capture_output=True, text=True, check=False)
        if result.returncode:
            raise StudyError(f"{study.path}: geometry.{file}: {result.stderr.strip() or result.stdout.strip()}")
    scene = copy.deepcopy(content_of(case.scene))
    for path, value in case.settings:
        replace(scene, path, value, f"{study.path}: set.{path}")
    for system in scene.get("rigid bodies", []):
        for entry in system.get("stl files", []):
            if not entry["stl"].startswith(MADE):
                entry["stl"] = os.path.abspath(case.scene.parent / entry["stl"])
    text = json.dumps(scene, indent=1).replace(MADE, str(folder.resolve()))
    (folder / "scene.json").write_text(text + "\n", encoding="utf-8")
    return folder / "scene.json"


def replace(content, path, value, where):
    """Sets the value at a path such as "analysis.0.load steps"; None removes it. The path but for its last key must
    exist."""
    *steps, last = [int(step) if step.isdigit() else step for step in path.split(".")]
    for step in steps:
        try:
            content = content[step]
        except (KeyError, IndexError, TypeError):
            raise StudyError(f"{where}: the scene has no \"{step}\" there") from None
    try:
        if value is None:
            del content[last]
        else:
            content[last] = value
    except (KeyError, IndexError, TypeError):
        raise StudyError(f"{where}: the scene has no \"{last}\" there") from None


def command_of(study, case, folder, is_restart):
    """Words of the command that makes a run in a folder."""
    if study.command:
        return [str(case.program.resolve().parent / case.words[0]), *case.words[1:]]
    launcher = [str(ROOT / "scripts" / "mpirun"), "-n", str(case.ranks)] if case.ranks > 1 else []
    options = ["--restart"] if is_restart else []
    return [*launcher, str(case.program), "run", str(folder / "scene.json"), "--output", str(folder / "output"),
            "--quiet", *options]
