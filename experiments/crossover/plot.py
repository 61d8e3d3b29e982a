#!/usr/bin/env python3
"""Figures of the crossover: operations and time a body against the number of bodies, and crossing points.

plot.py CSV [--out-dir DIR] writes crossover.svg/.pdf (revolute joints: operations and time of the three shapes),
crossover-joints and -shapes (spherical and free joints), crossover-published (beside counts of the literature) and
crossover-phases (where the time goes), named after the CSV.
"""
import collections
import pathlib
import re
import statistics
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import figures
import matplotlib.lines
import matplotlib.pyplot as plt
from matplotlib.ticker import FixedLocator, NullFormatter, ScalarFormatter

PHASES = ["kinematics", "assemble", "factorise", "solve"]
TICKS = [1, 2, 4, 8, 16, 32, 64]


def family(model):
    return re.sub(r"^([^:]+):\d+", r"\1:N", model)


def read(path):
    """{family: {formulation: {(phase, metric): {bodies: [values]}}}}"""
    data = collections.defaultdict(
        lambda: collections.defaultdict(lambda: collections.defaultdict(lambda: collections.defaultdict(list))))
    for row in figures.rows(path):
        if row["value"] and row["metric"] in ("flops", "time", "memory") and ":N" not in row["model"]:
            key = row["phase"], row["metric"]
            data[family(row["model"])][row["formulation"]][key][int(row["bodies"])].append(float(row["value"]))
    return data


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
    for name in figures.order(n for n in curves if not n.startswith("published")):
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
    """Thin dashes, the recursions darker than the others."""
    for name in sorted(n for n in curves if n.startswith("published")):
        sizes, values = per_body(curves[name][("total", "flops")])
        axes.plot(sizes, values, color="0.25" if "recursion" in name else "0.6", linestyle=(0, (4, 3)), linewidth=0.9,
                  zorder=1.5)


def published(data, styles, path):
    """Counts of revolute chains beside those of the literature, each with its name at the end of its line."""
    curves = data.get("chain:N", {})
    names = sorted(n for n in curves if n.startswith("published"))
    ours = [n for n in figures.order(curves) if n not in names and ("total", "flops") in curves[n]]
    if not names or not ours:
        return
    fig, axes = plt.subplots(figsize=(7.6, 5.2))
    draw(axes, {n: curves[n] for n in ours}, styles, "flops", 1.0)
    handles, labels = axes.get_legend_handles_labels()
    draw_published(axes, curves)
    ends = []
    for name in names:
        sizes, values = per_body(curves[name][("total", "flops")])
        ends.append((values[-1], sizes[-1], name.replace("published: ", "").replace("JtMJ", "JᵀMJ").replace("^2", "²")
                     .replace("^3", "³")))
    dress(axes, "operations of forward dynamics, chain of revolute joints", "operations a body")
    last = 0.0
    for value, size, text in sorted(ends):
        last = max(value, 1.32 * last)  # labels keep apart
        axes.annotate(text, (size, value), (1.2 * size, last), fontsize=8, va="center", annotation_clip=False,
                      arrowprops={"arrowstyle": "-", "linewidth": 0.4, "color": "0.6", "shrinkA": 0, "shrinkB": 2})
    axes.set_xlim(0.9, 70)
    axes.set_ylim(bottom=0.5 * min(v for n in ours for v in per_body(curves[n][("total", "flops")])[1]))
    axes.legend(handles, labels, fontsize=8, frameon=False, loc="upper left",
                title="counted here (η̇, all â, all f̂)\npublished (dashed): η̇ only", title_fontsize=8)
    fig.tight_layout()
    figures.save(fig, path)


TITLES = {"chain": "chain", "tree": "binary tree", "star": "star"}


def title(name):
    shape, _, rest = name.partition(":N")
    joint = rest.replace(":joint=", "") or "revolute"
    return f"{TITLES.get(shape, shape)}, {joint} joints"


