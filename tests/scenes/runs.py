"""Runs the program on a scene."""
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "python"))

from kedge_runs import RunError  # noqa: E402  (found only after the line above)
from kedge_runs.program import ENVIRONMENT, ROOT, command  # noqa: E402
from kedge_runs.run import Run  # noqa: E402


def execute(program, folder, scene, ranks=1, **changes):
    """Runs a scene (a path relative to the repository), with the values in `set` replaced; returns the Run. Raises
    RunError where the program fails."""
    settings = changes.pop("set", [])
    if changes:
        raise RunError(f"a run has no \"{next(iter(changes))}\"")
    folder.mkdir(parents=True, exist_ok=True)
    words = command(program.resolve(), ROOT / scene, folder / "output", settings, ranks)
    try:
        done = subprocess.run(words, cwd=folder, env=ENVIRONMENT, capture_output=True, encoding="utf-8",
                              errors="replace", check=False)
    except OSError as error:
        raise RunError(f"{program}: cannot be started ({error.strerror})") from error
    if done.returncode:
        raise RunError(f"{scene}: exit code {done.returncode}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return Run(folder / "output", done.stdout)
