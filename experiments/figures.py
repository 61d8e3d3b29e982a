"""What the figures of all experiments share: command line, styles of formulations, files."""
import argparse
import csv
import pathlib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

COLOURS = ["#000000", "#d55e00", "#0072b2", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#7f7f7f"]
LINES = ["-", "--", "-.", ":", (0, (5, 1)), (0, (3, 1, 1, 1)), (0, (1, 1)), (0, (7, 2))]
MARKERS = ["o", "s", "^", "D", "v", "P", "X", "*", "<", ">", "p", "h", "d", "8"]


def begin(description):
    """The CSV that is asked for, and the path of figures without suffix."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("csv", type=pathlib.Path)
    parser.add_argument("--out-dir", type=pathlib.Path, help="default: beside the CSV")
    arguments = parser.parse_args()
    out = (arguments.out_dir or arguments.csv.parent) / arguments.csv.stem
    out.parent.mkdir(parents=True, exist_ok=True)
    plt.rcParams.update({"font.size": 9, "svg.hashsalt": "lanc", "pdf.fonttype": 42})
    return arguments.csv, out


def rows(path):
    with open(path, newline="", encoding="utf-8") as file:
        yield from csv.DictReader(file)


def order(names):
    """The recursion first, so that it has the same style everywhere."""
    return sorted(names, key=lambda name: (name != "recursive", name))


def styles(names):
    """Colour, line style and marker by name: up to 8 differ in colour and line, more in markers, so that grey prints
    tell them apart."""
    return {name: (COLOURS[i % len(COLOURS)], LINES[(i + i // len(COLOURS)) % len(LINES)], MARKERS[i % len(MARKERS)])
            for i, name in enumerate(order(names))}


def save(fig, out):
    """As SVG and PDF, the same bytes every time."""
    for suffix, date in ((".svg", "Date"), (".pdf", "CreationDate")):
        fig.savefig(out.with_name(out.name + suffix), metadata={date: None})
    plt.close(fig)
