"""Runs of the program that a benchmark keeps: what is finished is not made again."""
import json
import os
import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[1]


def is_finished(folder):
    """Whether the folder holds a run that came to its end."""
    summary = folder / "summary.json"
    return summary.is_file() and json.loads(summary.read_text(encoding="utf-8"))["status"] == "finished"


def keep_run(program, scene, folder, settings, ranks=1, may_fail=False):
    """Runs a scene, a name in prm/ or a whole path, on one core per rank, from its restart file where there is one, unless it is finished.
    Raises CalledProcessError where the program fails and may not."""
    if is_finished(folder):
        return
    launcher = [str(ROOT / "scripts" / "mpirun"), "-n", str(ranks)] if ranks > 1 else []
    again = ["--restart"] if list(folder.rglob("restart.h5")) else []
    subprocess.run([*launcher, str(program), "run", str(ROOT / "prm" / scene), "--quiet", *again, "--output", str(folder),
                    "--set", *settings], check=not may_fail, env={**os.environ, "OMP_NUM_THREADS": "1"})
