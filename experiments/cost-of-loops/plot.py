#!/usr/bin/env python3
"""Figure of cost-of-loops: time and operations against the number of loops.

plot.py CSV [--out-dir DIR] writes an SVG and a PDF named after the CSV.
"""
import collections
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import figures
import matplotlib.pyplot as plt

PANELS = [("time", 1e6, "time of one evaluation without\nthe decision on the rank, µs"), ("flops", 1.0, "operations")]
RANK = "rank decision, the same for all"


def read(path):
    """{kind of model: {(metric, formulation): {size: value}}}; times without the decision on the rank."""
    values = collections.defaultdict(dict)  # by model, formulation and metric: phases
    for row in figures.rows(path):
        if row["value"] and row["metric"] in ("time", "flops"):
            values[row["model"], row["formulation"], row["metric"]][row["phase"]] = float(row["value"])
    data = collections.defaultdict(lambda: collections.defaultdict(dict))
    for (model, formulation, metric), phases in values.items():
        size = re.match(r"^([^:]+):(\d+)(.*)$", model)
        if not size or "total" not in phases:
            continue
        curves, number = data[size[1] + size[3]], int(size[2])
        rank = phases.pop("rank", 0.0) if metric == "time" else 0.0
        total = phases.pop("total")  # the sum of the others, but for the scatter of medians
        curves[metric, formulation][number] = sum(phases.values()) if metric == "time" else total
        if rank:
            fastest = curves[metric, RANK].get(number, rank)
            curves[metric, RANK][number] = min(rank, fastest)
    return data


def main():
    path, out = figures.begin(__doc__)
    data = read(path)
    if not data:
        return
    names = figures.order({name for curves in data.values() for _, name in curves} - {RANK})
    styles = figures.styles(names)
    fig, grid = plt.subplots(len(PANELS), len(data), figsize=(2.6 * len(data) + 0.8, 6.6), sharex="col", sharey="row",
                             squeeze=False)
    handles = {}
    for column, (kind, curves) in enumerate(data.items()):
        for line, (metric, scale, label) in enumerate(PANELS):
            axes = grid[line][column]
            for name in names + [RANK]:
                series = sorted(curves.get((metric, name), {}).items())
                if series:
                    colour, style, marker = styles.get(name, ("0.75", "-", ""))
                    handles[name] = axes.plot([n for n, _ in series], [v * scale for _, v in series], color=colour,
                                              linestyle=style, marker=marker, markersize=3.5,
                                              linewidth=4 if name == RANK else 1.1, zorder=1 if name == RANK else 2)[0]
            axes.set_xscale("log")
            axes.set_yscale("log")
            axes.grid(True, which="major", color="0.88", linewidth=0.6)
            if column == 0:
                axes.set_ylabel(label)
        grid[0][column].set_title(kind, fontsize=9)
        grid[-1][column].set_xlabel("rods in one loop" if kind.startswith("polygon") else "loops")
    shown = [name for name in names + [RANK] if name in handles]
    fig.legend([handles[n] for n in shown], shown, loc="lower center", ncols=5, fontsize=8, frameon=False)
    fig.tight_layout(rect=(0, 0.1, 1, 1))
    figures.save(fig, out)


if __name__ == "__main__":
    main()
