#!/usr/bin/env python3
"""Figures of singularity-implicit: the branches of the parallelogram, and the singular values of G along them.

plot.py CSV [--out-dir DIR] writes an SVG and a PDF named after the CSV, and …-rhombus beside them.
"""
import collections
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import figures
import matplotlib.lines
import matplotlib.pyplot as plt
from matplotlib.ticker import MultipleLocator

# Dark and light, each with a line style of its own, so that grey prints tell them apart.
STYLES = {"parallel": dict(color="#000000", linestyle="-"),
          "antiparallel": dict(color="#d55e00", linestyle=(0, (5, 1.5))),
          "beta1-fixed": dict(color="#d55e00", linestyle=(0, (5, 1.5))),
          "beta3-fixed": dict(color="#0072b2", linestyle="-.")}
LABELS = {"beta1-fixed": "β₁ = 90°", "beta3-fixed": "β₃ = 0°"}
MARKERS = "osD"
LOWEST = 1e-3  # singular value drawn: at a crossing it is 0
BELOW = dict(fontsize=8, frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.15), columnspacing=1.5)


def read(path):
    """{model: [(parameters, {metric: value})]} by cell, in order."""
    cells = collections.OrderedDict()
    for row in figures.rows(path):
        if row["value"]:
            cells.setdefault((row["model"], row["parameters"]), {})[row["metric"]] = float(row["value"])
    models = collections.OrderedDict()
    for (model, text), values in cells.items():
        models.setdefault(model, []).append((dict(p.split("=", 1) for p in text.split(";")), values))
    return models


def wrapped(value, lowest):
    """In degrees, between lowest and lowest + 360; what rounding puts just below lowest stays there."""
    return (math.degrees(value) - lowest + 1e-6) % 360 + lowest - 1e-6


def place(values):
    return wrapped(values["beta1"], -180), wrapped(values["beta3"], -90)


def broken(points):
    """Two lists for a line, with gaps where it would jump across the picture."""
    xs, ys, last = [], [], None
    for x, y in points:
        if last and max(abs(x - last[0]), abs(y - last[1])) > 180:
            xs.append(math.nan)
            ys.append(math.nan)
        xs.append(x)
        ys.append(y)
        last = x, y
    return xs, ys


def branches(cells):
    """{branch: [values]}"""
    found = collections.OrderedDict()
    for parameters, values in cells:
        if "branch" in parameters and "point" in parameters:
            found.setdefault(parameters["branch"], []).append(values)
    return found


def crossings(cells):
    return [(int(p["crossing"]), v) for p, v in cells if "crossing" in p and "verdict" in p]


def draw_positions(axes, cells):
    handles = []
    for name, points in branches(cells).items():
        line, = axes.plot(*broken([place(v) for v in points]), linewidth=1.8, label=LABELS.get(name, f"{name} branch"),
                          **STYLES[name])
        handles.append(line)
    for number, values in crossings(cells):
        x, y = place(values)
        axes.plot([x], [y], marker=MARKERS[number - 1], color="white", markeredgecolor="black", markersize=7, zorder=5)
        above = x < 0  # where there is room between the branches
        axes.annotate(f"{round(x)}°, {round(y)}°".replace("-", "−"), (x, y), (16, 3) if above else (9, -9),
                      textcoords="offset points", ha="left", va="bottom" if above else "top", fontsize=8)
    handles.append(matplotlib.lines.Line2D([], [], linestyle="none", marker="o", color="white", markeredgecolor="black",
                                           markersize=7, label="crossing, rank 1"))
    axes.set_xlim(-180, 180)
    axes.set_ylim(-90, 270)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MultipleLocator(90))
    axes.grid(True, color="0.9", linewidth=0.6)
    axes.set_xlabel("β₁ (crank), degrees")
    axes.set_ylabel("β₃ (rocker), degrees")
    axes.set_title("Positions", fontsize=10)
    axes.legend(handles=handles, **BELOW, ncol=len(handles) if len(handles) < 4 else 2)


def draw_singular_values(axes, cells):
    for name, points in branches(cells).items():
        style = STYLES[name]
        label = LABELS.get(name, name)
        axes.plot([v["arc"] for v in points], [v["sigma1"] for v in points], linewidth=0.9, label=f"σ₁, {label}",
                  **style)
        on_branch = [(int(p["crossing"]), v) for p, v in cells if "crossing" in p and p.get("branch") == name]
        series = sorted([(v["arc"], v["sigma2"]) for v in points] + [(v["arc"], 1e-16) for _, v in on_branch])
        axes.plot([a for a, _ in series], [s for _, s in series], linewidth=1.8, label=f"σ₂, {label}", **style)
        for number, values in on_branch:
            axes.plot([values["arc"]], [LOWEST], marker=MARKERS[number - 1], color="white", zorder=5, clip_on=False,
                      markeredgecolor=style["color"], markersize=7)
    axes.set_yscale("log")
    axes.set_ylim(LOWEST, 10)
    axes.set_xlim(0, max(v["arc"] for points in branches(cells).values() for v in points))
    axes.grid(True, axis="y", which="major", color="0.88", linewidth=0.6)
    axes.set_xlabel("arc length, rad")
    axes.set_ylabel("singular values of the scaled G")
    axes.set_title("Rank of the implicit closure conditions", fontsize=10)
    axes.legend(**BELOW, ncol=2)


def draw(cells, out):
    fig, (left, right) = plt.subplots(1, 2, figsize=(8.6, 4.3), gridspec_kw={"width_ratios": [1, 1.15]})
    draw_positions(left, cells)
    draw_singular_values(right, cells)
    fig.tight_layout()
    figures.save(fig, out)


def main():
    path, out = figures.begin(__doc__)

    for model, cells in read(path).items():
        if not model.endswith("point-cut") or not branches(cells):
            continue  # the hinge is the same curve
        draw(cells, out.with_name(out.name + "-rhombus") if "beta1-fixed" in branches(cells) else out)


if __name__ == "__main__":
    main()
