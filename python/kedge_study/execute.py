"""Makes the runs that are missing: several at a time, the cheapest first, within the memory of the machine."""
import datetime
import json
import math
import os
import shutil
import signal
import subprocess
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

from kedge_runs.program import ENVIRONMENT

from . import StudyError, records
from .answers import check_columns
from .inputs import command_of, write_input
from .progress import Progress
from .records import Record

SHARE_OF_MEMORY = 0.85  # of what is free, for all runs together
STATUS = {0: "finished", 3: "failed", 143: "interrupted"}


@dataclass
class Job:
    """A run to make. estimate: "time" (s, of all ranks) and "memory" (B); empty where unknown."""
    case: object
    folder: object
    commit: str
    estimate: dict = field(default_factory=dict)
    process: object = None
    log: object = None
    started: float = 0.
    before: object = None  # record of an interrupted run that goes on
    is_over_limit: bool = False  # told to end because it has used its CPU time
    is_told: bool = False  # to end: a second signal would do so without a restart file

    @property
    def seconds(self):
        """Estimated CPU time, s."""
        return self.estimate.get("time", 1.)

    @property
    def memory(self):
        """Estimated memory, B."""
        return self.estimate.get("memory", 0.)


def missing(cases, work, again=False):
    """Jobs for the cases that have no result by the present version of their program; again: for all of them."""
    jobs = []
    for case in cases:
        commit = records.version_of(case.program)
        folder = case.folder(work, commit)
        record = records.read(folder)
        if again or not (record and record.is_result):
            jobs.append(Job(case, folder, commit, before=None if again else record))
    return jobs


def estimate(study, jobs, n_at_once):
    """Asks the program what the jobs will cost. Wrong input ends the study here."""
    if study.command:
        return

    def ask(job):
        job.folder.mkdir(parents=True, exist_ok=True)
        scene = write_input(study, job.case, job.folder)
        result = subprocess.run([str(job.case.program), "check", str(scene), "--json"], capture_output=True, text=True,
                                check=False, env=ENVIRONMENT)
        if result.returncode == 2 and "--json" not in result.stderr:
            raise StudyError(f"{study.path}: {job.case.name}: {result.stderr.strip()}")
        try:
            said = json.loads(result.stdout)
            stages = said["stages"]
        except (ValueError, KeyError):
            return  # an older program
        if "columns" in said:
            check_columns(study, said["columns"])
        job.estimate = {"time": sum(stage["time"] for stage in stages),
                        "memory": max(stage["memory"] for stage in stages)}

    with ThreadPoolExecutor(n_at_once) as pool:
        list(pool.map(ask, jobs))


def affordable(jobs, budget, n_at_once):
    """The jobs that fit, cheapest first, and those that do not with the reason. budget: wall time for all, s."""
    available = SHARE_OF_MEMORY * records.memory_of_machine()
    fit, left, total = [], [], 0.
    for job in sorted(jobs, key=lambda job: job.seconds):
        if job.memory > available:
            left.append((job, f"needs {1e-9 * job.memory:.1f} GB of memory, {1e-9 * available:.1f} GB are free"))
        elif (total + job.seconds) / n_at_once > budget:
            left.append((job, "does not fit into the budget"))
        else:
            total += job.seconds
            fit.append(job)
    return fit, left


