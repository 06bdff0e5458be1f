"""What an FMU shows, from its description: variables, inputs and outputs in the order of a run."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any

from ..errors import ConfigError, did_you_mean
from ..units import Unit, declared
from .archive import described
from .values import group_of, start_value

GROUPS = ("Real", "Integer", "Boolean")
OURS = "fmu-build "  # generationTool of FMUs that this project builds


class Ports:
    """The variables of one component; its library is not loaded."""

    def __init__(self, name: str, path: Path) -> None:
        self.name, self.path = name, path
        self.now = 0.0
        self.describe(described(path))

    def describe(self, description: Any) -> None:
        """Take variables, inputs and outputs of a description."""
        self.description = description
        self.variables: dict[str, Any] = {v.name: v for v in description.modelVariables}
        self.inputs = self._ordered("input")
        self.outputs = self._ordered("output")

    @property
    def is_ours(self) -> bool:
        """Whether this project built the FMU."""
        return is_ours(self.description)

    def _ordered(self, causality: str) -> list[Any]:
        """Return variables of a causality, reals first, then integers, then booleans."""
        found = [v for v in self.description.modelVariables if v.causality == causality]
        return [v for group in GROUPS for v in found if group_of(v) == group]

    def steer(self, names: Collection[str]) -> None:
        """Take the tunable parameters among `names` as inputs: they change during the run."""
        steered = [v for v in self.description.modelVariables if v.causality == "parameter"
                   and v.variability == "tunable" and v.name in names]  # fmt: skip
        self.inputs = sorted([*self.inputs, *steered], key=lambda v: GROUPS.index(group_of(v)))

    def unit(self, name: str) -> Unit | None:
        """Return the unit that the FMU declares for a variable; None if it is not known."""
        return declared(self.description, self.variables[name])[1]

    def feedthrough(self, initial: bool = False) -> dict[str, set[str]]:
        """Return output -> inputs that it depends on at the same instant, or initially."""
        return feedthrough(self.description, initial)

    def check_start(self, name: str, value: Any) -> Any:
        """Return a parameter or start value as the FMU takes it.

        Raises
        ------
        ConfigError
            There is no such variable, it cannot be set, or the value does not fit.
        """
        if name not in self.variables:
            hint = did_you_mean(name, self.variables)
            what = f"component '{self.name}': {self.path} has no '{name}'.{hint}"
            raise ConfigError(what, name)
        variable = self.variables[name]
        if self.is_ours and variable.initial == "calculated":
            start = f"{name}_start"
            hint = f" Did you mean '{start}'?" if start in self.variables else ""
            what = f"component '{self.name}': the FMU computes '{name}' itself; it cannot be set."
            raise ConfigError(f"{what}{hint}", name)
        return start_value(self.name, variable, value)


def is_ours(description: Any) -> bool:
    """Return whether this project built the FMU of a description."""
    return (description.generationTool or "").startswith(OURS)


def feedthrough(description: Any, initial: bool = False) -> dict[str, set[str]]:
    """Return output -> inputs that it depends on at the same instant; or in initialisation mode.

    An output without stated dependencies may depend on every input (FMI 2.0.4, 2.2.8); such outputs
    share one set, so that this takes no more than the description says.
    """
    inputs = {v.name for v in description.modelVariables if v.causality == "input"}
    unknowns = {u.variable.name: u for u in description.outputs}
    if initial:
        first = {u.variable.name: u for u in description.initialUnknowns}
        unknowns = {name: first.get(name, u) for name, u in unknowns.items()}
    found = {}
    for name, unknown in unknowns.items():
        named = unknown.dependencies
        found[name] = inputs if named is None else {v.name for v in named} & inputs
    return found
