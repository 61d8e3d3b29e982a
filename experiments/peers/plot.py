#!/usr/bin/env python3
"""Figure of peers: time a body of every side on every model, and error against the closed form beside it.

plot.py CSV [--out-dir DIR] writes an SVG and a PDF named after the CSV.
"""
import collections
import pathlib
import statistics
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import figures
import matplotlib.pyplot as plt

TASKS = {"task=forward": "forward dynamics", "task=inverse": "inverse dynamics"}


def read(path):
    """Times {group: {side: {model: µs a body}}}, errors {side: {model: relative}}; groups: tasks, closed loops apart."""
    times = collections.defaultdict(lambda: collections.defaultdict(lambda: collections.defaultdict(list)))
    errors = collections.defaultdict(dict)
    for row in figures.rows(path):
        if not row["value"] or row["phase"] != "total":
            continue
        group = "closed loops" if int(row["closure_rows"]) else TASKS[row["parameters"]]
        if row["metric"] == "time":
            time = 1e6 * float(row["value"]) / int(row["bodies"])
            times[group][row["formulation"]][row["model"]].append(time)
        elif row["metric"] == "error":
            errors[row["formulation"]][row["model"]] = max(float(row["value"]), 1e-17)
    medians = {group: {side: {model: statistics.median(v) for model, v in models.items()}
                       for side, models in sides.items()} for group, sides in times.items()}
    return medians, errors


def draw(axes, data, label, styles, handles):
    models = list(dict.fromkeys(model for values in data.values() for model in values))
    for side in figures.order(data):
        colour, _, marker = styles[side]
        places = [models.index(model) for model in data[side]]
        handles[side], = axes.plot(places, list(data[side].values()), color=colour, marker=marker, markersize=6,
                                   linestyle="")
    axes.set_yscale("log")
    axes.set_xticks(range(len(models)), models, rotation=60, ha="right", fontsize=7.5)
    axes.set_ylabel(label)
    axes.grid(True, axis="y", which="major", color="0.88", linewidth=0.6)


def main():
    path, out = figures.begin(__doc__)
    times, errors = read(path)
    panels = [(times[group], f"{group},\nµs a body") for group in (*TASKS.values(), "closed loops") if group in times]
    if errors:
        panels.append((errors, "error against the closed form,\nrelative"))
    if not panels:
        return
    styles = figures.styles({side for data, _ in panels for side in data})
    fig, grid = plt.subplots(1, len(panels), figsize=(4.0 * len(panels), 4.8), squeeze=False)
    handles = {}
    for axes, (data, label) in zip(grid[0], panels):
        draw(axes, data, label, styles, handles)
    shown = figures.order(handles)
    fig.legend([handles[side] for side in shown], shown, loc="lower center", ncol=6, fontsize=8.5, frameon=False)
    fig.tight_layout(rect=(0, 0.1, 1, 1))
    figures.save(fig, out)


if __name__ == "__main__":
    main()
