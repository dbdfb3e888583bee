"""Runs of the program that a benchmark keeps and does not repeat once they are finished."""
import subprocess

from kedge_runs import RunError
from kedge_runs.program import ENVIRONMENT, ROOT, command
from kedge_runs.run import Run


def is_finished(folder):
    """Whether the folder holds a run that reached its end."""
    try:
        return Run(folder).is_finished
    except RunError:
        return False


def keep_run(program, scene, folder, settings, ranks=1, may_fail=False):
    """Runs a scene, a name in prm/ or a whole path, on one core per rank, unless the folder holds the finished run.
    Continues from the folder's restart file if there is one. Raises CalledProcessError where the program fails, unless
    it may fail."""
    if is_finished(folder):
        return
    options = ["--quiet"] + (["--restart"] if list(folder.rglob("restart.h5")) else [])
    subprocess.run(command(program, ROOT / "prm" / scene, folder, settings, ranks, options), check=not may_fail,
                   env=ENVIRONMENT)
