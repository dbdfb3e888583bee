#!/usr/bin/python3
"""Counts what ranks send and keep, and what the linear solver needs, without a cluster: more ranks than cores do.

Soil under rough square footings, all parts of one rigid body, that refine the cells around them: weak scaling adds the
same piece of soil and footing for each rank, strong scaling cuts one block into more parts. Messages and bytes are
those of a step: a run of eight steps less one of four, through the profiling interface of MPI (count_messages.c)."""
import argparse
import csv
import json
import pathlib
import struct
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python"))

from kedge_runs.program import ENVIRONMENT, command, default_program  # noqa: E402  (found only after the line above)

RANKS = (1, 2, 4, 8, 16, 32, 64)
MOST_OF_ONE_MODEL = 16  # ranks that cut a model of given size
PIECES = {1: (1, 1), 2: (2, 1), 4: (2, 2), 8: (4, 2), 16: (4, 4), 32: (8, 4), 64: (8, 8)}  # along x and y
STEPS = (4, 8)
EDGE = 0.8  # of a piece, m
WIDTH, THICKNESS = 0.4, 0.2  # of a footing, m
COLUMNS = ("series", "ranks", "points", "unknowns", "messages", "bytes", "partners", "collectives", "collective bytes",
           "memory", "newton", "krylov", "commit")


def build_counter(folder):
    library = folder / "libcount.so"
    source = pathlib.Path(__file__).with_name("count_messages.c")
    subprocess.run(["mpicc", "-shared", "-fPIC", "-O2", "-o", library, source], check=True)
    return library


