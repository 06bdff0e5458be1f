"""White noise of sensors: what other components read of an output, while the output stays true.

The samples are columns of the scenario vector, `scenario.noise.COMPONENT.VARIABLE`, in the unit of
the output; a value is read with its noise before it is converted. Every signal has a stream of its
own, made of the seed and its name: another signal more does not change it.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..errors import ConfigError, did_you_mean
from ..system.system import NOISE, System
from ..system.transforms import Conversion, Transform

COLUMN = f"scenario.{NOISE}."


class Noise:
    """The noise of one run: `names` of the noisy outputs that somebody reads, `columns` of it."""

    def __init__(self, system: System, sources: dict[str, str], kinds: Mapping[str, str]) -> None:
        """`kinds`: Real, Integer or Boolean of every output.

        Raises
        ------
        ConfigError
            There is no such real output, or inputs have slopes.
        """
        for name, deviation in system.noise.items():
            if kinds.get(name) != "Real":
                real = [n for n, kind in kinds.items() if kind == "Real"]
                raise ConfigError(f"{system.at(NOISE, name)}: {NOISE}: '{name}' is no real output."
                                  f"{did_you_mean(name, real)}")  # fmt: skip
            if deviation and system.interpolate:
                raise ConfigError(f"{system.at(NOISE, name)}: {NOISE}: white noise has no slopes; "
                                  "leave interpolate out")  # fmt: skip
        read = set(sources.values())
        self.deviations = {n: d for n, d in system.noise.items() if d and n in read}
        self.names = list(self.deviations)
        self.columns = [COLUMN + name for name in self.names]
        self._seed = system.seed

    def samples(self, count: int) -> np.ndarray:
        """Return the noise of each signal, shape (count, signals)."""
        found = np.empty((count, len(self.names)))
        for k, (name, deviation) in enumerate(self.deviations.items()):
            stream = np.random.SeedSequence([self._seed, *name.encode()])
            found[:, k] = deviation * np.random.default_rng(stream).standard_normal(count)
        return found

    def reads(self, source: str) -> str | None:
        """Return the column of an input's source; None where it is read as it is."""
        return COLUMN + source if source in self.deviations else None

    def conversion(
        self, component: str, names: list[str], transforms: dict[str, Transform],
        sources: dict[str, str], world: np.ndarray, index: dict[str, int],
    ) -> Conversion:  # fmt: skip
        """Return what changes the values of a component's inputs on their way."""
        read = ((k, self.reads(sources[f"{component}.{n}"])) for k, n in enumerate(names))
        noisy = {k: index[column] for k, column in read if column is not None}
        if not noisy:
            return Conversion(component, names, transforms)
        return Noisy(component, names, transforms, world, noisy)


class Noisy(Conversion):
    """As `Conversion`, with noise before it."""

    def __init__(
        self, component: str, names: list[str], transforms: dict[str, Transform],
        world: np.ndarray, noisy: dict[int, int],
    ) -> None:  # fmt: skip
        """`noisy`: input -> place of its noise in the world."""
        super().__init__(component, names, transforms)
        self.needed = True
        self._world, self._noisy = world, noisy
        self._inputs = np.array(list(noisy), dtype=np.intp)
        self._columns = np.array(list(noisy.values()), dtype=np.intp)

    def one(self, k: int, value: float) -> float:
        """Return the converted value of input `k` with its noise."""
        if k in self._noisy:
            value += float(self._world[self._noisy[k]])
        return super().one(k, value)

    def __call__(self, values: np.ndarray) -> None:
        """Add the noise, then convert."""
        values[self._inputs] += self._world[self._columns]
        super().__call__(values)
