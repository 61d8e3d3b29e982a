#!/usr/bin/env python3
"""Figure of work-precision: error against processor time, a row of panels a problem, a column a stabilisation.

plot.py CSV [--out-dir DIR] writes an SVG and a PDF named after the CSV.
"""
import collections
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import figures
import matplotlib.pyplot as plt

TITLES = {"none": "none, or held by the integrator"}
COLUMNS = ["none", "baumgarte", "projection", "minimal"]


def read(path):
    """{problem: {stabilisation: {way: [(error, time)]}}}; a way is the integrator, and the formulation where they differ."""
    cells = collections.defaultdict(dict)
    for row in figures.rows(path):
        if row["value"]:
            cells[row["model"], row["formulation"], row["parameters"]][row["metric"]] = float(row["value"])
    formulations = {formulation for _, formulation, _ in cells}
    data = collections.defaultdict(lambda: collections.defaultdict(lambda: collections.defaultdict(list)))
    for (model, formulation, parameters), values in cells.items():
        keys = dict(part.split("=", 1) for part in parameters.split(";"))
        way = keys["integrator"] if len(formulations) == 1 else formulation + ", " + keys["integrator"]
        if values.get("error", 0) > 0 and "time" in values:
            data[model][keys["stabilisation"]][way].append((values["error"], values["time"]))
    return data


def main():
    path, out = figures.begin(__doc__)
    data = read(path)
    if not data:
        return
    columns = [s for s in COLUMNS if any(s in panels for panels in data.values())]
    ways = sorted({way for panels in data.values() for curves in panels.values() for way in curves})
    styles = figures.styles(ways)
    height = 1.75 * len(data) + 1.3
    fig, grid = plt.subplots(len(data), len(columns), figsize=(max(2.3 * len(columns) + 0.6, 5), height), squeeze=False,
                             sharex="row", sharey="row")
    handles = {}
    for line, (model, panels) in zip(grid, data.items()):
        for axes, column in zip(line, columns):
            if column not in panels:
                axes.set_visible(False)
                continue
            for way in ways:
                points = sorted(panels[column].get(way, []), key=lambda point: point[1])
                if points:
                    colour, style, marker = styles[way]
                    handles[way] = axes.plot([p[0] for p in points], [p[1] for p in points], color=colour,
                                             linestyle=style, marker=marker, markersize=3, linewidth=1)[0]
            axes.set_xscale("log")
            axes.set_yscale("log")
            axes.grid(True, which="major", color="0.88", linewidth=0.6)
            axes.set_title(model + ": " + TITLES.get(column, column), fontsize=8)
            axes.tick_params(labelsize=7)
        line[0].set_ylabel("processor time, s", fontsize=8)
    for axes, column in zip(grid[-1], columns):
        axes.set_xlabel("error of positions, m or rad", fontsize=8)
    fig.legend(handles.values(), handles.keys(), loc="lower center", ncols=5, fontsize=8, frameon=False)
    fig.tight_layout(rect=(0, 0.7 / height, 1, 1), h_pad=0.5, w_pad=0.3)
    figures.save(fig, out)


if __name__ == "__main__":
    main()
