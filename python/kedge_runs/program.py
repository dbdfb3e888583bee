"""Starts the program."""
import os
import pathlib
import shutil

ROOT = pathlib.Path(__file__).resolve().parents[2]
ENVIRONMENT = {**os.environ, "OMP_NUM_THREADS": "1"}  # one core per rank


def default_program():
    """The program of this copy: what scripts/build has made or, of an installed copy, what lies on the PATH."""
    built, installed = ROOT / "build" / "kedge", shutil.which("kedge")
    return pathlib.Path(installed) if installed and not built.exists() else built


def command(program, scene, folder, settings=(), ranks=1, options=()):
    """The words of a command that runs a scene into a folder. settings: arguments of --set, each "key=value"."""
    launcher = [str(ROOT / "scripts" / "mpirun"), "-n", str(ranks)] if ranks > 1 else []
    changes = [word for setting in settings for word in ("--set", setting)]
    return [*launcher, str(program), "run", str(scene), "--output", str(folder), *options, *changes]
