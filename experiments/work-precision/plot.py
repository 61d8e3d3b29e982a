#!/usr/bin/env python3
"""Figure of work-precision: error against processor time, a panel a problem.

plot.py CSV [--out-dir DIR] writes an SVG and a PDF named after the CSV.
"""
import collections
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import figures
import matplotlib.pyplot as plt


def read(path):
    """{problem: {way: [(error, time)]}}; a way is formulation, integrator and stabilisation as far as they differ."""
    cells = collections.defaultdict(dict)
    for row in figures.rows(path):
        if row["value"]:
            cells[row["model"], row["formulation"], row["parameters"]][row["metric"]] = float(row["value"])
    formulations = {formulation for _, formulation, _ in cells}
    data = collections.defaultdict(lambda: collections.defaultdict(list))
    for (model, formulation, parameters), values in cells.items():
        keys = dict(part.split("=", 1) for part in parameters.split(";"))
        way = keys["integrator"] + ("" if keys["stabilisation"] == "none" else ", " + keys["stabilisation"])
        if len(formulations) > 1:
            way = formulation + ", " + way
        if values.get("error", 0) > 0 and "time" in values:
            data[model][way].append((values["error"], values["time"]))
    return data


def main():
    path, out = figures.begin(__doc__)
    data = read(path)
    if not data:
        return
    ways = sorted({way for curves in data.values() for way in curves})
    styles = figures.styles(ways)
    columns = min(4, len(data))
    lines = -(-len(data) // columns)
    fig, grid = plt.subplots(lines, columns, figsize=(max(2.9 * columns + 0.6, 7.5), 2.7 * lines + 2), squeeze=False)
    handles = {}
    for axes, (model, curves) in zip(grid.flat, data.items()):
        for way in ways:
            if curves.get(way):
                points = sorted(curves[way], key=lambda point: point[1])
                colour, style, marker = styles[way]
                handles[way] = axes.plot([p[0] for p in points], [p[1] for p in points], color=colour, linestyle=style,
                                         marker=marker, markersize=3.5, linewidth=1.1)[0]
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.grid(True, which="major", color="0.88", linewidth=0.6)
        axes.set_title(model, fontsize=9)
        axes.set_xlabel("largest error of positions, m or rad")
    for axes in grid.flat[len(data):]:
        axes.set_visible(False)
    for line in grid:
        line[0].set_ylabel("processor time, s")
    fig.legend([handles[w] for w in ways if w in handles], [w for w in ways if w in handles], loc="lower center", ncols=4,
               fontsize=8, frameon=False)
    fig.tight_layout(rect=(0, 1.7 / (2.7 * lines + 2), 1, 1))
    figures.save(fig, out)


if __name__ == "__main__":
    main()
