"""Small forces beside large ones, compared with closed forms."""
import numpy as np


def _motion(run):
    """Time of the last stage, s, and whether a row of the bodies' table belongs to it and is not its start."""
    last = run.body("stage") == len(run.input["analysis"])
    return run.body("time"), last & (run.body("time") > 0.)


def slide_error(run):
    """Error of the displacement along x of the block that a body force pushes, m."""
    time = run.input["analysis"][-1]["final time"]
    exact = 0.5 * run.input["domain"]["body force"]["expression"][0] * time**2
    return np.max(np.abs(run.points("displacement_x") - exact))


def fall_error(run):
    """Largest error of the height of the first body, m."""
    time, moving = _motion(run)
    start = run.input["rigid bodies"][0]["points"][0]["position"][1]
    exact = start + 0.5 * run.input["domain"]["gravity"][1] * time**2
    return np.max(np.abs(run.body("body1_position_z") - exact)[moving])


def push_error(run):
    """Largest error of the forces on the third body: along x its momentum over the first step, then none; its
    weight. N."""
    _, moving = _motion(run)
    stage, point = run.input["analysis"][-1], run.input["rigid bodies"][2]["points"][0]
    dt = stage.get("dt") if stage["type"] == "dynamic" else stage["basis step"]
    exact = np.zeros(np.count_nonzero(moving))
    exact[0] = point["mass"] * point["boundary conditions"][0]["prescribed"] / dt**2
    weight = -point["mass"] * run.input["domain"]["gravity"][1]
    along = run.body("body3_reaction force_x")[moving] - exact
    return max(np.max(np.abs(along)), np.max(np.abs(run.body("body3_reaction force_z")[moving] - weight)))


def tip_error(run):
    """Relative error of the largest displacement of a bar under a sudden body force, at a time when it is twice the
    static one."""
    length, layer = run.input["material points"]["material size"]["max"][0], run.input["material points"]["layers"][0]
    material, force = layer["material"], run.input["domain"]["body force"]["expression"][0]
    static = material["density"] * force * length**2 / (2. * material["E"])
    return abs(np.max(run.points("displacement_x")) / (2. * static) - 1.)


def drift_error(run):
    """Largest error of a displacement of soil that keeps its velocity, m."""
    time = run.input["analysis"][0]["final time"]
    velocity = run.input["material points"]["initial velocity"]["expression"]
    return max(np.max(np.abs(run.points(f"displacement_{axis}") - time * v)) for axis, v in zip("xz", velocity))


def _column(run):
    """Young's modulus, Pa, and height, m."""
    layer = run.input["material points"]["layers"][0]
    return layer["material"]["E"], layer["thickness"]


def pressure_error(run):
    """Largest relative error of the pressure that the column puts up against a platen in any step."""
    young, height = _column(run)
    point = run.input["rigid bodies"][0]["points"][0]
    weight = -point["mass"] * run.input["domain"]["gravity"][1]
    pressed = run.body("body1_position_z") < point["position"][1]
    exact = young * (point["position"][1] - run.body("body1_position_z")[pressed]) / height
    return np.max(np.abs((weight - run.body("body1_reaction force_z")[pressed]) / exact - 1.))


def settlement_error(run):
    """Relative error of the settlement of a platen under its own weight."""
    young, height = _column(run)
    point = run.input["rigid bodies"][0]["points"][0]
    exact = -point["mass"] * run.input["domain"]["gravity"][1] * height / young
    return abs((point["position"][1] - run.body("body1_position_z")[-1]) / exact - 1.)


def overburden_error(run):
    """Largest error of a vertical stress over the stress at the base: the weight above, across the surface."""
    height, gravity = _column(run)[1], run.input["domain"]["gravity"][1]
    density = run.input["material points"]["layers"][0]["material"]["density"]
    exact = density * gravity * (height - run.points("initial position_z"))
    return np.max(np.abs(run.points("stress_zz") - exact)) / abs(density * gravity * height)
