#!/usr/bin/env python3
"""Figure and table of reference-problems: error in tolerances and time, problems by formulations.

plot.py CSV [--out-dir DIR] writes an SVG and a PDF named after the CSV, and the same as a Markdown table.
"""
import collections
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import figures
import matplotlib.colors
import matplotlib.pyplot as plt

STANDARD = ("erk8", "minimal", "none")


def read(path):
    """{problem: {way: {metric: value, "status": …}}}: formulations, or what differs beside them."""
    data = collections.defaultdict(lambda: collections.defaultdict(dict))
    for row in figures.rows(path):
        if not row["formulation"]:
            continue
        keys = dict(part.split("=", 1) for part in row["parameters"].split(";"))
        standard = keys["integrator"] == STANDARD[0] and keys["stabilisation"] in STANDARD[1:]
        way = row["formulation"] if standard else f"{row['formulation']}, {keys['integrator']}, {keys['stabilisation']}"
        cell = data[row["model"]][way]
        cell["status"] = row["status"]
        if row["value"]:
            cell[row["metric"]] = float(row["value"])
    return data


def text(cell):
    """What stands in a cell: error in tolerances / seconds, or why there is none."""
    if not cell:
        return ""
    if "worst_error" not in cell:
        return cell["status"]
    mark = "" if cell["passed"] == 1 else "**"
    error = cell["worst_error"]
    shown = f"{error:.2f}" if error < 100 else f"{error:.0e}"
    return f"{mark}{shown}{mark} / {cell['time']:.2g}"


def markdown(path, data, ways):
    lines = ["| problem | " + " | ".join(f"`{way}`" for way in ways) + " |", "|---" * (len(ways) + 1) + "|"]
    for problem, cells in data.items():
        lines.append(f"| {problem} | " + " | ".join(text(cells.get(way)) for way in ways) + " |")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def main():
    path, out = figures.begin(__doc__)
    data = read(path)
    if not data:
        return
    ways = figures.order({way for cells in data.values() for way in cells})
    markdown(out.with_name(out.name + ".md"), data, ways)
    fig, axes = plt.subplots(figsize=(0.75 * len(ways) + 2.2, 0.3 * len(data) + 2.2))
    norm = matplotlib.colors.LogNorm(1e-3, 10)
    colours = plt.get_cmap("viridis_r")
    for line, (problem, cells) in enumerate(data.items()):
        for column, way in enumerate(ways):
            cell = cells.get(way)
            if not cell:
                continue
            known = "worst_error" in cell
            colour = colours(norm(max(cell["worst_error"], 1e-3))) if known else "0.9"
            axes.add_patch(plt.Rectangle((column, line), 1, 1, facecolor=colour, edgecolor="white"))
            label = f"{cell['time']:.2g} s" if known else cell["status"]
            dark = known and norm(max(cell["worst_error"], 1e-3)) > 0.55
            axes.text(column + 0.5, line + 0.5, label, ha="center", va="center", fontsize=6,
                      color="white" if dark else "black", fontweight="bold" if known and cell["passed"] != 1 else None)
    axes.set_xlim(0, len(ways))
    axes.set_ylim(len(data), 0)
    axes.set_xticks([c + 0.5 for c in range(len(ways))], ways, rotation=60, ha="right")
    axes.set_yticks([r + 0.5 for r in range(len(data))], list(data))
    axes.tick_params(length=0)
    axes.set_title("time of the motion, s; bold: beyond the tolerance", fontsize=9)
    fig.colorbar(plt.cm.ScalarMappable(norm, colours), ax=axes, label="largest error, in tolerances", fraction=0.03)
    fig.tight_layout()
    figures.save(fig, out)


if __name__ == "__main__":
    main()
