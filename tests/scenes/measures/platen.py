"""A platen at rest on soil, from a static into an explicit stage."""
import numpy as np


def growth(run):
    """Root mean square of the vertical velocity in the last fifth of the explicit stage over that in the first."""
    velocity = run.body("body1_velocity_z")[run.body("stage") == 2]
    fifth = len(velocity) // 5
    return np.std(velocity[-fifth:]) / np.std(velocity[:fifth])


def wander(run):
    """How far the platen has wandered from where the static stage left it, m."""
    height = run.body("body1_position_z")
    return abs(np.mean(height[-len(height) // 5:]) - height[run.body("stage") == 1][-1])


def speed(run):
    """Root mean square of the vertical velocity in the last fifth of the explicit stage, m/s."""
    velocity = run.body("body1_velocity_z")[run.body("stage") == 2]
    return np.sqrt(np.mean(velocity[-(len(velocity) // 5):]**2))
