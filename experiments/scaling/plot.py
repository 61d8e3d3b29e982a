#!/usr/bin/env python3
"""Figures of scaling: time and memory a body, and error of v', against the number of bodies.

plot.py CSV [--out-dir DIR] writes an SVG and a PDF named after the CSV.
"""
import collections
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import figures
import matplotlib.pyplot as plt

PANELS = [("total", "time", 1e6, True, "time a body, µs"), ("total", "memory", 1.0, True, "memory a body, bytes"),
          ("solve", "error_vdot", 1.0, False, "error of η̇, relative"),
          ("solve", "error_vdot_refined", 1.0, False, "error of η̇ after\none refinement step")]


def family(model):
    return re.sub(r"^([^:]+):\d+", r"\1", model)


def read(path):
    """{family: {formulation: {(phase, metric): {bodies: value}}}}"""
    data = collections.defaultdict(lambda: collections.defaultdict(lambda: collections.defaultdict(dict)))
    for row in figures.rows(path):
        if row["value"] and row["formulation"] and row["status"] != "objection":
            key = row["phase"], row["metric"]
            data[family(row["model"])][row["formulation"]][key][int(row["bodies"])] = float(row["value"])
    return data


def main():
    path, out = figures.begin(__doc__)
    data = read(path)
    if not data:
        return
    names = figures.order({n for curves in data.values() for n in curves})
    styles = figures.styles(names)
    fig, grid = plt.subplots(len(PANELS), len(data), figsize=(3.9 * len(data) + 0.8, 10.5), sharex=True, sharey="row",
                             squeeze=False)
    handles = {}
    for column, (kind, curves) in enumerate(sorted(data.items())):
        for line, (phase, metric, scale, a_body, label) in enumerate(PANELS):
            axes = grid[line][column]
            for name in names:
                series = {n: v for n, v in curves[name].get((phase, metric), {}).items() if v > 0}
                if not series:
                    continue
                colour, style, marker = styles[name]
                sizes = sorted(series)
                handles[name], = axes.plot(sizes, [scale * series[n] / (n if a_body else 1) for n in sizes],
                                           color=colour, linestyle=style, marker=marker, markersize=4.5,
                                           linewidth=1.8 if name == "recursive" else 1.2)
            axes.set_xscale("log")
            axes.set_yscale("log")
            axes.grid(True, which="major", color="0.88", linewidth=0.6)
            if column == 0:
                axes.set_ylabel(label)
            if line == 0:
                axes.set_title(f"{kind}, revolute joints" if ":" not in kind else kind, fontsize=10)
            if line == len(PANELS) - 1:
                axes.set_xlabel("bodies n")
    shown = [n for n in names if n in handles]
    fig.legend([handles[n] for n in shown], shown, loc="lower center", ncol=4, fontsize=8.5, frameon=False)
    fig.tight_layout(rect=(0, 0.055, 1, 1))
    figures.save(fig, out)


if __name__ == "__main__":
    main()
