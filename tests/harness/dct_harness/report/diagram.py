"""System diagram: boxes and bundled arrows laid out from `run.json`; drawn by diagram.svg.j2."""

from __future__ import annotations

from typing import Any

BOX = (168, 76)  # px
GAP = 132  # px between boxes
MIDDLE = 168  # px, centre line of the boxes
ARC = 46  # px, height of an arc over each box it passes


def unit(run: dict[str, Any], signal: str) -> str:
    """Return the unit that the FMUs give a signal, or an empty string."""
    return run.get("signals", {}).get(signal, {}).get("unit", "")


def layout(run: dict[str, Any]) -> dict[str, Any]:
    """Return `boxes`, `edges`, `rows` (the signals of each edge) and the size of the drawing.

    The master steps the components in the order of the system file; an arrow that runs against
    it carries the value of the step before.
    """
    components = list(run.get("system", {}).get("components", {}))
    wiring = run.get("wiring", [])
    scripted = any(wire["from"].startswith("scenario.") for wire in wiring)
    names = (["scenario"] if scripted else []) + components
    boxes = [_box(k, name, run) for k, name in enumerate(names)]
    bundles: dict[tuple[str, str], list[dict[str, str]]] = {}
    for wire in wiring:
        ends = tuple(wire[end].partition(".")[0] for end in ("from", "to"))
        if all(end in names for end in ends):
            bundles.setdefault(ends, []).append(wire)
    edges = [
        _edge(k, names.index(a), names.index(b), wires, run)
        for k, ((a, b), wires) in enumerate(bundles.items(), 1)
    ]
    width = len(names) * (BOX[0] + GAP) - GAP + 40
    return {
        "boxes": boxes,
        "edges": edges,
        "width": max(width, BOX[0] + 40),
        "height": MIDDLE + BOX[1] // 2 + ARC * max(len(names) - 2, 1),
    }


def _box(k: int, name: str, run: dict[str, Any]) -> dict[str, Any]:
    fmu = run.get("fmus", {}).get(name, {})
    scenario = run.get("system", {}).get("scenario", "").replace("\\", "/").rpartition("/")[2]
    what = scenario if name == "scenario" else fmu.get("modelName", "")
    x = 20 + k * (BOX[0] + GAP)
    return {"name": name, "what": what, "x": x, "y": MIDDLE - BOX[1] // 2,
            "width": BOX[0], "height": BOX[1]}  # fmt: skip


def _edge(
    number: int, a: int, b: int, wires: list[dict[str, str]], run: dict[str, Any]
) -> dict[str, Any]:
    """Return one bundle: straight to the neighbour, an arc above it, or back below."""
    backward = b <= a
    pitch, half = BOX[0] + GAP, BOX[1] // 2
    if b == a + 1:
        x0, x1 = 20.0 + a * pitch + BOX[0], 20.0 + b * pitch
        path, label = f"M{x0:g},{MIDDLE} H{x1 - 7:g}", ((x0 + x1) / 2, MIDDLE - 10.0)
    else:
        side = 1 if backward else -1
        shift = 0.28 * BOX[0] * (1 if a < b else -1)
        x0, x1 = (20 + k * pitch + BOX[0] / 2 for k in (a, b))
        x0, x1 = x0 + shift, x1 - shift
        start, lift = MIDDLE + side * half, side * ARC * abs(b - a)
        tip = start + side * 7
        path = f"M{x0:g},{start} C{x0:g},{start + lift} {x1:g},{start + lift} {x1:g},{tip}"
        label = ((x0 + x1) / 2, start + 0.75 * lift - 8)
    step = run.get("step")
    delay = f"one step ({step * 1e3:g} ms)" if backward and step else "none"
    signals = [{**wire, "unit": unit(run, wire["from"])} for wire in wires]
    plural = "signal" if len(wires) == 1 else "signals"
    return {"number": number, "path": path, "x": label[0], "y": label[1], "signals": signals,
            "backward": backward, "delay": delay, "text": f"{len(wires)} {plural}"}  # fmt: skip
