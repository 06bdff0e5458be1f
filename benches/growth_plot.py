"""Table and plot of what `growth.py` measured."""

from __future__ import annotations

import os
from itertools import groupby
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

Told = list[dict[str, Any]]
MIB = 2.0**20
# Of each axis: what a unit of work is, and how the time of one reads.
UNITS = {
    "runs": ("run", "ms", 1e3),
    "steps per second": ("step", "µs", 1e6),
    "recorded signals": ("step", "µs", 1e6),
    "instances": ("instance, 100 steps", "µs", 1e6),
    "instances, own parameters": ("instance, 100 steps", "µs", 1e6),
    "threads": ("run", "ms", 1e3),
}
PLAIN = 100.0  # from here on a cost is shown without decimals or exponent
LINEAR = ("runs", "steps per second", "instances", "instances, own parameters")
COLOURS = {"cpu": "#3266ad", "memory": "#3d8c40"}
SIZE = (11.0, 11.5)  # inches
ABOVE = 1.1  # of the largest value: where an axis from 0 on ends


def _axes(points: Told) -> list[tuple[str, Told]]:
    return [(axis, list(of)) for axis, of in groupby(points, key=lambda point: point["axis"])]


def table(points: Told) -> str:
    """Return a Markdown table: whole cost, and cost of one unit."""
    heads = ("axis", "size", "CPU time", "CPU time of one", "memory")
    lines = [f"| {' | '.join(heads)} |", "|---|--:|--:|--:|--:|"]
    for point in points:
        what, unit, factor = UNITS[point["axis"]]
        cost = point["cpu"] / point["units"] * factor
        one = f"{cost:,.0f}" if cost >= PLAIN else f"{cost:.3g}"
        one = f"{one} {unit} per {what}"
        memory = f"{point['memory'] / MIB:.3g} MiB"
        lines.append(f"| {point['axis']} | {point['size']:,g} | {point['cpu']:.3g} s "
                     f"| {one} | {memory} |")  # fmt: skip
    return "\n".join(lines) + "\n"


def _panel(axes: Any, axis: str, points: Told) -> None:
    sizes = np.array([point["size"] for point in points])
    some = sizes > 0
    values = np.array([point["cpu"] for point in points])
    axes.plot(sizes[some], values[some], "o-", color=COLOURS["cpu"], label="CPU time", markersize=4)
    if axis in LINEAR:
        last = points[-1]
        straight = last["cpu"] * sizes[some] / last["size"]
        axes.plot(sizes[some], straight, ":", color="grey", label="in proportion to the last one")
    beside = axes.twinx()
    memory = np.array([point["memory"] / MIB for point in points])
    beside.plot(sizes[some], memory[some], "s--", color=COLOURS["memory"], markersize=4)
    beside.set_ylabel("memory [MiB]", color=COLOURS["memory"])
    for side in (axes, beside):
        if axis in LINEAR:
            side.set_yscale("log")
        else:
            side.set_ylim(0.0, ABOVE * side.dataLim.ymax)
    axes.set_xscale("log")
    axes.set_xlabel(axis)
    axes.set_ylabel("CPU time [s]")
    axes.grid(alpha=0.3)


def draw(points: Told, out: Path) -> None:
    """Draw a panel per axis; logarithmic where the work grows along it."""
    mpl.rcParams.update({"svg.hashsalt": "growth", "font.size": 9})
    figure = Figure(figsize=SIZE, layout="constrained")
    panels = figure.subplots(3, 2)
    for axes, (axis, of) in zip(panels.flat, _axes(points), strict=True):
        _panel(axes, axis, of)
        axes.set_title(axis)
    handles, labels = panels[0][0].get_legend_handles_labels()
    handles.append(mpl.lines.Line2D([], [], color=COLOURS["memory"], linestyle="--", marker="s"))
    labels.append("memory")
    figure.legend(handles, labels, loc="outside upper center", ncols=3)
    part = out.with_suffix(".part")
    figure.savefig(part, format="svg", metadata={"Date": None})
    os.replace(part, out)
