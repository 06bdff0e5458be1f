"""Distributions of a varied number: what each is given, and its quantiles."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import ConfigError

Quantiles = Callable[[np.ndarray, Sequence[float]], np.ndarray]


@dataclass(frozen=True)
class Distribution:
    """`given` names its numbers, `fits` says whether they make sense, `quantiles` inverts it."""

    given: tuple[str, ...]
    fits: Callable[[Sequence[float]], bool]
    quantiles: Quantiles

    def takes(self, numbers: Sequence[float]) -> bool:
        """Return whether these are numbers of such a distribution."""
        right = len(numbers) == len(self.given) and bool(np.isfinite(numbers).all())
        return right and self.fits(numbers)


def special() -> Any:
    """Return scipy.special.

    Raises
    ------
    ConfigError
        SciPy is not installed.
    """
    try:
        from scipy import special as found
    except ImportError as error:
        raise ConfigError("this sampling needs `pip install 'dct-harness[sweep]'`") from error
    return found


def _uniform(u: np.ndarray, given: Sequence[float]) -> np.ndarray:
    low, high = given
    return low + (high - low) * u


def _normal(u: np.ndarray, given: Sequence[float]) -> np.ndarray:
    mean, deviation = given
    return np.asarray(mean + deviation * special().ndtri(u))


def _lognormal(u: np.ndarray, given: Sequence[float]) -> np.ndarray:
    median, sigma = given
    return np.asarray(median * np.exp(sigma * special().ndtri(u)))


def _truncated(u: np.ndarray, given: Sequence[float]) -> np.ndarray:
    mean, deviation, low, high = given
    first, last = (special().ndtr((bound - mean) / deviation) for bound in (low, high))
    inside = mean + deviation * special().ndtri(first + (last - first) * u)
    return np.clip(inside, low, high)


NUMBERS = {
    "uniform": Distribution(("LOW", "HIGH"), lambda g: g[0] <= g[1], _uniform),
    "normal": Distribution(("MEAN", "DEVIATION"), lambda g: g[1] >= 0, _normal),
    "lognormal": Distribution(
        ("MEDIAN", "SIGMA"), lambda g: g[0] > 0 and g[1] >= 0, _lognormal),
    "truncated": Distribution(
        ("MEAN", "DEVIATION", "LOW", "HIGH"),
        lambda g: g[1] > 0 and g[2] < g[3] and abs(g[2] + g[3] - 2 * g[0]) < 16 * g[1], _truncated),
}  # fmt: skip


def written(kind: str) -> str:
    """Return how a distribution is written, e.g. `uniform(LOW,HIGH)`."""
    return f"{kind}({','.join(NUMBERS[kind].given)})"
