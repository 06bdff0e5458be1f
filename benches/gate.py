"""A measured value, its limit and its verdict; or one that is only told."""

from __future__ import annotations

from dataclasses import asdict, dataclass


@dataclass
class Gate:
    """A measured value and its limit; without one it is not judged."""

    name: str
    value: float
    limit: float | None
    unit: str = "x"
    at_least: bool = False
    beside: str = ""

    @property
    def passed(self) -> bool:
        """Whether the value keeps the limit."""
        if self.limit is None:
            return True
        kept = self.value >= self.limit if self.at_least else self.value <= self.limit
        return bool(kept)

    def summary(self) -> dict:
        """Return what `summary.json` holds of it."""
        return asdict(self) | {"value": float(self.value), "passed": self.passed}
