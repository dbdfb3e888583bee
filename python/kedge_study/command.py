"""The command kedge-study."""
import argparse
import json
import os
import pathlib
import shutil
import sys

from kedge_runs import RunError
from kedge_runs.program import default_program

from . import StudyError, execute, page, results
from .cases import cases_of
from .progress import duration, seconds
from .rehearsal import rehearse
from .study import SCHEMA, load


def parser():
    """The options."""
    options = argparse.ArgumentParser(
        prog="kedge-study",
        description="Runs one scene of Kedge many times and charts what it answers against what it should and what it "
                    "costs. The study, a JSON file, says what varies. Runs that are there are not repeated; an "
                    "interrupted study goes on where it was.",
        epilog="Example: kedge-study benchmarks/strip-plate/normal.study.json --estimate. doc/studies.md explains the "
               "file, python/kedge_study/study.schema.json is its schema. Exit codes: 0 done, 1 a result is not what "
               "the study expects, 2 wrong study or input, 130 interrupted.")
    options.add_argument("study", metavar="FILE", nargs="?", help="the study, *.study.json")
    options.add_argument("--schema", action="store_true", help="print the JSON Schema of studies, for editors")
    options.add_argument("--estimate", action="store_true", help="only say what the missing runs will cost")
    options.add_argument("--draw", action="store_true",
                         help="run nothing: draw the runs that are there and those of the kept table")
    options.add_argument("--quick", action="store_true", help="make the smallest form of the study, as the tests do")
    options.add_argument("--parts", nargs="+", metavar="PART", help="only these parts (default: all)")
    options.add_argument("--jobs", type=_count, default=os.cpu_count(), metavar="N",
                         help="cores to use (default: all, %(default)s)")
    options.add_argument("--budget", type=_time, default=float("inf"), metavar="TIME",
                         help="wall time for the runs, such as \"30 min\": dearer runs are left out (default: none)")
    options.add_argument("--program", type=pathlib.Path, default=default_program(),
                         help="kedge to run (default: %(default)s)")
    options.add_argument("--output", type=pathlib.Path, metavar="DIR",
                         help="folder for tables, charts and runs (default: <name of the study>-study)")
    options.add_argument("--work", type=pathlib.Path, metavar="DIR", help="folder for the runs (default: DIR/runs)")
    options.add_argument("--keep", action="store_true",
                         help="put table, curves and charts beside the study, too: the kept results")
    options.add_argument("--again", action="store_true", help="repeat the runs that are there")
    options.add_argument("--mix", action="store_true",
                         help="allow results of several versions of the program; --draw needs no leave")
    return options


def _count(text):
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text}: use at least 1")
    return number


def _time(text):
    try:
        time = seconds(text)
        if not time > 0.:
            raise ValueError
        return time
    except (KeyError, ValueError) as error:
        raise argparse.ArgumentTypeError(f"{text}: write a number and s, min or h, such as \"30 min\"") from error


def main(arguments=None):
    """Runs the command; returns its exit code."""
    options = parser().parse_args(arguments)
    if options.schema:
        print(SCHEMA.read_text(encoding="utf-8"), end="")
        return 0
    if not options.study:
        parser().error("name a study: *.study.json")
    try:
        return _study(options)
    except RunError as error:
        print(f"kedge-study: {error}", file=sys.stderr)
        return 2


def _study(options):
    study = load(options.study, options.quick)
    output = options.output or pathlib.Path(f"{study.name}-study")
    work = (options.work or output / "runs").resolve()
    parts = cases_of(study, options.program, options.parts)
    cases = list({case.key: case for of_part in parts.values() for case in of_part}.values())
    for case in cases:
        rehearse(study, case)
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StudyError(f"{output}: cannot be created ({error.strerror})") from error
    if not options.draw:
        ended = _run(study, cases, work, options)
        if options.estimate:
            return 0
        if not ended:
            print("interrupted; the same command goes on", file=sys.stderr)
            return 130
    found = results.of_runs(study, cases, work) if work.is_dir() else {}
    if options.draw:
        found = results.of_table(study, cases, study.folder) | found
        found = {case.key: found[case.key] for case in cases if case.key in found}
    if not found:
        raise StudyError(f"{study.path}: there are no results yet" + (" of this input" if options.draw else ""))
    if mixed := results.mixed_versions(study, found):
        mixed = f"the results come from several versions of the program ({mixed})"
        if not options.mix and not options.draw:
            raise StudyError(f"{study.path}: {mixed}; run the study again, or allow it with --mix")
        print(f"{study.name}: {mixed}")
    results.add_relatives(study, found)
    results.add_references(study, found)
    results.write_table(study, found, output)
    for line in page.notes(found.values()):
        print(f"{study.name}: {line}", file=sys.stderr)
    print(page.write(study, parts, found, output, work))
    if options.keep:
        _keep(study, output)
    return 1 if _unexpected(study, found, len(cases)) else 0


def _run(study, cases, work, options):
    """Makes the missing runs; whether they all ended."""
    jobs = execute.missing(cases, work, options.again)
    if not jobs:
        print(f"{study.name}: all {len(cases)} runs are there")
        return True
    execute.estimate(study, jobs, options.jobs)
    fit, left = execute.affordable(jobs, options.budget, options.jobs)
    for job, reason in left:
        print(f"left out: {job.case.name}: {reason}")
    total = sum(job.seconds for job in fit)
    known = any(job.estimate for job in fit)
    memory = max((job.memory for job in fit), default=0.)
    print(f"{study.name}: {len(fit)} of {len(cases)} runs to make" + (
        f", roughly {duration(total)} of CPU time, {duration(total / options.jobs)} on {options.jobs} cores, at most "
        f"{1e-9 * memory:.2g} GB each" if known else ""), flush=True)
    if options.estimate:
        for job in fit:
            print(f"  {job.case.name}: " + (f"{duration(job.seconds)}, {1e-9 * job.memory:.2g} GB" if job.estimate
                                            else "unknown"))
        return True
    limit = seconds(study.time_limit) if study.time_limit else float("inf")
    return execute.Pool(study, options.jobs, limit).run(fit)


def _keep(study, output):
    """Copies what the repository keeps beside the study."""
    if output.resolve() == study.folder:
        return
    for path in sorted(output.glob(f"{study.name}[.-]*")):
        if path.suffix in (".csv", ".md", ".png"):
            shutil.copyfile(path, study.folder / path.name)


def _unexpected(study, found, n_cases):
    """Prints what is not as the study expects; whether there is any."""
    problems = []
    if len(found) < n_cases and study.expect:
        problems.append(f"{n_cases - len(found)} of {n_cases} runs have no result")
    for result in found.values():
        if not result.is_finished and not study.may_fail:
            problems.append(f"{result.case.name}: {result.status}: {result.message}")
        for name, (low, high) in study.expect.items():
            value = result.answers.get(name)
            if value is None or not low <= value <= high:
                problems.append(f"{result.case.name}: {name} = {json.dumps(value)} is not in [{low:g}, {high:g}]")
    for problem in problems:
        print(f"kedge-study: {problem}", file=sys.stderr)
    return bool(problems)
