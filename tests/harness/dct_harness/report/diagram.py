"""System diagram: boxes and bundled arrows laid out from `run.json`; drawn by diagram.svg.j2.

Components of one FMU that read the same signals share a box: five observers beside one plant.
"""

from __future__ import annotations

import textwrap
from typing import Any

from ..kpi import typography

BOX = (176, 76)  # px, least height
GAP = 146  # px between boxes
LINE = 18  # px, a line of names in a box
LETTERS = 20  # of such a line
ARC = 46  # px, height of an arc over each box it passes
MARGIN = 34  # px, for the text over the highest arc
UNITS = 4  # units that an arrow names at most

Json = dict[str, Any]


def unit(run: Json, signal: str) -> str:
    """Return the unit that the FMUs give a signal, as it is printed, or an empty string."""
    return typography.unit(run.get("signals", {}).get(signal, {}).get("unit", ""))


def layout(run: Json) -> Json:
    """Return `boxes`, `edges` (each with its signals), `loops`, `order` and the drawing's size.

    The master steps the components in the order of the system file; an arrow that runs against
    it carries the value of the step before.
    """
    components = list(run.get("system", {}).get("components", {}))
    wiring = run.get("wiring", [])
    scripted = any(wire["from"].startswith("scenario.") for wire in wiring)
    names = (["scenario"] if scripted else []) + components
    places = _places(names, run)
    width = BOX[0] + (len(set(places.values())) - 1) * (BOX[0] + GAP) + 40
    arrows = _bundles(places, wiring)
    tall = max((abs(b - a) for a, b in arrows), default=1)
    boxes = _boxes(places, run)
    half = boxes[0]["height"] // 2 if boxes else 0
    middle = half + (MARGIN + ARC * tall if tall > 1 else MARGIN)
    for box in boxes:
        box["y"] = middle - half
    late = _delays(run, places)
    edges = [
        _edge(k, ends, wires, run, late, (middle, half))
        for k, (ends, wires) in enumerate(arrows.items(), 1)
    ]
    below = max((a - b for a, b in arrows if b < a), default=0)
    coupling = run.get("coupling", {})
    return {
        "boxes": boxes, "edges": edges, "loops": coupling.get("loops", []),
        "order": coupling.get("order", "gauss-seidel"), "width": width,
        "height": middle + half + round(1.125 * ARC * below) + MARGIN,
    }  # fmt: skip


def size(run: Json) -> tuple[int, int]:
    """Return the number of boxes that differ, and of components: how much there is to see."""
    components = list(run.get("system", {}).get("components", {}))
    return len(set(_places(components, run).values())), len(components)


def _places(names: list[str], run: Json) -> dict[str, int]:
    """Return component -> column; those alike in FMU, inputs and outputs share one."""
    places: dict[str, int] = {}
    alike: dict[Any, int] = {}
    for name in names:
        key = _likeness(name, run)
        places[name] = alike.setdefault(key, len(alike))
    return places


def _likeness(name: str, run: Json) -> Any:
    reads = [(w["from"], w["to"].partition(".")[2]) for w in run.get("wiring", [])
             if w["to"].startswith(f"{name}.")]  # fmt: skip
    gives = [w["from"].partition(".")[2] for w in run.get("wiring", [])
             if w["from"].startswith(f"{name}.")]  # fmt: skip
    digest = run.get("fmus", {}).get(name, {}).get("sha256", name)
    return (digest, tuple(sorted(reads)), tuple(gives)) if reads and not gives else name


def _bundles(places: dict[str, int], wiring: list[Json]) -> dict[tuple[int, int], list[Json]]:
    """Return (from column, to column) -> wires; a shared box shows those of its first member."""
    first = {column: name for name, column in reversed(places.items())}
    found: dict[tuple[int, int], list[Json]] = {}
    for wire in wiring:
        giver, taker = (wire[end].partition(".")[0] for end in ("from", "to"))
        if giver in places and taker in places and first[places[taker]] == taker:
            found.setdefault((places[giver], places[taker]), []).append(wire)
    return found


