"""Times of kernels from the file that Google Benchmark writes: least CPU time of the repetitions, s; None for a kernel
that the run did not time."""
import json

UNITS = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.}


def _least(run, kernel):
    """Least time per particle, or per stress update where the kernel treats one at a time."""
    entries = json.loads((run.folder / "speed.json").read_text(encoding="utf-8"))["benchmarks"]
    times = [entry.get("s/particle", entry["cpu_time"] * UNITS[entry["time_unit"]]) for entry in entries
             if entry["run_type"] == "iteration" and entry["name"].partition("/")[0] == kernel]
    return min(times, default=None)


def stress_and_force(run, values):
    return _least(run, "stress_and_force")


def tangent(run, values):
    return _least(run, "tangent")


def newton_iteration(run, values):
    return _least(run, "newton_iteration")


def stencils(run, values):
    return _least(run, "stencils")


def time_step(run, values):
    return _least(run, "time_step")


def stress(run, values):
    return _least(run, "stress")


def stress_and_tangent(run, values):
    return _least(run, "stress_and_tangent")
