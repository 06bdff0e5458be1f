"""Initial values: passed on in the order in which they depend on each other, loops solved.

The graph has an edge from each source to its input, and from an input to each output that depends
on it in initialisation mode (InitialUnknowns of the description, else Outputs).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import FmuRuntimeError
from ..system.transforms import Conversion

SWEEPS = 50  # of a loop, before it is solved by Newton's method
NEWTON = 20  # iterations
SETTLED = 1e-14  # relative change of an initial value that counts as none
SOLVED = 1e-10  # relative change after a Newton iteration that counts as none
PROBE = 1e-6  # relative change of a value for a difference quotient


@dataclass
class Member:
    """A component as the loop sees it: where its inputs are read, and their buffer."""

    fmu: Any
    where: np.ndarray
    values: np.ndarray
    convert: Conversion


class Initialization:
    """Settles the initial values of connected components in initialisation mode."""

    def __init__(
        self, members: dict[str, Member], levels: list[list[list[str]]], world: np.ndarray
    ) -> None:
        """`levels`: those of the graph of `edges`."""
        self._members, self._world, self._levels = members, world, levels
        self._place = {f"{n}.{v.name}": (n, k) for n, m in members.items()
                       for k, v in enumerate(m.fmu.inputs)}  # fmt: skip

    def settle(self) -> None:
        """Pass values on; every input has its source's value afterwards.

        Raises
        ------
        FmuRuntimeError
            The values of a loop do not settle.
        """
        for member in self._members.values():
            member.values[:] = [_start(v) for v in member.fmu.inputs]
            member.fmu.get_outputs()
        for level in self._levels:
            single = [part[0] for part in level if len(part) == 1]
            self._pass(single)
            for part in level:
                if len(part) > 1:
                    self._solve(part)

    def _pass(self, signals: list[str]) -> None:
        """Give inputs their sources' values, then read the outputs; components one by one."""
        for name, member in self._members.items():
            inputs = [self._place[s][1] for s in signals if self._place.get(s, ("",))[0] == name]
            for k in inputs:
                member.values[k] = member.convert.one(k, float(self._world[member.where[k]]))
            if inputs:
                member.fmu.set_inputs()
            if inputs or any(s.startswith(f"{name}.") for s in signals):
                member.fmu.get_outputs()

    def _solve(self, loop: list[str]) -> None:
        """Pass the values of a loop around until they stay, else by Newton's method."""
        for _ in range(SWEEPS):
            before = self._world.copy()
            self._pass(loop)
            if np.allclose(self._world, before, rtol=SETTLED, atol=0, equal_nan=True):
                return
        if not self._newton([s for s in loop if s in self._place]):
            raise FmuRuntimeError(
                f"the initial values of an algebraic loop do not settle: {' -> '.join(loop)}; "
                "give one of its inputs a value, or break it"
            )

    def _newton(self, inputs: list[str]) -> bool:
        """Solve source(inputs) = inputs; returns whether it converged."""
        x = self._given(inputs)
        for _ in range(NEWTON):
            found = self._answers(inputs, x)
            slopes = np.empty((len(x), len(x)))
            for k in range(len(x)):
                size = PROBE * max(1.0, abs(x[k]))
                moved = x + size * (np.arange(len(x)) == k)
                slopes[:, k] = (self._answers(inputs, moved) - found) / size
            try:
                change = np.linalg.solve(np.eye(len(x)) - slopes, found - x)
            except np.linalg.LinAlgError:
                return False
            x = x + change
            if np.all(np.abs(change) <= SOLVED * np.maximum(1.0, np.abs(x))):
                self._answers(inputs, x)
                return True
        return False

    def _given(self, inputs: list[str]) -> np.ndarray:
        places = [self._place[s] for s in inputs]
        return np.array([self._members[n].values[k] for n, k in places])

    def _answers(self, inputs: list[str], x: np.ndarray) -> np.ndarray:
        """Return what the sources give when the inputs have the values `x`."""
        places = [self._place[s] for s in inputs]
        for (name, k), value in zip(places, x, strict=True):
            self._members[name].values[k] = value
        for name in dict.fromkeys(name for name, _ in places):
            self._members[name].fmu.set_inputs()
            self._members[name].fmu.get_outputs()
        return np.array([m.convert.one(k, float(self._world[m.where[k]]))
                         for m, k in ((self._members[n], k) for n, k in places)])  # fmt: skip


def edges(fmus: Mapping[str, Any], sources: dict[str, str]) -> dict[str, set[str]]:
    """Return signal -> signals that depend on it, of inputs and of outputs that feed one."""
    found: dict[str, set[str]] = {target: set() for target in sources}
    for target, source in sources.items():
        if not source.startswith("scenario."):
            found.setdefault(source, set()).add(target)
    for name, fmu in fmus.items():
        taken = {target.partition(".")[2] for target in sources if target.startswith(f"{name}.")}
        for output, inputs in fmu.feedthrough(initial=True).items():
            if f"{name}.{output}" in found:
                for variable in taken & inputs:
                    found[f"{name}.{variable}"].add(f"{name}.{output}")
    return found


def _start(variable: Any) -> float:
    """Return the start value of an input."""
    texts = {"true": 1.0, "false": 0.0}
    text = str(variable.start or 0).lower()
    return texts[text] if text in texts else float(text)
