"""What an observer learnt in a run, as a parameter file (.ssv) that another run starts with."""

from __future__ import annotations

from pathlib import Path
from xml.etree.ElementTree import Element

from . import parameters, results, ssd_xml
from .errors import ConfigError, did_you_mean
from .results import Results
from .ssd_xml import sub
from .system import System

OBSERVER = "observer"  # the component that --calibration is for
PREFIX, DEVIATION = "calibration.", "Deviation"
FRICTION, NOMINAL = "friction", "nominalFriction"
CLUTCHES = ("clutch1", "clutch2")


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
            results.write_text(written[-1], _text(component, values, results.units(run.run)))
    return written


def learnt(run: Results, component: str) -> dict[str, float]:
    """Return start values that go on where a component's calibration ended; empty if it has none.

    The deviations become those of the start, and the friction that was learnt the nominal one.
    """
    head = f"{component}.{PREFIX}"
    told = {n.removeprefix(head): float(run[n][-1]) for n in run.signals if n.startswith(head)}
    known = run.run["parameters"][
        component
    ]  # the mass, which follows from the inertia, has no start
    deviations = {name: told[name + DEVIATION] for name in told if f"{PREFIX}{name}Sigma" in known}
    if not any(deviations.values()):
        return {}
    values = {f"{PREFIX}{name}Start": told[name] for name in deviations}
    values |= {f"{PREFIX}{name}Sigma": v for name, v in deviations.items()}
    return values | {
        f"{clutch}.{NOMINAL}": float(run[f"{component}.{clutch}.{FRICTION}"][-1])
        for clutch in CLUTCHES
    }


def apply(model: System, path: Path) -> None:
    """Put a parameter file that a run has written into the observer of a system."""
    if OBSERVER not in model.components:
        hint = did_you_mean(OBSERVER, model.components)
        raise ConfigError(f"--calibration: {model.path} has no component '{OBSERVER}'.{hint}")
    model.components[OBSERVER].parameters |= parameters.read(path)


def _text(component: str, values: dict[str, float], units: dict[str, str]) -> str:
    """Return the parameter file; a deviation and a start have the unit of what was learnt."""
    root = Element(ssd_xml.tag("ssv:ParameterSet"), {"version": "1.0", "name": component})
    listed = sub(root, "ssv:Parameters")
    for name, value in values.items():
        of = name.removesuffix("Start").removesuffix("Sigma")
        unit = units.get(f"{component}.{of}")
        sub(sub(listed, "ssv:Parameter", name=name), "ssv:Real", value=value, unit=unit)
    return ssd_xml.document(root).decode()
