#!/usr/bin/env python3
"""Figure of derivatives: time against the number of bodies of a chain, and as a multiple of forward dynamics.

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

WAYS = {"none": "forward dynamics", "analytic": "with derivatives, recursion", "dual": "with derivatives, dual numbers"}


def read(path):
    """{(formulation, way): {bodies: median time}} of chains"""
    times = collections.defaultdict(lambda: collections.defaultdict(list))
    for row in figures.rows(path):
        if re.fullmatch(r"chain:\d+", row["model"]) and row["metric"] == "time" and row["value"]:
            way = row["parameters"].partition("=")[2]
            times[row["formulation"], way][int(row["bodies"])].append(float(row["value"]))
    return {key: {n: statistics.median(v) for n, v in sorted(curve.items())} for key, curve in times.items()}


def main():
    path, out = figures.begin(__doc__)
    data = read(path)
    if not data:
        return
    fig, (left, right) = plt.subplots(1, 2, figsize=(8.6, 3.6))
    names = figures.order({formulation for formulation, _ in data})
    styles = figures.styles([f"{name} {way}" for name in names for way in WAYS])
    for name in names:
        forward = data.get((name, "none"), {})
        for way, text in WAYS.items():
            curve = data.get((name, way), {})
            colour, line, marker = styles[f"{name} {way}"]
            label = text if len(names) == 1 else f"{name}: {text}"
            style = {"color": colour, "linestyle": line, "marker": marker, "markersize": 3.5, "label": label}
            left.plot(list(curve), [1e6 * t for t in curve.values()], **style)
            if way != "none":
                both = [n for n in curve if n in forward]
                right.plot(both, [curve[n] / forward[n] for n in both], **style)
    left.set_ylabel("time, µs")
    right.set_ylabel("multiple of forward dynamics")
    for axes in (left, right):
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xlabel("bodies of a chain")
        axes.grid(True, which="major", color="0.88", linewidth=0.6)
    left.legend(frameon=False, fontsize=8)
    fig.tight_layout()
    figures.save(fig, out)


if __name__ == "__main__":
    main()
