"""What is kept of a run: how it ended and what it cost, in record.json of its folder."""
import dataclasses
import functools
import hashlib
import json
import os
import pathlib
import re
import subprocess

from . import StudyError

RESULTS = ("finished", "failed", "stopped", "crashed")  # of these a study draws what there is


@dataclasses.dataclass
class Record:
    """status: one of RESULTS, or "interrupted". message: what the program said at its end. Times in s, memory in B."""
    status: str
    input: str
    commit: str
    ranks: int
    machine: str
    message: str = ""
    cpu: float = 0.
    wall: float = 0.
    memory: float = 0.
    date: str = ""
    command: list = dataclasses.field(default_factory=list)
    estimate: dict = dataclasses.field(default_factory=dict)

    @property
    def is_result(self):
        """Whether the run came to an end of its own."""
        return self.status in RESULTS

    def write(self, folder):
        """Replaces the folder's record at once, so that no reader sees half of it."""
        new = folder / "record.json.new"
        new.write_text(json.dumps(dataclasses.asdict(self), indent=1) + "\n", encoding="utf-8")
        new.rename(folder / "record.json")


def read(folder):
    """The record of a folder; None where there is none."""
    try:
        return Record(**json.loads((folder / "record.json").read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):
        return None


@functools.lru_cache(maxsize=None)
def version_of(program):
    """Commit that a program was built from; a hash of its file where it does not know it."""
    program = pathlib.Path(program)
    try:
        text = subprocess.run([program, "--version"], capture_output=True, text=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError) as error:
        reason = getattr(error, "strerror", None) or f"exit code {error.returncode}"
        raise StudyError(f"{program}: cannot be started ({reason}); scripts/build builds it, --program names another"
                         ) from error
    found = re.search(r"commit ([^\s,)]+)", text)
    if found and found[1] != "unknown":
        return found[1]
    return "file-" + hashlib.sha256(program.read_bytes()).hexdigest()[:8]


@functools.lru_cache(maxsize=None)
def machine():
    """Processor and number of cores."""
    try:
        text = pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8")
        name = re.search(r"model name\s*:\s*(.*)", text)[1]
    except (OSError, TypeError):
        name = os.uname().machine
    return f"{' '.join(name.split())}, {os.cpu_count()} cores"


def memory_of_machine():
    """Memory that programs can have, B."""
    try:
        text = pathlib.Path("/proc/meminfo").read_text(encoding="utf-8")
        return 1024. * int(re.search(r"MemAvailable:\s*(\d+)", text)[1])
    except (OSError, TypeError):
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
