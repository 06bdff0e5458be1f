"""What a car or a rig measured of its plant, beside what the FMUs are given.

In a system without the component `plant`, columns `plant.<variable>` of the scenario are recorded
as they are: KPIs and reports judge an observer against measured torques as against a plant's.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np

from ..contract import plant as plant_contract
from ..errors import did_you_mean
from ..fmu.values import group_of, unit_of
from ..system.scenario import Scenario

PLANT = "plant"


class Measured:
    """The columns by name, sampled at `times` [s]; none where a plant runs.

    `told` has unit and type of each, `doubts` a sentence for each that no plant shows.
    """

    def __init__(self, script: Scenario, components: Collection[str], times: np.ndarray) -> None:
        prefix = f"{PLANT}."
        names = [] if PLANT in components else [n for n in script.signals if n.startswith(prefix)]
        known = {prefix + n: v for n, v in plant_contract().of("output").items()}
        self.told: dict[str, dict[str, Any]] = {n: {"unit": "", "type": "Real"} for n in names}
        for name in known.keys() & self.told.keys():
            self.told[name] = {"unit": unit_of(known[name]), "type": group_of(known[name])}
        self.names = names
        self.table = np.empty((len(times), len(names)))
        for k, (name, told) in enumerate(self.told.items()):
            self.table[:, k] = script.sample(name, times, told["type"] != "Real")
        self.doubts = [
            (0.0, f"scenario {script.path.name}: no plant shows '{name}'."
                  f"{did_you_mean(name, known)} No KPI is of it")
            for name in names if name not in known
        ]  # fmt: skip
