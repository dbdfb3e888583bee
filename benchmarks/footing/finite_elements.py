#!/usr/bin/env python3
"""N_gamma of the smooth footing of this folder by finite elements of small strain, for comparison: what do the cells
alone cost, without material points, contact and large motion?

    finite_elements.py 0.1 0.05        # cell sizes, m; one minute and six minutes

Quadrilaterals with four nodes and one change of volume (mean dilatation, Nagtegaal et al. 1974, doi
10.1016/0045-7825(74)90032-2), or with eight nodes, both with 2 x 2 points. Mohr-Coulomb in plane strain with phi = psi
= 30 degrees and 20 Pa of cohesion, as the scene has; the stress out of the plane is the middle one. The nodes at up to
half the footing's width sink by 0.002 widths in 20 steps.
"""
import argparse

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import spsolve

WIDTH, SINKAGE, STEPS = 1., 0.002, 20
BLOCK = (3.2, 2.4)  # m, beside the axis and down
YOUNG, POISSON, UNIT_WEIGHT, COHESION, K0 = 2e8, 0.3, 2e4, 20., 0.5  # Pa, -, N/m3, Pa, -
SIN_PHI, COS_PHI = 0.5, np.sqrt(0.75)
SHEAR = YOUNG / (2. * (1. + POISSON))
PLANE_BULK = YOUNG / (3. * (1. - 2. * POISSON)) + SHEAR / 3.  # of the mean stress in the plane
MOST_ITERATIONS, TOLERANCE = 60, 2e-6  # of the weight
REST = 1e-3  # of the elastic stiffness, kept at the apex
CORNERS = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])


def return_to_surface(trial):
    """Stress (xx, zz, xz) and its derivative by the strain (xx, zz, 2 xz) for trial stresses, both with a row for each
    point. With the mean m and the radius R of Mohr's circle the surface is R + m sin phi = c cos phi."""
    mean, half = (trial[:, 0] + trial[:, 1]) / 2., (trial[:, 0] - trial[:, 1]) / 2.
    radius = np.hypot(half, trial[:, 2]) + 1e-300
    along, across = half / radius, trial[:, 2] / radius  # direction of the circle's diameter
    excess = radius + mean * SIN_PHI - COHESION * COS_PHI
    hardness = SHEAR + PLANE_BULK * SIN_PHI**2
    step = np.maximum(excess, 0.) / hardness
    end_radius, end_mean = radius - SHEAR * step, mean - PLANE_BULK * SIN_PHI * step
    elastic, apex = excess <= 0., end_radius < 0.
    end_radius[apex], end_mean[apex] = 0., COHESION * COS_PHI / SIN_PHI
    stress = np.stack([end_mean + end_radius * along, end_mean - end_radius * along, end_radius * across], 1)

    def choose(if_elastic, if_plastic, at_apex):
        return np.where(elastic, if_elastic, np.where(apex, at_apex, if_plastic))

    mean_by_mean = choose(1., 1. - PLANE_BULK * SIN_PHI**2 / hardness, REST)
    mean_by_radius = choose(0., -PLANE_BULK * SIN_PHI / hardness, 0.)
    radius_by_mean = choose(0., -SHEAR * SIN_PHI / hardness, 0.)
    radius_by_radius = choose(1., 1. - SHEAR / hardness, REST)
    turn = choose(1., end_radius / radius, REST)
    tangent = np.empty((len(trial), 3, 3))
    for column, (d_mean, d_half, d_shear) in enumerate(
            [(PLANE_BULK, SHEAR, 0.), (PLANE_BULK, -SHEAR, 0.), (0., 0., SHEAR)]):
        d_radius, d_turn = along * d_half + across * d_shear, turn * (along * d_shear - across * d_half)
        d_end_mean = mean_by_mean * d_mean + mean_by_radius * d_radius
        d_end_radius = radius_by_mean * d_mean + radius_by_radius * d_radius
        tangent[:, 0, column] = d_end_mean + d_end_radius * along - d_turn * across
        tangent[:, 1, column] = d_end_mean - d_end_radius * along + d_turn * across
        tangent[:, 2, column] = d_end_radius * across + d_turn * along
    return stress, tangent


def make_mesh(size, n_nodes):
    """Nodes (x, z) and the nodes of each element, corners first and then the middles of its edges."""
    cells = [round(length / size) for length in BLOCK]
    fine = 1 if n_nodes == 4 else 2
    lines = [np.linspace(0., length, fine * n + 1) for length, n in zip(BLOCK, cells)]
    x, z = np.meshgrid(*lines, indexing="ij")
    number = np.arange(x.size).reshape(x.shape)

    def nodes_at(right, up):
        return number[right:right + fine * (cells[0] - 1) + 1:fine, up:up + fine * (cells[1] - 1) + 1:fine]

    places = [(0, 0), (fine, 0), (fine, fine), (0, fine)] + [(1, 0), (2, 1), (1, 2), (0, 1)] * (fine - 1)
    elements = np.stack([nodes_at(*place) for place in places], -1).reshape(-1, n_nodes)
    used, elements = np.unique(elements, return_inverse=True)
    return np.stack([x.ravel()[used], z.ravel()[used]], 1), elements.reshape(-1, n_nodes)