def figure(data, families, styles, path):
    families = [f for f in families if f in data]
    if not families:
        return
    fig, grid = plt.subplots(2, len(families), figsize=(3.7 * len(families) + 0.6, 6.8), sharex=True, sharey="row",
                             squeeze=False)
    ours = [value / n for name in families for curve, series in data[name].items() if not curve.startswith("published")
            for n, values in series.get(("total", "flops"), {}).items() for value in values]
    if ours:
        grid[0][0].set_ylim(min(ours) / 1.6, max(ours) * 2)
    handles = {}
    for column, name in enumerate(families):
        draw(grid[0][column], data[name], styles, "flops", 1.0)
        draw_published(grid[0][column], data[name])
        draw(grid[1][column], data[name], styles, "time", 1e6)
        dress(grid[0][column], title(name), "operations a body (+ − × ÷ √)" if column == 0 else "")
        dress(grid[1][column], "", "time a body, µs" if column == 0 else "")
        grid[0][column].set_xlabel("")
        for axes in (grid[0][column], grid[1][column]):
            for handle, label in zip(*axes.get_legend_handles_labels()):
                handles.setdefault(label, handle)
    names = figures.order(handles)
    shown = [handles[n] for n in names]
    if any(n.startswith("published") for f in families for n in data[f]):
        shown.append(matplotlib.lines.Line2D([], [], color="0.4", linestyle=(0, (4, 3)), linewidth=0.9))
        names.append("published counts, η̇ only")
    fig.legend(shown, names, loc="lower center", ncol=5, fontsize=8.5, frameon=False)
    fig.tight_layout(rect=(0, 0.075, 1, 1))
    figures.save(fig, path)


def phases(data, styles, path):
    """Share of the phases at one size, chain of revolute joints."""
    curves = data.get("chain:N") or next(iter(data.values()))
    names = [n for n in figures.order(curves) if ("total", "time") in curves[n]]
    common = set.intersection(*(set(curves[n][("total", "time")]) for n in names)) if names else set()
    if not common:
        return
    size = max((n for n in common if n <= 32), default=max(common))
    fig, axes = plt.subplots(figsize=(6.6, 0.42 * len(names) + 1.7))
    hatches, greys = ["", "///", "...", "xxx"], ["0.35", "0.8", "0.6", "0.95"]
    micro = {n: [max(0.0, 1e6 * statistics.median(curves[n].get((phase, "time"), {}).get(size, [0.0])))
                 for phase in PHASES] for n in names}
    left = [0.0] * len(names)
    for index, (phase, hatch, grey) in enumerate(zip(PHASES, hatches, greys)):
        widths = [100 * micro[n][index] / (sum(micro[n]) or 1.0) for n in names]
        axes.barh(names, widths, left=left, label=phase, color=grey, hatch=hatch, edgecolor="black", linewidth=0.5)
        left = [a + b for a, b in zip(left, widths)]
    for row, name in enumerate(names):
        total = 1e6 * statistics.median(curves[name][("total", "time")][size])
        axes.annotate(f"{total:.3g} µs", (101, row), va="center", fontsize=8, annotation_clip=False)
    axes.invert_yaxis()
    axes.set_xlim(0, 100)
    axes.set_xlabel(f"share of the time of one solution, % (n = {size}, medians; right: total)")
    axes.legend(frameon=False, fontsize=8, ncol=4, loc="lower center", bbox_to_anchor=(0.45, 1.0))
    axes.spines[["top", "right"]].set_visible(False)
    fig.tight_layout()
    figures.save(fig, path)


def merged(data):
    """Formulations that count the same everywhere become one curve, the first of them with how many more there are."""
    def signature(name):
        return tuple((family, size, tuple(values)) for family in sorted(data)
                     for size, values in sorted(data[family].get(name, {}).get(("total", "flops"), {}).items()))

    groups = collections.defaultdict(list)
    for name in figures.order({n for curves in data.values() for n in curves}):
        groups[signature(name) or name].append(name)
    for first, *others in groups.values():
        for curves in data.values() if others else ():
            if first in curves:
                curves[f"{first} +{len(others)}"] = curves.pop(first)
            for name in others:
                curves.pop(name, None)
    return data


def main():
    path, out = figures.begin(__doc__)
    data = merged(read(path))
    styles = figures.styles({n for curves in data.values() for n in curves if not n.startswith("published")})
    figure(data, ["chain:N", "tree:N", "star:N"], styles, out)
    figure(data, [f for f in sorted(data) if "joint=" in f and f.startswith("chain")], styles,
           out.with_name(out.name + "-joints"))
    others = [f for f in sorted(data) if "joint=" in f and not f.startswith("chain")]
    figure(data, others, styles, out.with_name(out.name + "-shapes"))
    published(data, styles, out.with_name(out.name + "-published"))
    if data:
        phases(data, styles, out.with_name(out.name + "-phases"))


if __name__ == "__main__":
    main()
