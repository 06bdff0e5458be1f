"""What a plant shows to the other FMUs: the descriptions of DctPlant and DctObserver.

The XML files beside this one are written by `cargo fmu describe`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from ..fmu.archive import parsed
from ..units import Unit, declared


@dataclass(frozen=True)
class Contract:
    """Variables of a plant by name.

    `needed` are the outputs that the observer reads, `believed` the parameters that it has, too.
    """

    description: Any
    variables: dict[str, Any]
    needed: frozenset[str]
    believed: frozenset[str]

    def of(self, causality: str) -> dict[str, Any]:
        """Return the variables of a causality by name."""
        return {n: v for n, v in self.variables.items() if v.causality == causality}

    def unit(self, name: str) -> Unit:
        """Return the SI unit of a variable; the unit 1 where it has none."""
        return declared(self.description, self.variables[name])[1] or Unit("1")


def _read(name: str) -> Any:
    file = resources.files(__package__).joinpath(f"{name}.xml")
    return parsed(Path(str(file)), file.read_bytes())


@cache
def plant() -> Contract:
    """Return what DctPlant shows and DctObserver reads."""
    description, observer = _read("DctPlant"), _read("DctObserver")
    variables = {v.name: v for v in description.modelVariables}
    known = {(v.name, v.causality) for v in observer.modelVariables}
    read = {n for n, v in variables.items() if v.causality == "output" and (n, "input") in known}
    believed = {n for n, v in variables.items() if (n, "parameter") in known}
    return Contract(description, variables, frozenset(read), frozenset(believed))
