#!/usr/bin/env python3
"""Figure of drift: closure conditions and energy against time, by stabilisation.

plot.py CSV [--out-dir DIR] writes an SVG and a PDF named after the CSV.
"""
import collections
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import figures
import matplotlib.pyplot as plt

PANELS = [("violation.position", "largest closure condition,\nmodel lengths or rad"),
          ("energy_drift", "energy not accounted for,\nof the energy")]
FLOOR = 1e-17


def read(path):
    """{model: {(metric, way): [(t, value)]}}."""
    data = collections.defaultdict(lambda: collections.defaultdict(list))
    rows = list(figures.rows(path))
    several = len({row["formulation"] for row in rows}) > 1
    for row in rows:
        if row["value"]:
            keys = dict(part.split("=", 1) for part in row["parameters"].split(";"))
            way = keys["integrator"] + ", " + keys["stabilisation"]
            if several:
                way = row["formulation"] + ", " + way
            data[row["model"]][row["metric"], way].append((float(keys["t"]), abs(float(row["value"]))))
    return data


def main():
    path, out = figures.begin(__doc__)
    data = read(path)
    if not data:
        return
    ways = sorted({way for curves in data.values() for _, way in curves})
    styles = figures.styles(ways)
    fig, grid = plt.subplots(len(PANELS), len(data), figsize=(4.4 * len(data) + 0.8, 6.4), sharex="col", sharey="row",
                             squeeze=False)
    handles = {}
    for column, (model, curves) in enumerate(data.items()):
        for line, (metric, label) in enumerate(PANELS):
            axes = grid[line][column]
            for way in ways:
                points = sorted(curves.get((metric, way), []))
                if points:
                    colour, style, _ = styles[way]
                    handles[way] = axes.plot([t for t, _ in points], [max(v, FLOOR) for _, v in points], color=colour,
                                             linestyle=style, linewidth=1.1)[0]
            axes.set_yscale("log")
            axes.grid(True, which="major", color="0.88", linewidth=0.6)
            if column == 0:
                axes.set_ylabel(label)
        grid[0][column].set_title(model.split("/")[-1], fontsize=9)
        grid[-1][column].set_xlabel("time, s")
    fig.legend([handles[w] for w in ways if w in handles], [w for w in ways if w in handles], loc="lower center", ncols=4,
               fontsize=8, frameon=False)
    fig.tight_layout(rect=(0, 0.07, 1, 1))
    figures.save(fig, out)


if __name__ == "__main__":
    main()
