"""What a connection does to a value on its way: unit, linear transformation, table."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..errors import FmuRuntimeError


@dataclass(frozen=True)
class Transform:
    """target = factor * source + offset, or `table`: source -> target."""

    factor: float = 1.0
    offset: float = 0.0
    table: dict[float, float] = field(default_factory=dict)

    def after(self, a: float, b: float) -> Transform:
        """Return the transform of a * source + b."""
        if (a, b) == (1.0, 0.0):
            return self
        return Transform(self.factor * a, self.factor * b + self.offset, self.table)

    def then(self, other: Transform) -> Transform:
        """Return this transform followed by another one.

        Raises
        ------
        ValueError
            A table has no rows for values that a line gives.
        """
        if self.table:
            return Transform(table={k: other.at(v) for k, v in self.table.items()})
        if not other.table:
            return other.after(self.factor, self.offset)
        if self.changes:
            raise ValueError("a table cannot follow a factor or an offset")
        return other

    def at(self, value: float) -> float:
        """Return the target's value for one of the source's."""
        if not self.table:
            return self.factor * value + self.offset
        if value not in self.table:
            raise ValueError(f"{value:g} is in no row of a table")
        return self.table[value]

    @property
    def changes(self) -> bool:
        """Whether it does anything."""
        return bool(self.table) or (self.factor, self.offset) != (1.0, 0.0)

    def as_dict(self) -> dict[str, Any]:
        """Return what differs from leaving a value alone, for `run.json`."""
        line = {"factor": self.factor, "offset": self.offset}
        table = {"table": [list(row) for row in self.table.items()]} if self.table else {}
        return table or (line if self.changes else {})


class Conversion:
    """Applies the transforms of one component's inputs in place."""

    def __init__(self, component: str, names: list[str], by_target: dict[str, Transform]) -> None:
        found = [by_target.get(f"{component}.{n}", Transform()) for n in names]
        self._factor = np.array([t.factor for t in found])
        self._offset = np.array([t.offset for t in found])
        self._tables = [(k, f"{component}.{names[k]}", t.table)
                        for k, t in enumerate(found) if t.table]  # fmt: skip
        self.needed = any(t.changes for t in found)

    def one(self, k: int, value: float) -> float:
        """Return the converted value of input `k`; raises FmuRuntimeError as a call does."""
        for j, name, table in self._tables:
            if j == k:
                if value not in table:
                    raise FmuRuntimeError(f"{name}: {value:g} is in no row of its mapping")
                return table[value]
        return float(value * self._factor[k] + self._offset[k])

    def slopes(self, values: np.ndarray) -> None:
        """Convert time derivatives of inputs in place; what a table codes has none."""
        values *= self._factor
        for k, _, _ in self._tables:
            values[k] = 0.0

    def __call__(self, values: np.ndarray) -> None:
        """Convert the inputs; raises FmuRuntimeError where a table has no row."""
        for k, name, table in self._tables:
            if float(values[k]) not in table:
                raise FmuRuntimeError(f"{name}: {values[k]:g} is in no row of its mapping")
        codes = [(k, table[float(values[k])]) for k, _, table in self._tables]
        values *= self._factor
        values += self._offset
        for k, code in codes:
            values[k] = code
