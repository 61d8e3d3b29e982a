#!/usr/bin/env python3
"""Figure of cost-of-loops: time and operations against the number of loops.

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
PANELS = [("time", 1e6, "time of one evaluation, µs"), ("flops", 1.0, "operations")]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("csv", type=pathlib.Path)
    parser.add_argument("--out-dir", type=pathlib.Path, help="default: beside the CSV")
    arguments = parser.parse_args()
    out = (arguments.out_dir or arguments.csv.parent) / arguments.csv.stem
    out.parent.mkdir(parents=True, exist_ok=True)
    plt.rcParams.update({"font.size": 9, "svg.hashsalt": "lanc", "pdf.fonttype": 42})

    data = collections.defaultdict(lambda: collections.defaultdict(dict))
    with open(arguments.csv, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            size = re.match(r"^([^:]+):(\d+)(.*)$", row["model"])
            if size and row["phase"] == "total" and row["value"]:
                key = row["metric"], row["formulation"]
                data[size[1] + size[3]][key][int(size[2])] = float(row["value"])
    if not data:
        return
    names = sorted({name for curves in data.values() for _, name in curves})
    styles = {name: STYLES[i % len(STYLES)] for i, name in enumerate(names)}
    fig, grid = plt.subplots(len(PANELS), len(data), figsize=(3.2 * len(data) + 0.8, 6.4), sharex="col", sharey="row",
                             squeeze=False)
    handles = {}
    for column, (kind, curves) in enumerate(data.items()):
        for line, (metric, scale, label) in enumerate(PANELS):
            axes = grid[line][column]
            for name in names:
                series = sorted(curves.get((metric, name), {}).items())
                if series:
                    colour, style, marker = styles[name]
                    handles[name] = axes.plot([n for n, _ in series], [v * scale for _, v in series], color=colour,
                                              linestyle=style, marker=marker, markersize=3.5, linewidth=1.1,
                                              label=name)[0]
            axes.set_xscale("log")
            axes.set_yscale("log")
            axes.grid(alpha=0.3, which="both", linewidth=0.4)
            if column == 0:
                axes.set_ylabel(label)
        grid[0][column].set_title(kind, fontsize=9)
        grid[-1][column].set_xlabel("loops")
    fig.legend(handles.values(), handles.keys(), loc="upper center", ncols=min(7, len(handles)), fontsize=8, frameon=False)
    fig.tight_layout(rect=(0, 0, 1, 0.9))
    for suffix in ("svg", "pdf"):
        fig.savefig(f"{out}.{suffix}", metadata={"Date": None} if suffix == "svg" else {"CreationDate": None})


if __name__ == "__main__":
    main()