class Pool:
    """Runs jobs side by side."""

    def __init__(self, study, n_at_once, time_limit):
        """n_at_once: cores to use. time_limit: CPU time of a run, s."""
        self.study, self.cores, self.time_limit = study, n_at_once, time_limit
        self.running, self.interrupted = [], False

    def run(self, jobs):
        """Makes the runs; an interruption stops them so that they can go on later. Returns whether all ended."""
        waiting, progress = list(jobs), Progress(self.study, jobs, self.cores)
        previous = {number: signal.signal(number, self._stop) for number in (signal.SIGINT, signal.SIGTERM)}
        try:
            while (waiting and not self.interrupted) or self.running:
                while waiting and not self.interrupted and self._has_room(waiting[0]):
                    self._start(waiting.pop(0))
                time.sleep(0.05)
                for job in list(self.running):
                    if record := self._ended(job):
                        self.running.remove(job)
                        progress.ended(job, record)
                progress.show(self.running, waiting)
        finally:
            self._terminate()  # an error leaves no run behind
            for number, handler in previous.items():
                signal.signal(number, handler)
            progress.close()
        return not self.interrupted

    def _has_room(self, job):
        if not self.running:
            return True
        memory = sum(other.memory for other in self.running) + job.memory
        return (sum(other.case.ranks for other in self.running) + job.case.ranks <= self.cores
                and memory <= SHARE_OF_MEMORY * records.memory_of_machine())

    def _start(self, job):
        is_restart = bool(job.before) and any((job.folder / "output").rglob("restart.h5"))
        if not is_restart:
            job.before = None
            shutil.rmtree(job.folder, ignore_errors=True)
        job.folder.mkdir(parents=True, exist_ok=True)
        if not self.study.command:
            write_input(self.study, job.case, job.folder)
        words = command_of(self.study, job.case, job.folder, is_restart)
        job.log = open(job.folder / "log", "a" if is_restart else "w", encoding="utf-8")
        job.started = time.time()
        self.running.append(job)  # before it starts: an interruption meanwhile does not miss it
        try:
            job.process = subprocess.Popen(words, stdout=job.log, stderr=job.log, cwd=job.folder,
                                           start_new_session=True, env=ENVIRONMENT)
        except OSError as error:
            raise StudyError(f"{words[0]}: cannot be started ({error.strerror})") from error
        self._record(job, "interrupted", "").write(job.folder)  # holds if this program is killed
        if self.interrupted:
            self._terminate()

    def _ended(self, job):
        """The record of a job that has ended; None while it runs."""
        pid, status, usage = os.wait4(job.process.pid, os.WNOHANG)
        if not pid:
            may_go_on = math.isinf(self.time_limit) or job.is_over_limit
            if not may_go_on and cpu_time_of_session(job.process.pid) > self.time_limit:
                job.is_over_limit = job.is_told = True
                os.killpg(job.process.pid, signal.SIGTERM)
            return None
        job.process.returncode = os.waitstatus_to_exitcode(status)
        job.log.close()
        code = job.process.returncode
        kind = STATUS.get(code, "interrupted" if self.interrupted else "crashed")
        message = "" if code == 0 else last_line(job.folder / "log") or f"exit code {code}"
        if job.is_over_limit and code:
            kind, message = "stopped", f"time limit of {self.study.time_limit}"
        if code in (2, 4):
            raise StudyError(f"{self.study.path}: {job.case.name}: {message}")
        record = self._record(job, kind, message)
        record.cpu += usage.ru_utime + usage.ru_stime
        record.wall += time.time() - job.started
        record.memory = max(record.memory, 1024. * usage.ru_maxrss)
        record.write(job.folder)
        return record

    def _record(self, job, status, message):
        before = job.before
        words = command_of(self.study, job.case, job.folder, False)
        return Record(status, job.case.input, job.commit, job.case.ranks, records.machine(), message,
                      before.cpu if before else 0., before.wall if before else 0., before.memory if before else 0.,
                      datetime.date.today().isoformat(), words, job.estimate)

    def _stop(self, number, frame):
        for job in self.running if self.interrupted else ():
            job.is_told = False  # a second signal ends the runs at once, as it does alone
        self.interrupted = True
        self._terminate()

    def _terminate(self):
        """Asks all runs to end; they write restart files first."""
        for job in self.running:
            if not job.process or job.is_told:
                continue
            job.is_told = True
            try:
                os.killpg(job.process.pid, signal.SIGTERM)
            except ProcessLookupError:
                pass


def last_line(path):
    """The last line of a log that says anything."""
    try:
        lines = path.read_text(encoding="utf-8", errors="replace").replace("\r", "\n").splitlines()
    except OSError:
        return ""
    said = [line.strip() for line in lines if line.strip()]
    errors = [line for line in said if line.startswith(("kedge: ", "error", "Error"))]
    return (errors or said or [""])[-1]


def cpu_time_of_session(leader):
    """CPU time of all processes of a session, s; 0 where the system does not tell."""
    ticks = 0
    for entry in os.scandir("/proc") if os.path.isdir("/proc") else ():
        if entry.name.isdigit():
            try:
                with open(f"{entry.path}/stat", encoding="utf-8") as file:
                    fields = file.read().rpartition(")")[2].split()
            except OSError:
                continue
            if int(fields[3]) == leader:
                ticks += int(fields[11]) + int(fields[12])
    return ticks / os.sysconf("SC_CLK_TCK")
