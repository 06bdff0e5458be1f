"""One KPI value with what it is taken of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .registry import Kpi


@dataclass(frozen=True)
class Row:
    """A value; None where the formula is undefined there (0 / 0)."""

    kpi: Kpi
    signal: str
    scope: str
    value: float | None
    estimate: str = ""

    def as_dict(self) -> dict[str, Any]:
        """Return the row as `kpis.json` holds it."""
        return {
            "kpi": self.kpi.key, "signal": self.signal, "estimate": self.estimate,
            "scope": self.scope, "value": self.value, "unit": self.kpi.unit,
        }  # fmt: skip


def rms(values: np.ndarray) -> float:
    """Return the root of the mean square of `values`, shape (n,), n ≥ 1."""
    return float(np.sqrt(np.mean(np.square(values))))
