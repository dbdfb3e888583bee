"""Bodies that are held on soil, press it or are towed over it."""
import numpy as np


def largest_velocity(run):
    """Of the soil at the end, m/s."""
    return np.max(np.hypot(run.points("velocity_x"), run.points("velocity_z")))


def towing_error(run):
    """Median of the relative error of the horizontal force of the rod in the last stage: the friction of the sled's
    weight, less what the rod lifts. Where a corner of the soil comes under the sled's round edge, it takes more."""
    friction = run.input["contact"]["friction coefficient"]
    weight = -run.input["rigid bodies"][0]["points"][0]["mass"] * run.input["domain"]["gravity"][1]
    towed = (run.body("stage") == len(run.input["analysis"])) & (run.body("body1_position_x") > 1.02)
    along, up = (run.body(f"joint1_force_{axis}")[towed] for axis in "xz")
    return np.median(np.abs(along / (friction * (weight - up)) - 1.))


def leap(run):
    """Largest change of the first body's height in a step, m."""
    return np.max(np.abs(np.diff(run.body("body1_position_z"))))


def spin_error(run):
    """Difference of the spins of the first body, which is turned, and the second one about x at the end, rad/s."""
    stage, crank = run.input["analysis"][-1], run.input["rigid bodies"][0]["points"][0]
    exact = crank["boundary conditions"][3]["prescribed"] / stage["dt"]
    return abs(run.body("body2_angular velocity_x")[-1] - exact)


def stress_spread(run):
    """Largest less smallest vertical stress at the end, over its mean."""
    stress = run.points("stress_zz")
    return np.ptp(stress) / abs(np.mean(stress))


def wall_friction_error(run):
    """Largest relative error of the force along a wall in the ground that slides along itself, from the second step on:
    the soil's horizontal stress at rest on both faces times the friction."""
    given = run.input["material points"]
    layer = given["layers"][0]
    overburden = layer["material"]["density"] * -run.input["domain"]["gravity"][1] * layer["thickness"]
    friction = run.input["contact"]["friction coefficient"]
    exact = friction * given["initial stress"]["K0"] * overburden * layer["thickness"]
    force = -run.body("body1_reaction force_z")[1:]
    return np.max(np.abs(force / exact - 1.))


def adhesion_error(run):
    """Largest relative error of the force along a face of 45 degrees that slides along itself: the adhesion times the
    length that cuts the soil, from its lower to its right end."""
    start = run.input["rigid bodies"][0]["outline"][0]["polygon"][0]
    length = np.sqrt(2.) * (run.input["material points"]["material size"]["max"][0] - (start[0] - start[1]))
    force = (run.body("body1_reaction force_x") + run.body("body1_reaction force_z")) / np.sqrt(2.)
    return np.max(np.abs(force / (run.input["contact"]["adhesion"] * length) - 1.))


def idle_moment(run):
    """Mean moment that turns a smooth round body in clay, over that of a rough one; its facets make it waver."""
    outline = np.array(run.input["rigid bodies"][0]["outline"][0]["polygon"])
    strength = run.input["material points"]["layers"][0]["material"]["undrained strength"]
    return abs(np.mean(run.body("body1_reaction moment_y"))) / (0.5 * np.pi * np.ptp(outline[:, 0])**2 * strength)


def reaction_growth(run):
    """Mean vertical force on the first body over the second half of the run, over the first force, less 1."""
    force = run.body("body1_reaction force_z")
    return abs(np.mean(force[len(force) // 2:]) / force[0] - 1.)


def plastic_strain(run):
    """Largest plastic strain that soil at rest has got."""
    return np.max(run.points("plastic strain"))


def cycle_drift(run):
    """Change of the force after the first lift and return of a body until the last one, over what lifting it takes."""
    stage, force = run.body("stage"), run.body("body1_reaction force_z")
    ends = [force[stage == i][-1] for i in np.unique(stage)]
    lifted, returned = ends[1::2], ends[2::2]
    return abs(returned[-1] - returned[0]) / abs(lifted[0] - returned[0])
