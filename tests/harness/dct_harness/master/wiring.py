"""How a run is wired: where each input reads its value, and the scenario at every instant.

Runs of a sweep that differ in values only have the same wiring; `Wirings` makes it once for them.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from .. import graph
from ..errors import ConfigError
from ..fmu.fmu import Fmu
from ..results import median_step
from ..supplier.mapped import Mapped
from ..system import scenario as scenarios
from ..system.scenario import Scenario
from ..system.system import System
from ..system.transforms import Transform
from .connections import check_types, held, resolve, transforms, types
from .initial import edges

STEP_TOLERANCE = 1e-9  # relative; a stop this close to a multiple of the step is one
MOST_STEPS = 1e8  # of a run; its times alone take 0.8 GB
Fmus = Mapping[str, Fmu | Mapped]


def communication_points(step: float, stop: float) -> np.ndarray:
    """Return k * step [s] up to `stop`; the last step is shorter when stop is no multiple.

    Raises
    ------
    ConfigError
        A time is not finite or not above 0, or there are too many steps.
    """
    sound = 0 < step < math.inf and 0 < stop < math.inf
    if not sound or not stop / step <= MOST_STEPS:
        raise ConfigError(
            f"step = {step:g} s and stop = {stop:g} s: both must be above 0 and finite, "
            f"with at most {MOST_STEPS:g} steps"
        )
    count = stop / step
    whole = round(count)
    if abs(count - whole) > STEP_TOLERANCE * max(1.0, count):
        whole = math.ceil(count)
    times = np.arange(whole + 1) * step
    times[-1] = stop
    return times


@dataclass(frozen=True)
class Wiring:
    """Nobody may write to it: runs share it.

    `sources`: input -> source; `used`: columns of the scenario that an input reads; `script`: these
    at `times`, shape (samples, columns); `levels`: in which order initial values are passed on.
    """

    scenario: Scenario
    times: np.ndarray
    sources: dict[str, str]
    transforms: dict[str, Transform]
    types: dict[str, str]
    used: list[str]
    script: np.ndarray
    outputs: list[str]
    levels: list[list[list[str]]]

    @cached_property
    def spacing(self) -> float:
        """Step between most communication points [s]."""
        return median_step(self.times)


def wire(system: System, fmus: Fmus, script: Scenario) -> Wiring:
    """Return the wiring of FMUs that have been told which parameters the scenario steers.

    Raises
    ------
    ConfigError
        A connection is missing, ambiguous or of ends that do not fit.
    """
    times = communication_points(system.step, system.stop)
    sources = resolve(system, fmus, list(script.signals))
    check_types(system, fmus, sources, script)
    changes = transforms(system, fmus, sources)
    still = held(fmus, sources)
    read = set(sources.values())
    used = [s for s in script.signals if f"scenario.{s}" in read]
    columns = [script.sample(s, times, f"scenario.{s}" in still) for s in used]
    table = np.ascontiguousarray(np.array(columns).T.reshape(len(times), len(columns)))
    table.flags.writeable = False
    outputs = [f"{n}.{v.name}" for n, f in fmus.items() for v in f.outputs]
    levels = graph.levels(edges(fmus, sources))
    return Wiring(script, times, sources, changes, types(fmus), used, table, outputs, levels)


class Wirings:
    """The last wiring of runs of one system, for the next one that differs in values only."""

    def __init__(self) -> None:
        self._last: tuple[Any, list[Any], Wiring] | None = None

    def of(self, system: System, fmus: Fmus) -> Wiring:
        """Return the wiring of a run, as `wire`; of other values of the same variables, the last.

        Besides `system`, whose files and options are always the same ones, it depends on the FMUs
        and on which of their variables are given a value.
        """
        last = self._last
        script = last[2].scenario if last else scenarios.load(system.scenario)
        for fmu in fmus.values():
            fmu.steer(script.signals)
        given = {name: set(c.parameters) for name, c in system.components.items()}
        descriptions = [fmu.description for fmu in fmus.values()]
        if last is not None and given == last[0] and _identical(descriptions, last[1]):
            return last[2]
        made = wire(system, fmus, script)
        self._last = given, descriptions, made
        return made


def _identical(these: list[Any], those: list[Any]) -> bool:
    return len(these) == len(those) and all(map(operator.is_, these, those))