def shape_functions(n_nodes, at):
    """Values at a place of the square from -1 to 1."""
    x, z = at
    corners = (1. + CORNERS[:, 0] * x) * (1. + CORNERS[:, 1] * z) / 4.
    if n_nodes == 4:
        return corners
    middles = np.array([(1. - x * x) * (1. - z), (1. + x) * (1. - z * z), (1. - x * x) * (1. + z),
                        (1. - x) * (1. - z * z)]) / 2.
    return np.concatenate([corners - (middles + np.roll(middles, 1)) / 2., middles])


def strain_matrices(size, n_nodes):
    """At the 2 x 2 points: shape functions, and strain (xx, zz, 2 xz) by the displacements of the nodes."""
    values, matrices = [], []
    for at in CORNERS / np.sqrt(3.):
        values.append(shape_functions(n_nodes, at))
        tiny = 1e-6  # central differences are exact for functions of second order along each axis
        slope = [(shape_functions(n_nodes, at + step) - shape_functions(n_nodes, at - step)) / (tiny * size)
                 for step in tiny * np.eye(2)]
        matrix = np.zeros((3, 2 * n_nodes))
        matrix[0, ::2] = matrix[2, 1::2] = slope[0]
        matrix[1, 1::2] = matrix[2, ::2] = slope[1]
        matrices.append(matrix)
    matrices = np.array(matrices)
    if n_nodes == 4:
        dilation = matrices[:, 0] + matrices[:, 1]
        matrices[:, :2] += ((dilation.mean(0) - dilation) / 2.)[:, None]
    return np.array(values), matrices


def push(size, n_nodes):
    """2 Q / (gamma B^2) after each step."""
    nodes, elements = make_mesh(size, n_nodes)
    values, strain = strain_matrices(size, n_nodes)
    weight = size**2 / 4.  # of a point
    dofs = np.stack([2 * elements, 2 * elements + 1], -1).reshape(len(elements), -1)
    n_dofs = 2 * len(nodes)
    vertical = -UNIT_WEIGHT * (BLOCK[1] - np.einsum("gn,en->eg", values, nodes[elements][:, :, 1]))
    stress = np.stack([K0 * vertical, vertical, 0. * vertical], -1)
    load = np.zeros(n_dofs)
    for value in values:
        np.add.at(load, 2 * elements + 1, -UNIT_WEIGHT * weight * value)
    x, z = nodes.T
    held = np.zeros(n_dofs, bool)
    held[::2] = (x < 1e-9) | (x > BLOCK[0] - 1e-9) | (z < 1e-9)
    footing = (z > BLOCK[1] - 1e-9) & (x < WIDTH / 2. + 1e-9)
    held[1::2] = (z < 1e-9) | footing
    free = np.flatnonzero(~held)
    rows, columns = np.repeat(dofs, dofs.shape[1], 1).ravel(), np.tile(dofs, (1, dofs.shape[1])).ravel()
    elastic = np.array([[PLANE_BULK + SHEAR, PLANE_BULK - SHEAR, 0.], [PLANE_BULK - SHEAR, PLANE_BULK + SHEAR, 0.],
                        [0., 0., SHEAR]])

    def evaluate(increment):
        trial = stress + np.einsum("ij,gjk,ek->egi", elastic, strain, increment[dofs], optimize=True)
        end, tangent = return_to_surface(trial.reshape(-1, 3))
        end = end.reshape(trial.shape)
        force = -load
        np.add.at(force, dofs, weight * np.einsum("gik,egi->ek", strain, end, optimize=True))
        return force, end, tangent.reshape(*trial.shape, 3)

    def stiffness(tangent):
        blocks = weight * np.einsum("gia,egij,gjb->eab", strain, tangent, strain, optimize=True)
        return csc_matrix((blocks.ravel(), (rows, columns)), shape=(n_dofs, n_dofs))

    factors = []
    for _ in range(STEPS):
        increment = np.zeros(n_dofs)
        force, end, tangent = evaluate(increment)
        matrix = stiffness(tangent)
        increment[1::2][footing] = -SINKAGE / STEPS
        increment[free] = spsolve(matrix[free][:, free], -(force + matrix @ increment)[free])
        force, end, tangent = evaluate(increment)
        for _ in range(MOST_ITERATIONS):
            error = np.linalg.norm(force[free])
            if error < TOLERANCE * np.linalg.norm(load):
                break
            change = np.zeros(n_dofs)
            change[free] = spsolve(stiffness(tangent)[free][:, free], -force[free])
            share = 1.
            while True:
                force, end, tangent = evaluate(increment + share * change)
                if np.linalg.norm(force[free]) < error or share < 0.02:
                    break
                share /= 2.
            increment += share * change
        stress = end
        factors.append(-4. * force[1::2][footing].sum() / (UNIT_WEIGHT * WIDTH**2))
    return factors


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("sizes", type=float, nargs="+", help="cell sizes, m")
    for size in parser.parse_args().sizes:
        for n_nodes in (4, 8):
            print(f"cells of {size:g} m, {n_nodes} nodes: N_gamma {push(size, n_nodes)[-1]:.2f}", flush=True)


if __name__ == "__main__":
    main()
