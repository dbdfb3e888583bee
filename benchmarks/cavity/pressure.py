#!/usr/bin/python3
"""Pressure and radius of an expanding cavity, and the pressure that an incompressible soil of the same strength asks
for at that radius. As a program it prints them for every table of runs: pressure.py FOLDER ...

With r^k - R^k = a^k - a0^k (k = 2 for the cylinder, 3 for the sphere) and the strength s_u, equilibrium gives for
|sigma_theta - sigma_r| <= 2 s_u the integral of rho b dr over the ring, rho b (r1 - a), as

    cylinder: s_u (1 + ln((G / s_u) (1 - (a0 / a)^2))),  sphere: 4/3 s_u (1 + ln((G / s_u) (1 - (a0 / a)^3))),

once the soil at the cavity yields (Bishop, Hill & Mott 1945; Gibson & Anderson 1961)."""
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "python"))

from kedge_runs.run import Run  # noqa: E402  (found only after the line above)

_SMOOTH = 3.  # m: beyond this no material point was cut out


def expansion(run, step=None):
    """The state of the cavity at a step, by default the last one: "radius" over the initial one, "pressure" and "exact"
    pressure over s_u, and "scatter", the standard deviation of r^k - R^k in the ring over its mean. The initial radii
    of cavity and ring are those of circles or spheres with the volumes of the points that were cut out and are
    pushed."""
    scene = run.input
    dim = scene.get("dimension", 3)
    soil, force = scene["material points"]["layers"][0]["material"], scene["domain"]["body force"]["definitions"]
    strength = soil["yield stress"] / (np.sqrt(3.) if dim == 2 else 2.)
    shear = 0.5 * soil["E"] / (1. + soil["nu"])
    sector = np.pi / (4. if dim == 2 else 6.)  # volume of the quarter or eighth over R^k

    axes = "xz" if dim == 2 else "xyz"
    before, now = (np.array([run.points(f"{field}_{axis}", step) for axis in axes])
                   for field in ("initial position", "position"))
    volume = run.points("initial volume", step)
    start, end = np.linalg.norm(before, axis=0), np.linalg.norm(now, axis=0)
    ring = start < 2. * force["a0"]
    hole = _SMOOTH**dim - np.sum(volume[np.all(before < _SMOOTH, axis=0)])
    initial = np.array([hole, hole + np.sum(volume[ring])]) / sector  # a0^k and r1^k
    shift = (end**dim - start**dim)[ring]
    mean = np.average(shift, weights=volume[ring])
    inner, outer = (initial + mean)**(1. / dim)
    number = run.csv_steps()[-1] if step is None else step
    load = run.body("time")[run.body("step") == number][0]
    share = shear / strength * mean / inner**dim
    return {"radius": inner / initial[0]**(1. / dim),
            "pressure": soil["density"] * force["b"] * load * (outer - inner) / strength,
            "exact": (1. if dim == 2 else 4. / 3.) * (1. + np.log(share)) if share > 1. else np.nan,
            "scatter": np.sqrt(np.average((shift - mean)**2, weights=volume[ring])) / mean}


def pressure_error(run, values):
    """Relative error of the pressure at the end of a run; values: those of the study, not needed."""
    state = expansion(run)
    return state["pressure"] / state["exact"] - 1.


def main():
    for folder in sys.argv[1:]:
        run = Run(folder)
        print(f"{folder}\n  a / a0   P / s_u   exact   error    scatter")
        for step in run.csv_steps():
            if run.body("stage")[run.body("step") == step][0] > 1:
                state = expansion(run, step)
                error = 100. * (state["pressure"] / state["exact"] - 1.)
                print("  {radius:.4f}   {pressure:.4f}   {exact:.4f}".format(**state), f" {error:6.2f} %",
                      f" {state['scatter']:.3f}")


if __name__ == "__main__":
    main()