def write_footings(program, folder, pieces):
    """One surface of a footing in the middle of each piece, its base on the soil."""
    facets = []
    for i in range(pieces[0]):
        for j in range(pieces[1]):
            part = folder / "part.stl"
            centre = [EDGE * (i + 0.5), EDGE * (j + 0.5), EDGE + 0.5 * THICKNESS]
            subprocess.run([str(program), "geometry", "box", "--size", str(WIDTH), str(WIDTH), str(THICKNESS),
                            "--edge-radius", "0.02", "--translate", *map(str, centre), "--output", str(part)],
                           check=True, stdout=subprocess.DEVNULL)
            content = part.read_bytes()  # a header of 80 bytes, the number of facets, 50 bytes each
            facets.append(content[84:])
            part.unlink()
    data = b"".join(facets)
    (folder / "footings.stl").write_bytes(bytes(80) + struct.pack("<I", len(data) // 50) + data)


def write_scene(program, folder, pieces, cell, law):
    """A block of pieces; the footings refine the cells around them once."""
    width = [EDGE * n for n in pieces]
    write_footings(program, folder, pieces)
    elastic = law == "elastic"
    material = {"type": "elastic", "E": 1e6, "nu": 0.3, "density": 1600} if elastic else {
        "type": "mohr coulomb", "E": 1e6, "nu": 0.3, "density": 1600, "friction angle": 30, "dilation angle": 0,
        "cohesion": 1000}
    scene = {
        "GPU": "off",
        "domain": {"size": max(width), "gravity": [0, 0, -9.81]},
        "material points": {
            "extra capacity": 1,
            "element size": cell, "number of material points per element 1": 2,
            "material size": {"min": [0, 0], "max": width},
            "initial stress": {"type": "K0", "K0": 0.45},
            "layers": [{"thickness": EDGE, "material": material}]},
        "rigid bodies": [{
            "points": [{
                "position": [0.5 * width[0], 0.5 * width[1], EDGE + 0.1], "mass": 1, "rotational inertia": [1, 1, 1],
                "boundary conditions": ["fixed", "fixed", {"prescribed": -0.004}, "fixed", "fixed", "fixed"]}],
            "stl files": [{"stl": "footings.stl", "point": 1}]}],
        "contact": {"friction coefficient": 0.3},
        "analysis": [{
            "type": "static", "load steps": STEPS[0], "load": "full", "rigid bodies": "on",
            "adaptivity": {"type": "rigid body surface", "element size": 0.5 * cell},
            "boundary conditions": {"min": ["roller", "roller", "fixed"], "max": ["roller", "roller", "free"]}}],
        "solver": {
            "max newton iterations": 40, "poor factor": 0.25, "ghost factor mass": 0, "linear solver": "iterative"},
        "output": {"vtk": "off", "vtk directory": "vtk", "vtk percent": 100, "csv": "off", "csv directory": "csv",
                   "csv percent": 100, "csv material point fields": []}}
    file = folder / "scene.json"
    file.write_text(json.dumps(scene), encoding="utf-8")
    return file


def run(program, scene, folder, steps, ranks, counter):
    """Summary of a run and what its ranks counted."""
    folder.mkdir()
    words = command(program, scene, folder / "out", [f"analysis.0.load steps={steps}"], ranks, ["--quiet"])
    if ranks > 1:  # not in the launcher itself, which uses MPI's library, too
        place = words.index(str(program))
        words[place:place] = ["env", f"LD_PRELOAD={counter}", f"COUNT_MESSAGES={folder}"]
    # ranks that share a core leave it to the others while they wait
    environment = {**ENVIRONMENT, "OMPI_MCA_mpi_yield_when_idle": "1"}
    done = subprocess.run(words, capture_output=True, encoding="utf-8", env=environment)
    if done.returncode != 0:
        sys.exit(f"scaling.py: {' '.join(map(str, words))} ended with {done.returncode}:\n{done.stderr}{done.stdout}")
    summary = json.loads((folder / "out" / "summary.json").read_text(encoding="utf-8"))
    files = [folder / f"rank-{r}.json" for r in range(ranks)] if ranks > 1 else []
    counts = [json.loads(file.read_text(encoding="utf-8")) for file in files]
    return summary, counts


def measure(program, pieces, ranks, cell, counter, series, law="mohr coulomb"):
    """A line of the table: per step, of the rank with most."""
    with tempfile.TemporaryDirectory(prefix="kedge-scaling-") as name:
        folder = pathlib.Path(name)
        scene = write_scene(program, folder, pieces, cell, law)
        runs = [run(program, scene, folder / str(steps), steps, ranks, counter) for steps in STEPS]
    (first, few), (last, many) = runs
    stage, before = last["stages"][0], first["stages"][0]
    n = STEPS[1] - STEPS[0]

    def per_step(count):
        return max(((count(b) - count(a)) / n for a, b in zip(few, many)), default=0.)

    line = {
        "series": series, "ranks": ranks, "points": stage["material points"], "unknowns": stage["dofs"],
        "messages": per_step(lambda c: c["messages"]), "bytes": per_step(lambda c: c["bytes"]),
        "partners": max((c["partners"] for c in many), default=0),
        "collectives": per_step(lambda c: sum(k[0] for k in c["collectives"].values())),
        "collective bytes": per_step(lambda c: sum(k[1] for k in c["collectives"].values())),
        "memory": max((1024 * c["memory"] for c in many), default=last["peak memory"]),
        "newton": (stage["newton iterations"] - before["newton iterations"]) / n,
        "krylov": (stage["krylov iterations"] - before["krylov iterations"]) / n,
        "commit": last["commit"]}
    print("  ".join(f"{key} {value:.4g}" if isinstance(value, float) else f"{key} {value}"
                    for key, value in line.items()), flush=True)
    return line


def draw(tables, picture):
    """Weak series of one or two tables: what a rank sends in a step and how much memory it takes."""
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    panels = (("messages", "point-to-point messages of a rank in a step", 1.),
              ("bytes", "MB of these messages", 1e-6),
              ("collective bytes", "MB through collectives", 1e-6),
              ("memory", "largest memory of a rank / MB", 1e-6))
    figure, axes = pyplot.subplots(1, len(panels), figsize=(15, 3.6), layout="constrained")
    for table, marker in zip(tables, "os"):
        with open(table, newline="", encoding="utf-8") as file:
            lines = [line for line in csv.DictReader(file) if line["series"] == "weak"]
        for axis, (column, label, scale) in zip(axes, panels):
            axis.plot([int(line["ranks"]) for line in lines], [scale * float(line[column]) for line in lines],
                      marker + "-", label=lines[0]["commit"])
            axis.set(xscale="log", xlabel="ranks", ylabel=label, xticks=RANKS, xticklabels=RANKS)
    for axis in axes:
        axis.set_ylim(bottom=0)
        axis.minorticks_off()
    axes[0].legend(title="commit")
    figure.savefig(picture, dpi=120)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=pathlib.Path, default=default_program(), help="kedge to run")
    parser.add_argument("--series", nargs="+", choices=("weak", "strong", "size"), default=("weak", "strong", "size"))
    parser.add_argument("--cell", type=float, default=0.1, help="base cells of the weak and strong series, m")
    parser.add_argument("--ranks", nargs="+", type=int, choices=RANKS, default=RANKS)
    parser.add_argument("--output", type=pathlib.Path, default=pathlib.Path("scaling.csv"), help="table to write")
    parser.add_argument("--draw", nargs="+", type=pathlib.Path, metavar="TABLE",
                        help="measure nothing; draw the weak series of one or two tables beside the first one")
    options = parser.parse_args()
    if options.draw:
        draw(options.draw, options.draw[0].with_suffix(".png"))
        return
    program = options.program.resolve()
    lines = []
    with tempfile.TemporaryDirectory(prefix="kedge-counter-") as name:
        counter = build_counter(pathlib.Path(name))
        for ranks in options.ranks:
            if "weak" in options.series:
                lines.append(measure(program, PIECES[ranks], ranks, options.cell, counter, "weak"))
            if "strong" in options.series and ranks <= MOST_OF_ONE_MODEL:
                lines.append(measure(program, (2, 2), ranks, options.cell, counter, "strong"))
        if "size" in options.series:  # elastic soil: what the number of unknowns and the ranks do to the solver
            for ranks in (1, min(max(options.ranks), MOST_OF_ONE_MODEL)):
                for n in (1, 2, 4, 6):
                    lines.append(measure(program, (n, n), ranks, options.cell, counter, "size", "elastic"))
    with open(options.output, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(lines)


if __name__ == "__main__":
    main()
