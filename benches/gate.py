"""A measured value, its limit and its verdict."""

from __future__ import annotations

from dataclasses import asdict, dataclass


@dataclass
class Gate:
    """A measured value and its limit."""

    name: str
    value: float
    limit: float
    unit: str = "x"
    at_least: bool = False
    beside: str = ""

    @property
    def passed(self) -> bool:
        """Whether the value keeps the limit."""
        kept = self.value >= self.limit if self.at_least else self.value <= self.limit
        return bool(kept)

    def summary(self) -> dict:
        """Return what `summary.json` holds of it."""
        return asdict(self) | {"value": float(self.value), "passed": self.passed}
