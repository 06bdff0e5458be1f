"""What an observer learnt in a run, as a parameter file (.ssv) that another run starts with."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from .. import results
from ..errors import ConfigError, did_you_mean
from ..fmu.archive import described
from ..results import Results
from ..system import parameters
from ..system.system import System
from . import ssd_xml
from .ssd_xml import sub

OBSERVER, CONTROL = "observer", "control"  # the components that --calibration is for
NAME = "calibration.ssv"
PREFIX, DEVIATION = "calibration.", "Deviation"
FRICTION, NOMINAL = "friction", "nominalFriction"
CLUTCHES = ("clutch1", "clutch2")
MAP, SIGMA = "frictionMap", "frictionMapSigma"
POINTS = 5  # of a friction over the position, evenly from the touch point to the end of the map


def save(out: Path, run: Results) -> list[Path]:
    """Write what every observer of the run learnt; files of an earlier run go.

    `calibration.ssv` is that of the component `observer`, `calibration.NAME.ssv` that of another.
    """
    for old in out.glob("calibration*.ssv"):
        old.unlink()
    written = []
    for component in run.run["system"]["components"]:
        values = learnt(run, component)
        if values:
            name = "" if component == OBSERVER else f".{component}"
            written.append(out / f"calibration{name}.ssv")
            known = run.run["parameters"][component]
            results.write_text(written[-1], _text(component, values, known))
    return written


def learnt(run: Results, component: str) -> dict[str, float]:
    """Return start values that go on where a component's calibration ended; empty if it has none.

    The deviations become those of the start, and the friction that was learnt the nominal one.
    """
    head = f"{component}.{PREFIX}"
    told = {n.removeprefix(head): float(run[n][-1]) for n in run.signals if n.startswith(head)}
    known = run.run["parameters"][component]  # the mass, which the inertia tells, has no start
    deviations = {name: told[name + DEVIATION] for name in told if f"{PREFIX}{name}Sigma" in known}
    if not any(deviations.values()):
        return {}
    values = {f"{PREFIX}{name}Start": told[name] for name in deviations}
    values |= {f"{PREFIX}{name}Sigma": v for name, v in deviations.items()}
    for clutch in CLUTCHES:
        head = f"{component}.{clutch}"
        friction = float(run[f"{head}.{FRICTION}"][-1])
        values[f"{clutch}.{NOMINAL}"] = friction
        if f"{head}.{MAP}[1]" in run:
            values |= _map(run, component, clutch, friction)
    return values


def _map(run: Results, component: str, clutch: str, friction: float) -> dict[str, float]:
    """Return what carries with one friction what was learnt over the position, and deviations.

    A clutch that pressure moves has no force-position map, so only its deviations are kept.
    """
    head, known = f"{component}.{clutch}.{MAP}", run.run["parameters"][component]
    deviations = {f"{clutch}.{SIGMA}[{k}]": float(run[f"{head}Deviation[{k}]"][-1])
                  for k in range(1, POINTS + 1)}  # fmt: skip
    if known[f"{clutch}.pistonArea"]["value"] > 0 or friction <= 0:
        return deviations
    position, force = force_map(known, clutch)
    learnt = [float(run[f"{head}[{k}]"][-1]) for k in range(1, POINTS + 1)]
    share = np.interp(position, places(position, force), learnt) / friction
    corrected = np.maximum.accumulate(np.maximum(force * share, 0.0))
    return deviations | {f"{clutch}.map.force[{k}]": float(f) for k, f in enumerate(corrected, 1)}


def force_map(known: dict[str, Any], clutch: str) -> tuple[np.ndarray, np.ndarray]:
    """Return positions [m] and forces [N] of a map among the parameters of `run.json`."""
    count = sum(name.startswith(f"{clutch}.map.force[") for name in known)
    rows = [[known[f"{clutch}.map.{what}[{k}]"]["value"] for k in range(1, count + 1)]
            for what in ("position", "force")]  # fmt: skip
    return np.array(rows[0]), np.array(rows[1])


def places(position: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Return the positions [m] of the points of a friction over the position, shape (5,)."""
    touch = position[max(int(np.count_nonzero(force <= 0)) - 1, 0)]
    return np.linspace(touch, position[-1], POINTS)


def apply(model: System, path: Path, paths: dict[str, Path]) -> None:
    """Put the parameter file that a run has written, or that in its folder, into an observer.

    The control takes those that it has: nominal frictions and force-position maps.
    """
    if OBSERVER not in model.components:
        hint = did_you_mean(OBSERVER, model.components)
        raise ConfigError(f"--calibration: {model.path} has no component '{OBSERVER}'.{hint}")
    values = parameters.read(_in_folder(path) if path.is_dir() else path)
    model.components[OBSERVER].parameters |= values
    if CONTROL in model.components:
        known = {v.name for v in described(paths[CONTROL]).modelVariables}
        shared = {name: value for name, value in values.items() if name in known}
        model.components[CONTROL].parameters |= shared


def _in_folder(folder: Path) -> Path:
    """Return the parameter file in the folder of a run."""
    if (folder / NAME).is_file():
        return folder / NAME
    others = ", ".join(sorted(path.name for path in folder.glob("calibration.*.ssv")))
    inside = min((path.parent for path in folder.glob(f"*/{NAME}")), default=None)
    there = f"; of other observers there is {others}: name the file" if others else ""
    there = f"; did you mean {inside}?" if inside else there
    made = ("`dct-harness run` writes it to --out at the end of a run whose observer learns: "
            "--set observer.observer.method=calibrating")  # fmt: skip
    raise ConfigError(f"--calibration {folder}: no {NAME} in this folder{there or f'; {made}'}")


def _text(component: str, values: dict[str, float], known: dict[str, Any]) -> str:
    """Return the parameter file; `known` are the component's parameters with their units."""
    root = Element(ssd_xml.tag("ssv:ParameterSet"), {"version": "1.0", "name": component})
    listed = sub(root, "ssv:Parameters")
    for name, value in values.items():
        parameter = sub(listed, "ssv:Parameter", name=name)
        sub(parameter, "ssv:Real", value=value, unit=known[name]["unit"])
    return ssd_xml.document(root).decode()
