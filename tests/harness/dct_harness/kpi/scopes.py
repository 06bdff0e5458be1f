"""Scopes over which a KPI is taken: the scenario, its phases, the clutch states."""

from __future__ import annotations

import csv
import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import ConfigError
from ..results import Results, read_json

SCENARIO = "scenario"
Samples = np.ndarray | slice  # which ones: a mask of shape (n,), or all from one to another
STATES = {1: "disengaged", 2: "slipping", 3: "engaged"}  # ClutchState of the plant
CLUTCHES = ("clutch1", "clutch2")


@dataclass(frozen=True)
class Phase:
    """A named stretch of the scenario, `start` ≤ t < `end` [s]."""

    name: str
    start: float
    end: float


def load_phases(results: Results, run: dict[str, Any]) -> list[Phase]:
    """Return the phases of a run, in order.

    They stand in `<scenario>.phases.csv` or `phases.csv` beside the scenario (columns `start`,
    `end` [s], `phase`). A result directory that was moved away from its scenario keeps those
    that its `kpis.json` recorded; without either there are none.
    """
    scenario = Path(run.get("system", {}).get("scenario", ""))
    for name in (f"{scenario.stem}.phases.csv", "phases.csv"):
        path = scenario.with_name(name) if scenario.name else Path(name)
        if scenario.name and path.is_file():
            return read_phases(path)
    stored = results.path / "kpis.json" if results.path else None
    if stored and stored.is_file():
        kpis = read_json(stored)
        return [Phase(**phase) for phase in kpis.get("phases", [])]
    return []


def read_phases(path: Path) -> list[Phase]:
    """Read a phases file.

    Raises
    ------
    ConfigError
        A column is missing, a time is no number, a phase ends before it starts, or a name
        stands twice.
    """
    with path.open(encoding="utf-8-sig", newline="") as file:
        rows = list(csv.DictReader(file))
    phases = [_phase(path, line, row) for line, row in enumerate(rows, 2)]
    names = [phase.name for phase in phases]
    for name in names:
        if names.count(name) > 1:
            raise ConfigError(f"{path}: phase '{name}' stands twice; number them")
    return phases


def _phase(path: Path, line: int, row: dict[str, str]) -> Phase:
    try:
        phase = Phase(row["phase"].strip(), float(row["start"]), float(row["end"]))
    except (KeyError, TypeError, ValueError, AttributeError):
        raise ConfigError(f"{path}:{line}: needs numbers start, end and a name phase") from None
    if not (math.isfinite(phase.start) and phase.start < phase.end):
        raise ConfigError(f"{path}:{line}: phase '{phase.name}' must end after it starts")
    return phase


def phase_masks(time: np.ndarray, phases: list[Phase]) -> dict[str, Samples]:
    """Return scope name -> samples, for the scenario and each phase it reaches."""
    masks: dict[str, Samples] = {SCENARIO: slice(None)}  # no copy is made of what it chooses
    for phase in phases:
        upper = time <= phase.end if phase.end >= time[-1] else time < phase.end
        inside = (time >= phase.start) & upper
        if inside.any():
            masks[f"phase/{phase.name}"] = inside
    return masks


def before(mask: Samples, end: int) -> Samples:
    """Return the samples of a mask, or of a slice of all, that lie before sample `end`."""
    return slice(0, max(end, 0)) if isinstance(mask, slice) else np.flatnonzero(mask[: max(end, 0)])


def masks(results: Results, torque: str, phases: list[Phase] | None) -> dict[str, Samples]:
    """Return scope name -> samples of a torque: the scenario, its phases, the clutch's states.

    `phases` None: the scenario alone.
    """
    if phases is None:
        return phase_masks(results.time, [])
    return phase_masks(results.time, phases) | state_masks(results, torque)


def states(known: Collection[str]) -> Iterator[str]:
    """Yield the known signals that tell the states of the clutches."""
    yield from (name for clutch in CLUTCHES if (name := _state(clutch)) in known)


def _state(clutch: str) -> str:
    return f"plant.{clutch}.state"


def clutch_state(results: Results, clutch: str) -> np.ndarray | None:
    """Return the plant's state of a clutch, shape (n,), or None if the plant does not tell."""
    name = _state(clutch)
    return results[name].astype(int) if name in results else None


def state_masks(results: Results, torque: str) -> dict[str, np.ndarray]:
    """Return scope -> samples by the state of the torque's own clutch.

    The drive shaft counts as slipping while any clutch slips, else as engaged while one is.
    """
    own = [clutch for clutch in CLUTCHES if torque.startswith(f"{clutch}.")] or list(CLUTCHES)
    states = [s for s in (clutch_state(results, clutch) for clutch in own) if s is not None]
    if len(states) != len(own):
        return {}
    table = np.array(states)
    slipping, engaged = (table == 2).any(axis=0), (table == 3).any(axis=0)
    driveline = np.where(slipping, 2, np.where(engaged, 3, 1))
    masks = {f"state/{name}": driveline == code for code, name in STATES.items()}
    return {scope: mask for scope, mask in masks.items() if mask.any()}
