#!/usr/bin/python3
"""Draws chart.png from table.csv and curves.csv. Usage: plot.py FOLDER"""
import csv
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt


def read(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def draw_curves(axes, soil, rows, points):
    """Draws resistance over displacement, the reference in black."""
    for number, row in enumerate(rows):
        curve = [point for point in points if (point["soil"], point["mesh"]) == (soil, row["mesh"])]
        axes.plot([0.] + [1e3 * float(point["displacement / m"]) for point in curve],
                  [0.] + [float(point["resistance / N"]) for point in curve],
                  color=f"C{number - 1}" if number else "black", linewidth=1.2 if number else 2, label=row["mesh"])
    axes.set_title(soil, fontsize=10)
    axes.set_xlabel("displacement / mm")
    axes.set_ylabel("resistance / N")
    axes.legend(fontsize=8)


def draw(folder):
    """Draws resistance over displacement by soil, and speed over difference, of all meshes in the folder's tables."""
    table, points = read(folder / "table.csv"), read(folder / "curves.csv")
    soils = list(dict.fromkeys(row["soil"] for row in table))
    figure, panels = plt.subplots(1, len(soils) + 1, figsize=(17, 4.2))
    for axes, soil, marker in zip(panels, soils, "os"):
        rows = [row for row in table if row["soil"] == soil]
        draw_curves(axes, soil, rows, points)
        for number, row in enumerate(rows[1:]):
            panels[-1].plot(abs(float(row["difference / %"])), float(row["faster"]), marker, color=f"C{number}",
                            label=f"{soil}, {row['mesh']}")
    panels[-1].axvline(2., color="0.6", linestyle="--", linewidth=1)
    panels[-1].axhline(8., color="0.6", linestyle="--", linewidth=1)
    panels[-1].set_xlim(left=0.)
    panels[-1].set_yscale("log")
    panels[-1].set_xlabel(f"difference of the mean resistance to {table[0]['mesh']} / %")
    panels[-1].set_ylabel(f"times faster than {table[0]['mesh']}")
    panels[-1].legend(fontsize=7, loc="upper left", bbox_to_anchor=(1.01, 1.))
    figure.tight_layout()
    figure.savefig(folder / "chart.png", dpi=90)


if __name__ == "__main__":
    draw(pathlib.Path(sys.argv[1]))
