#!/usr/bin/env python3
"""Figure of singularity-explicit: the admissible positions and the condition of each choice along them.

plot.py CSV [--out-dir DIR] writes an SVG and a PDF named after the CSV.
"""
import collections
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import figures
import matplotlib.lines
import matplotlib.pyplot as plt

GREEK = {"beta1": "β₁", "beta2": "β₂", "beta3": "β₃"}
# Dark and light, each with a line style of its own, so that grey prints tell them apart.
STYLES = {"beta1": dict(color="#000000", linestyle="-"), "beta2": dict(color="#0072b2", linestyle=":"),
          "beta3": dict(color="#e69f00", linestyle=(0, (4, 1.5)))}
MARKERS = "osD^vP"
BELOW = dict(fontsize=8, frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.15), columnspacing=1.5)
HIGHEST = 1e3  # condition drawn: at a limit point it has no end


def read(path):
    """[(parameters, {metric: value})] by cell, in order."""
    cells = collections.OrderedDict()
    for row in figures.rows(path):
        if row["value"]:
            cells.setdefault(row["parameters"], {})[row["metric"]] = float(row["value"])
    return [(dict(p.split("=", 1) for p in text.split(";")), values) for text, values in cells.items()]


def angles(values):
    return math.degrees(values["beta1"]), math.degrees(values["beta3"])


def split_turns(points):
    """Angles brought to ±180°, with gaps where a line would jump across the picture."""
    xs, ys, last = [], [], None
    for point in points:
        x, y = ((a + 180) % 360 - 180 for a in point)
        if last and max(abs(x - last[0]), abs(y - last[1])) > 180:
            xs.append(math.nan)
            ys.append(math.nan)
        xs.append(x)
        ys.append(y)
        last = x, y
    return xs, ys


def draw_positions(axes, curve, extremes, walk, changes):
    axes.plot(*split_turns([angles(v) for v in curve]), color="0.8", linewidth=5, solid_capstyle="round", zorder=1)
    # sections of the walk, each up to the first point of the next one
    sections = []
    for parameters, values in walk:
        if sections:
            sections[-1][1].append(angles(values))
        if not sections or sections[-1][0] != parameters["independent"]:
            sections.append((parameters["independent"], [angles(values)]))
    for name, points in sections:
        axes.plot(*split_turns(points), linewidth=1.8, zorder=3, **STYLES[name])
    axes.plot(*split_turns_apart([angles(v) for _, v in changes]), linestyle="none", marker="x", color="black",
              markersize=6, zorder=4)
    place_labels(axes, curve, extremes)
    used = sorted({name for name, _ in sections})
    handles = [matplotlib.lines.Line2D([], [], linewidth=1.8, **STYLES[n]) for n in used]
    labels = [f"stepped in {GREEK[n]}" for n in used]
    if changes:
        handles.append(matplotlib.lines.Line2D([], [], linestyle="none", marker="x", color="black", markersize=6))
        labels.append("change")
    handles.append(matplotlib.lines.Line2D([], [], color="0.8", linewidth=5))
    labels.append("admissible positions")
    axes.legend(handles, labels, **BELOW, ncol=2)
    axes.set_xlabel("β₁ (crank), degrees")
    axes.set_ylabel("β₃ (rocker), degrees")
    axes.set_title("Positions", fontsize=10)


def split_turns_apart(points):
    return [(a + 180) % 360 - 180 for a, _ in points], [(b + 180) % 360 - 180 for _, b in points]


def place_labels(axes, curve, extremes):
    xs, ys = split_turns_apart([angles(v) for v in curve])
    middle = (min(xs) + max(xs)) / 2, (min(ys) + max(ys)) / 2
    for k, (parameters, values) in enumerate(extremes):
        x, y = (a[0] for a in split_turns_apart([angles(values)]))
        axes.plot([x], [y], marker=MARKERS[k % len(MARKERS)], color="white", markeredgecolor="black", markersize=7,
                  zorder=5)
        fails = parameters["extreme"]
        # β₁ is extreme at the left or the right, labelled inside; β₃ at the top or the bottom, labelled outside
        if fails == "beta1":
            right = x > middle[0]
            shift, align = (-9 if right else 9, 0), ("right" if right else "left", "center")
        else:
            top = y > middle[1]
            shift, align = (0, 10 if top else -10), ("center", "bottom" if top else "top")
        axes.annotate(f"{x:.2f}°, {y:.2f}°".replace("-", "−"), (x, y), shift, textcoords="offset points", ha=align[0],
                      va=align[1], fontsize=8)
    axes.margins(0.12, 0.14)


def draw_conditions(axes, curve_cells, conditions, extremes, changes):
    arcs = {parameters["point"]: values["arc"] for parameters, values in curve_cells}
    handles = []
    for name in sorted({p["independent"] for p, _ in conditions}):
        series = sorted((v["arc"] if "arc" in v else arcs[p["point"]], v["condition"]) for p, v in conditions
                        if p["independent"] == name)
        line, = axes.plot([a for a, _ in series], [c for _, c in series], linewidth=1.6, label=f"q = {GREEK[name]}",
                          **STYLES[name])
        handles.append(line)
    places = [(v["arc"], v["beta1"], v["beta3"]) for _, v in curve_cells]
    for _, values in changes:
        arc = min(places, key=lambda p: math.hypot(p[1] - values["beta1"], p[2] - values["beta3"]))[0]
        axes.annotate("", (arc, values["condition_after"]), (arc, values["condition_before"]),
                      arrowprops=dict(arrowstyle="->", color="0.25", linewidth=1.1), zorder=5)
    axes.set_yscale("log")
    for k, (_, values) in enumerate(extremes):
        axes.axvline(values["arc"], color="0.8", linewidth=0.8, zorder=0)
        axes.plot([values["arc"]], [1], marker=MARKERS[k % len(MARKERS)], color="white", markeredgecolor="black",
                  markersize=7, zorder=5, clip_on=False)
    axes.set_ylim(1, HIGHEST)
    axes.set_xlim(0, max(arcs.values()))
    axes.grid(True, axis="y", which="major", color="0.88", linewidth=0.6)
    axes.set_xlabel("arc length, rad")
    axes.set_ylabel("condition of Gᵈ")
    if changes:
        handles.append(matplotlib.lines.Line2D([], [], linestyle="none", marker="$\\downarrow$", color="0.25",
                                               markersize=8, label="change"))
    axes.legend(handles=handles, **BELOW, ncol=2)
    axes.set_title("Condition of the explicit closure conditions", fontsize=10)


def main():
    path, out = figures.begin(__doc__)

    cells = read(path)
    curve = [(p, v) for p, v in cells if "curve" in p and "independent" not in p]
    conditions = [(p, v) for p, v in cells if "walk" not in p and "independent" in p]
    extremes = [(p, v) for p, v in cells if "extreme" in p and "independent" not in p]
    walk = [(p, v) for p, v in cells if p.get("walk") == "beta1+beta3" and "point" in p]
    changes = [(p, v) for p, v in cells if p.get("walk") == "beta1+beta3" and "change" in p]
    if not curve:
        return
    fig, (left, right) = plt.subplots(1, 2, figsize=(8.6, 4.1), gridspec_kw={"width_ratios": [1, 1.15]})
    draw_positions(left, [v for _, v in curve], extremes, walk, changes)
    draw_conditions(right, curve, conditions, extremes, changes)
    fig.tight_layout()
    figures.save(fig, out)


if __name__ == "__main__":
    main()
