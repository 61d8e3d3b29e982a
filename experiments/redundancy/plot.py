#!/usr/bin/env python3
"""Figure of redundancy: time by formulation and linkage, marked by status.

plot.py CSV [--out-dir DIR] writes an SVG and a PDF named after the CSV.
"""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import figures
import matplotlib.pyplot as plt

MARKERS = {"solved": ("o", "#0072b2"), "redundant": ("s", "#009e73"), "singular": ("^", "#d55e00"),
           "inconsistent": ("X", "#cc79a7")}


def main():
    path, out = figures.begin(__doc__)
    times = {}
    for row in figures.rows(path):
        if row["formulation"] and row["phase"] == "total" and row["metric"] == "time" and row["value"]:
            times[row["model"], row["formulation"]] = float(row["value"]), row["status"]
    if not times:
        return
    models = list(dict.fromkeys(model for model, _ in times))
    names = figures.order({name for _, name in times})
    fig, grid = plt.subplots(1, len(names), figsize=(1.15 * len(names) + 2.6, 0.19 * len(models) + 1.4), sharey=True,
                             sharex=True, squeeze=False)
    for axes, name in zip(grid[0], names):
        for place, model in enumerate(models):
            if (model, name) in times:
                seconds, status = times[model, name]
                marker, colour = MARKERS.get(status, ("x", "#000000"))
                axes.plot(seconds * 1e6, place, marker, color=colour, markersize=4)
        axes.set_xscale("log")
        axes.set_title(name, fontsize=7)
        axes.grid(alpha=0.3)
    grid[0][0].set_yticks(range(len(models)), models, fontsize=6)
    grid[0][0].invert_yaxis()
    fig.supxlabel("time of one evaluation with kinematics and rank decision, µs", fontsize=8)
    handles = [plt.Line2D([], [], marker=m, color=c, linestyle="", label=s) for s, (m, c) in MARKERS.items()]
    fig.legend(handles=handles, loc="upper center", ncols=len(handles), fontsize=7, frameon=False)
    fig.tight_layout(rect=(0, 0, 1, 0.95))
    figures.save(fig, out)


if __name__ == "__main__":
    main()
