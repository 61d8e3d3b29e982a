#!/usr/bin/env python3
"""Figure of backends: time and fill-in of every solver and setting, as multiples of the recursion and a body.

plot.py CSV [--out-dir DIR] writes an SVG and a PDF named after the CSV: one column a topology, its largest model.
"""
import collections
import pathlib
import statistics
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import figures
import matplotlib.pyplot as plt

PHASES = ["assemble", "factorise", "solve"]


def read(path):
    """{model: {(formulation, settings): {(phase, metric): [values]}}}, bodies by model"""
    data = collections.defaultdict(lambda: collections.defaultdict(lambda: collections.defaultdict(list)))
    bodies = {}
    for row in figures.rows(path):
        bodies[row["model"]] = int(row["bodies"])
        if row["value"]:
            key = row["formulation"], row["parameters"]
            data[row["model"]][key][row["phase"], row["metric"]].append(float(row["value"]))
    return data, bodies


def settings(key):
    name, parameters = key
    return f"{name}  " + ", ".join(p.partition("=")[2] if "pivoting" not in p and "refinement" not in p
                                   else p.replace("=", " ") for p in parameters.split(";") if p)


def seconds(values):
    return sum(statistics.median(values.get((phase, "time"), [float("nan")])) for phase in PHASES)


def main():
    path, out = figures.begin(__doc__)

    data, bodies = read(path)
    largest = {}
    for model in data:
        kind = model.split(":")[0]
        if kind not in largest or bodies[model] > bodies[largest[kind]]:
            largest[kind] = model
    models = list(largest.values())
    if not models:
        return
    keys = sorted({key for model in models for key in data[model]}, key=lambda k: (k[0] != "recursive", k))
    panels = [("time a body, µs\n(assemble + factorise + solve)", lambda v, n: 1e6 * seconds(v) / n),
              ("non-zeros of the factors, a body",
               lambda v, n: statistics.median(v.get(("factorise", "nonzeros"), [float("nan")])) / n),
              ("backward error of eq. 14,\n● componentwise  ○ normwise", None)]
    markers = ["o", "s", "^", "D"]
    shades = ["#000000", "#d55e00", "#0072b2", "#009e73"]
    fig, grid = plt.subplots(1, 3, figsize=(12.5, 0.27 * len(keys) + 1.6), sharey=True)
    rows = range(len(keys))
    for index, model in enumerate(models):
        marker, shade = markers[index % 4], shades[index % 4]
        at = [row + 0.16 * (index - (len(models) - 1) / 2) for row in rows]  # topologies do not cover each other
        for axes, (_, value) in zip(grid, panels):
            if value:
                axes.plot([value(data[model][key], bodies[model]) for key in keys], at, linestyle="", marker=marker,
                          color=shade, markersize=4.5, label=model)
                continue
            for metric, fill in (("componentwise", shade), ("normwise", "none")):
                found = [data[model][key].get(("solve", "backward_error_" + metric), [float("nan")])[0] for key in keys]
                axes.plot(found, at, linestyle="", marker=marker, markeredgecolor=shade, markerfacecolor=fill,
                          markersize=4)
    for axes, (label, _) in zip(grid, panels):
        axes.set_xscale("log")
        axes.set_xlabel(label)
        axes.grid(True, axis="x", color="0.88", linewidth=0.6)
        for row in rows:
            axes.axhline(row + 0.5, color="0.92", linewidth=0.6)
    grid[0].set_yticks(list(rows), [settings(key) for key in keys])
    grid[0].set_ylim(len(keys) - 0.5, -0.5)
    handles, labels = grid[0].get_legend_handles_labels()
    fig.legend(handles, labels, loc="upper center", ncol=len(models), frameon=False)
    fig.tight_layout(rect=(0, 0, 1, 1 - 0.45 / fig.get_figheight()))
    figures.save(fig, out)


if __name__ == "__main__":
    main()
