#!/usr/bin/env python3
"""Figures of the crossover: operations and time a body against the number of bodies, and crossing points.

plot.py CSV [--out-dir DIR] writes crossover.svg/.pdf (revolute joints: operations and time of the three shapes),
crossover-joints.svg/.pdf (chains of spherical and free joints) and crossover-phases.svg/.pdf, named after the CSV.
"""
import argparse
import collections
import csv
import pathlib
import re
import statistics

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.ticker import FixedLocator, NullFormatter, ScalarFormatter

# Dark to light, each with a line style and a marker of its own, so that grey prints tell them apart.
STYLES = [("#000000", "-", "o"), ("#d55e00", "--", "s"), ("#0072b2", "-.", "^"), ("#009e73", ":", "D"),
          ("#cc79a7", (0, (5, 1)), "v"), ("#56b4e9", (0, (3, 1, 1, 1)), "P"), ("#e69f00", (0, (1, 1)), "X"),
          ("#7f7f7f", (0, (7, 2)), "*")]
PHASES = ["kinematics", "assemble", "factorise", "solve"]
TICKS = [1, 2, 4, 8, 16, 32, 64]


def family(model):
    return re.sub(r"^([^:]+):\d+", r"\1:N", model)


def read(path):
    """{family: {formulation: {(phase, metric): {bodies: [values]}}}}"""
    data = collections.defaultdict(
        lambda: collections.defaultdict(lambda: collections.defaultdict(lambda: collections.defaultdict(list))))
    with open(path, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if row["value"] and row["metric"] in ("flops", "time", "memory") and ":N" not in row["model"]:
                key = row["phase"], row["metric"]
                data[family(row["model"])][row["formulation"]][key][int(row["bodies"])].append(float(row["value"]))
    return data


def order(names):
    """The recursion first, so that it has the same style everywhere."""
    return sorted(names, key=lambda name: (name != "recursive", name))


def per_body(series, scale=1.0):
    sizes = sorted(series)
    return sizes, [scale * statistics.median(series[n]) / n for n in sizes]


def quartiles(series, scale):
    """Lower and upper quartile a body, where there are enough repetitions."""
    sizes = [n for n in sorted(series) if len(series[n]) > 2]
    cuts = [statistics.quantiles(series[n], n=4, method="inclusive") for n in sizes]
    return sizes, [scale * c[0] / n for c, n in zip(cuts, sizes)], [scale * c[2] / n for c, n in zip(cuts, sizes)]


def dress(axes, title, ylabel):
    axes.set_xscale("log", base=2)
    axes.set_yscale("log")
    axes.xaxis.set_major_locator(FixedLocator(TICKS))
    axes.xaxis.set_major_formatter(ScalarFormatter())
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_title(title, fontsize=10)
    axes.set_xlabel("bodies n")
    if ylabel:
        axes.set_ylabel(ylabel)
    axes.grid(True, which="major", color="0.88", linewidth=0.6)


def draw(axes, curves, styles, metric, scale):
    for name in order(n for n in curves if not n.startswith("published")):
        series = curves[name].get(("total", metric))
        if not series:
            continue
        colour, line, marker = styles[name]
        sizes, values = per_body(series, scale)
        every = [i for i, n in enumerate(sizes) if n in TICKS]
        axes.plot(sizes, values, color=colour, linestyle=line, marker=marker, markevery=every, markersize=4.5,
                  linewidth=1.8 if name == "recursive" else 1.2, label=name)
        if metric == "time":
            axes.fill_between(*quartiles(series, scale), color=colour, alpha=0.15, linewidth=0)


def draw_published(axes, curves):
    """Thin grey dashes, the recursions darker than the others; a number at the end refers to the legend."""
    names = sorted(n for n in curves if n.startswith("published"))
    lines = []
    for number, name in enumerate(names, 1):
        sizes, values = per_body(curves[name][("total", "flops")])
        # Numbers apart from each other, where two curves run close together, and inside the axes.
        low, high = axes.get_ylim()
        at = [n for n in TICKS[number % 5 + 1:] + TICKS if n in sizes and 1.2 * low < values[sizes.index(n)] < high / 1.3]
        shade = "0.25" if "recursion" in name else "0.55"
        lines += axes.plot(sizes, values, color=shade, linestyle=(0, (4, 3)), linewidth=0.9,
                           marker=f"${number}$", markevery=[sizes.index(n) for n in at[:1]], markersize=7,
                           label=f"{number}: " + name.replace("published: ", ""))
    return lines


TITLES = {"chain": "chain", "tree": "binary tree", "star": "star"}


def title(name):
    shape, _, rest = name.partition(":N")
    joint = rest.replace(":joint=", "") or "revolute"
    return f"{TITLES.get(shape, shape)}, {joint} joints"


def figure(data, families, styles, path):
    families = [f for f in families if f in data]
    if not families:
        return
    published = any(name.startswith("published") for f in families for name in data[f])
    fig, grid = plt.subplots(2, len(families), figsize=(3.7 * len(families) + 0.6, 7.4 if published else 6.6),
                             sharex=True, sharey="row", squeeze=False)
    ours = [value / n for name in families for curve, series in data[name].items() if not curve.startswith("published")
            for n, values in series.get(("total", "flops"), {}).items() for value in values]
    if ours:
        grid[0][0].set_ylim(min(ours) / 1.6, max(ours) * 2)
    handles = {}
    dashed = []
    for column, name in enumerate(families):
        draw(grid[0][column], data[name], styles, "flops", 1.0)
        dashed += draw_published(grid[0][column], data[name])
        draw(grid[1][column], data[name], styles, "time", 1e6)
        dress(grid[0][column], title(name), "operations a body (+ − × ÷ √)" if column == 0 else "")
        dress(grid[1][column], "", "time a body, µs" if column == 0 else "")
        grid[0][column].set_xlabel("")
        for axes in (grid[0][column], grid[1][column]):
            for handle, label in zip(*axes.get_legend_handles_labels()):
                if not re.match(r"\d+:", label):
                    handles.setdefault(label, handle)
    names = order(handles)
    bottom = 0.08
    if dashed:
        bottom = 0.17
        fig.legend(handles=dashed, loc="lower center", ncol=3, fontsize=7.5, frameon=False, bbox_to_anchor=(0.5, 0.0),
                   title="published operation counts, revolute chain (η̇ only)", title_fontsize=8)
    fig.legend([handles[n] for n in names], names, loc="lower center", ncol=min(4, len(names)), fontsize=8.5,
               frameon=False, bbox_to_anchor=(0.5, bottom - 0.055 if dashed else 0.0))
    fig.tight_layout(rect=(0, bottom, 1, 1))
    save(fig, path)


def phases(data, styles, path):
    """Share of the phases at one size, chain of revolute joints."""
    curves = data.get("chain:N") or next(iter(data.values()))
    names = [n for n in order(curves) if ("total", "time") in curves[n]]
    common = set.intersection(*(set(curves[n][("total", "time")]) for n in names)) if names else set()
    if not common:
        return
    size = max((n for n in common if n <= 32), default=max(common))
    fig, axes = plt.subplots(figsize=(6.6, 0.42 * len(names) + 1.7))
    hatches, greys = ["", "///", "...", "xxx"], ["0.35", "0.8", "0.6", "0.95"]
    left = [0.0] * len(names)
    for phase, hatch, grey in zip(PHASES, hatches, greys):
        widths = [max(0.0, 1e6 * statistics.median(curves[n].get((phase, "time"), {}).get(size, [0.0]))) for n in names]
        axes.barh(names, widths, left=left, label=phase, color=grey, hatch=hatch, edgecolor="black", linewidth=0.5)
        left = [a + b for a, b in zip(left, widths)]
    axes.invert_yaxis()
    axes.set_xlabel(f"time of one solution, µs (n = {size}; median)")
    axes.legend(frameon=False, fontsize=8, ncol=4, loc="lower center", bbox_to_anchor=(0.45, 1.0))
    axes.spines[["top", "right"]].set_visible(False)
    fig.tight_layout()
    save(fig, path)


def save(fig, path):
    for suffix in (".svg", ".pdf"):
        fig.savefig(path.with_name(path.name + suffix))
    plt.close(fig)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("csv", type=pathlib.Path)
    parser.add_argument("--out-dir", type=pathlib.Path, help="default: beside the CSV")
    arguments = parser.parse_args()
    out = (arguments.out_dir or arguments.csv.parent) / arguments.csv.stem
    out.parent.mkdir(parents=True, exist_ok=True)
    plt.rcParams.update({"font.size": 9, "svg.hashsalt": "lanc", "pdf.fonttype": 42})

    data = read(arguments.csv)
    names = order({n for curves in data.values() for n in curves if not n.startswith("published")})
    styles = {n: STYLES[i % len(STYLES)] for i, n in enumerate(names)}
    figure(data, ["chain:N", "tree:N", "star:N"], styles, out)
    figure(data, [f for f in sorted(data) if "joint=" in f and f.startswith("chain")], styles,
           out.with_name(out.name + "-joints"))
    others = [f for f in sorted(data) if "joint=" in f and not f.startswith("chain")]
    figure(data, others, styles, out.with_name(out.name + "-shapes"))
    if data:
        phases(data, styles, out.with_name(out.name + "-phases"))


if __name__ == "__main__":
    main()