def _boxes(places: dict[str, int], run: Json) -> list[Json]:
    columns: dict[int, list[str]] = {}
    for name, column in places.items():
        columns.setdefault(column, []).append(name)
    lines = {c: textwrap.wrap(", ".join(names), LETTERS) for c, names in columns.items()}
    most = max((len(text) for text in lines.values()), default=1)
    height = BOX[1] + LINE * (most - 1)
    return [
        {"names": lines[c], "what": _what(names[0], run), "x": 20 + c * (BOX[0] + GAP),
         "top": (height - LINE * len(lines[c]) - LINE) // 2 + 14, "width": BOX[0], "height": height}
        for c, names in columns.items()
    ]  # fmt: skip


def _what(name: str, run: Json) -> str:
    """Return the scenario's file, or the model and its substeps."""
    if name == "scenario":
        path: str = run.get("system", {}).get("scenario", "")
        return path.replace("\\", "/").rpartition("/")[2]
    part = run.get("system", {}).get("components", {}).get(name, {})
    model = run.get("fmus", {}).get(name, {}).get("modelName", "")
    substeps = part.get("substeps", 1)
    return model if substeps == 1 else f"{model} · {substeps} substeps"


def _delays(run: Json, places: dict[str, int]) -> set[tuple[str, str]]:
    """Return the wires that carry the value of the step before, as the run recorded them."""
    coupling = run.get("coupling")
    if coupling is not None:
        return {(wire["from"], wire["to"]) for wire in coupling["delayed"]}
    return {
        (w["from"], w["to"]) for w in run.get("wiring", [])
        if places.get(w["from"].partition(".")[0], -1) >= places.get(w["to"].partition(".")[0], 0)
    }  # fmt: skip


def _edge(
    number: int, ends: tuple[int, int], wires: list[Json], run: Json,
    late: set[tuple[str, str]], line: tuple[int, int],
) -> Json:  # fmt: skip
    """Return one bundle: straight to the neighbour, an arc above it, or back below."""
    step = run.get("step")
    delay = f"one step ({step * 1e3:g} ms)" if step else "one step"
    late_by = f"{step * 1e3:g} ms" if step else "one step"
    signals = [
        {**wire, "unit": unit(run, wire["from"]),
         "delay": delay if (wire["from"], wire["to"]) in late else "none"}
        for wire in wires
    ]  # fmt: skip
    delayed = any(signal["delay"] != "none" for signal in signals)
    units = list(dict.fromkeys(s["unit"] for s in signals if s["unit"]))
    shown = ", ".join(units[:UNITS]) + (", …" if len(units) > UNITS else "")
    plural = "signal" if len(wires) == 1 else "signals"
    return {
        "number": number, "signals": signals, "delayed": delayed,
        "text": f"{len(wires)} {plural}" + (f", {late_by} late" if delayed else ""),
        "units": f"[{shown}]" if shown else "", **_path(ends, line),
    }  # fmt: skip


def _path(ends: tuple[int, int], line: tuple[int, int]) -> Json:
    """Return the curve, and where its text stands."""
    (a, b), (middle, half), pitch = ends, line, BOX[0] + GAP
    if b == a + 1:
        x0, x1 = 20.0 + a * pitch + BOX[0], 20.0 + b * pitch
        return {"path": f"M{x0:g},{middle} H{x1 - 7:g}", "x": (x0 + x1) / 2, "y": middle - 8.0}
    side = 1 if b <= a else -1
    shift = 0.28 * BOX[0] * (1 if a < b else -1)
    x0, x1 = (20 + k * pitch + BOX[0] / 2 for k in (a, b))
    x0, x1 = x0 + shift, x1 - shift
    deep = 1.5 if side > 0 else 1.0  # below, text stands inside of arcs: outside another may pass
    start, lift = middle + side * half, side * deep * ARC * max(abs(b - a), 1)
    path = f"M{x0:g},{start} C{x0:g},{start + lift} {x1:g},{start + lift} {x1:g},{start + side * 7}"
    return {"path": path, "x": (x0 + x1) / 2, "y": start + 0.75 * lift - (8 if side < 0 else 26)}
