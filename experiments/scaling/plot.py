#!/usr/bin/env python3
"""Figures of scaling: time and memory a body, and error of v', against the number of bodies.

plot.py CSV [--out-dir DIR] writes an SVG and a PDF named after the CSV.
"""
import argparse
import collections
import csv
import pathlib
import re

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

STYLES = [("#000000", "-", "o"), ("#d55e00", "--", "s"), ("#0072b2", "-.", "^"), ("#009e73", ":", "D"),
          ("#cc79a7", (0, (5, 1)), "v"), ("#56b4e9", (0, (3, 1, 1, 1)), "P"), ("#e69f00", (0, (1, 1)), "X"),
          ("#7f7f7f", (0, (7, 2)), "*")]
PANELS = [("total", "time", 1e6, True, "time a body, µs"), ("total", "memory", 1.0, True, "memory a body, bytes"),
          ("solve", "error_vdot", 1.0, False, "error of η̇, relative"),
          ("solve", "error_vdot_refined", 1.0, False, "error of η̇ after\none refinement step")]


def family(model):
    return re.sub(r"^([^:]+):\d+", r"\1", model)


def read(path):
    """{family: {formulation: {(phase, metric): {bodies: value}}}}"""
    data = collections.defaultdict(lambda: collections.defaultdict(lambda: collections.defaultdict(dict)))
    with open(path, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if row["value"] and row["status"] != "objection":
                key = row["phase"], row["metric"]
                data[family(row["model"])][row["formulation"]][key][int(row["bodies"])] = float(row["value"])
    return data


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("csv", type=pathlib.Path)
    parser.add_argument("--out-dir", type=pathlib.Path, help="default: beside the CSV")
    arguments = parser.parse_args()
    out = (arguments.out_dir or arguments.csv.parent) / arguments.csv.stem
    out.parent.mkdir(parents=True, exist_ok=True)
    plt.rcParams.update({"font.size": 9, "svg.hashsalt": "lanc", "pdf.fonttype": 42})

    data = read(arguments.csv)
    if not data:
        return
    names = sorted({n for curves in data.values() for n in curves}, key=lambda n: (n != "recursive", n))
    styles = {n: STYLES[i % len(STYLES)] for i, n in enumerate(names)}
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
    for suffix in (".svg", ".pdf"):
        fig.savefig(out.with_name(out.name + suffix))


if __name__ == "__main__":
    main()
