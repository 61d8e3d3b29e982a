#!/usr/bin/env python3
"""Figure of batch: time a body and state against the number of bodies, one by one, in lanes and on all cores.

plot.py CSV [--out-dir DIR] writes an SVG and a PDF named after the CSV.
"""
import collections
import pathlib
import re
import statistics
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import figures
import matplotlib.pyplot as plt


def main():
    path, out = figures.begin(__doc__)
    times = collections.defaultdict(lambda: collections.defaultdict(list))
    for row in figures.rows(path):
        if row["phase"] == "total" and row["metric"] == "time" and row["value"]:
            family = re.sub(r"^([^:]+):\d+", r"\1", row["model"])
            ways = dict(part.split("=") for part in row["parameters"].split(";"))
            if "core" in ways:  # for the gain of cores
                continue
            key = family, row["formulation"], int(ways["lanes"]), int(ways["threads"])
            times[key][int(row["bodies"])].append(1e9 * float(row["value"]) / int(row["bodies"]))
    if not times:
        return
    families = sorted({key[0] for key in times})
    fig, grid = plt.subplots(1, len(families), figsize=(3.6 * len(families) + 0.6, 3.6), sharey=True, squeeze=False)
    for axes, family in zip(grid[0], families):
        curves = sorted(key for key in times if key[0] == family)
        for index, key in enumerate(curves):
            sizes = sorted(times[key])
            _, formulation, lanes, threads = key
            axes.plot(sizes, [statistics.median(times[key][n]) for n in sizes], color=figures.COLOURS[index],
                      linestyle=figures.LINES[index], marker=figures.MARKERS[index], markersize=4.5,
                      label=f"{formulation}: {lanes} lane{'s' * (lanes > 1)}, {threads} core{'s' * (threads > 1)}")
        axes.set_xscale("log")
        axes.set_xlabel("bodies n")
        axes.set_title(family, fontsize=10)
        axes.grid(True, which="major", color="0.88", linewidth=0.6)
    grid[0][0].set_ylim(bottom=0)
    grid[0][0].set_ylabel("time a body and state, ns")
    grid[0][0].legend(fontsize=8, frameon=False)
    fig.tight_layout()
    figures.save(fig, out)


if __name__ == "__main__":
    main()
