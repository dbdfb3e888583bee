#!/usr/bin/python3
"""Draws the condition numbers of a moved block over its offset. Usage: plot.py conditions.csv conditions.png"""
import csv
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

SHOWN = {"stiffness": ["0", "0.001", "0.03333", "1"], "mass": ["0", "0.001", "0.25", "10"]}
COLOURS = ["tab:red", "tab:orange", "tab:blue", "tab:green"]


def read_curves(name):
    """Offsets and condition numbers by (dimension, mesh, basis, matrix, factor)."""
    curves = {}
    with open(name, encoding="utf-8") as file:
        for row in csv.DictReader(file):
            for factor in list(row)[5:]:
                key = (row["dimension"], row["mesh"], row["basis"], row["matrix"], factor)
                curves.setdefault(key, []).append((float(row["offset"]), float(row[factor])))
    return curves


def draw_panel(axes, curves, dimension, mesh, matrix):
    """Draws one matrix on one mesh: GIMP for all factors, the standard MPM without stabilisation."""
    for factor, colour in zip(SHOWN[matrix], COLOURS):
        label = "GIMP, no stabilisation" if factor == "0" else f"GIMP, {float(factor):.2g}"
        axes.semilogy(*zip(*curves[dimension, mesh, "gimp", matrix, factor]), color=colour, linewidth=1, label=label)
    axes.semilogy(*zip(*curves[dimension, mesh, "mpm", matrix, "0"]), color="0.6", linewidth=0.7, zorder=0,
                  label="MPM, no stabilisation")
    axes.set_title(f"{matrix}, {dimension}-D, {mesh}", fontsize=9)
    axes.set_xlim(0, 1)
    axes.set_ylim(3, 3e16)
    axes.tick_params(labelsize=8)


def main():
    curves = read_curves(sys.argv[1])
    figure, panels = plt.subplots(2, 4, figsize=(13, 6), sharex=True, sharey=True)
    for row, matrix in enumerate(SHOWN):
        for column, (dimension, mesh) in enumerate((d, m) for d in "23" for m in ("uniform", "octree")):
            draw_panel(panels[row][column], curves, dimension, mesh, matrix)
        panels[row][0].set_ylabel("largest / smallest eigenvalue")
        panels[row][0].legend(fontsize=7, loc="center", bbox_to_anchor=(0.55, 0.62))
    for axes in panels[1]:
        axes.set_xlabel("offset / base cell")
    figure.tight_layout()
    figure.savefig(sys.argv[2], dpi=80)


if __name__ == "__main__":
    main()
