"""A study: one plan of many runs, whether a file or the options of the command line tell it.

Runs are the product of sets of numbers, choices, and axes: scenarios, presets, methods, mappings,
seeds of noise. What a run differs in is told to the verb `run` in words, so that the same words
repeat it.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from ..system.system import Value
from . import sampling
from .sampling import Factor

Words = tuple["str | Path", ...]  # of the command line; files as paths, which a worker moves
LOCAL, DASK = "local", "dask"
TIME_LIMITS = ("--timeout", "--call-timeout")


@dataclass(frozen=True)
class Option:
    """One choice of an axis, and what `run` is told for it."""

    label: Value
    words: Words


@dataclass(frozen=True)
class Axis:
    """Something of which every run has one, e.g. its scenario."""

    name: str
    options: tuple[Option, ...]


@dataclass(frozen=True)
class Shown:
    """A KPI that the report shows; `estimates` empty: all of them."""

    kpi: str
    signal: str
    estimates: tuple[str, ...] = ()
    min: float | None = None
    max: float | None = None

    def shows(self, kpi: str, signal: str, estimate: str) -> bool:
        """Return whether it is about a row of KPIs."""
        return (kpi, signal) == (self.kpi, self.signal) and (
            not self.estimates or estimate in self.estimates
        )


@dataclass(frozen=True)
class Study:
    """A plan; the same plan makes the same runs."""

    name: str
    system: Path
    title: str = ""
    factors: tuple[Factor, ...] = ()
    axes: tuple[Axis, ...] = ()
    settings: Words = ()
    runs: int = 20
    seed: int = 0
    sampling: str = "random"
    engine: str = "fmpy"
    executor: str = LOCAL
    jobs: int = 1
    retries: int = 1
    fmu_dir: Path = Path("target/fmu")
    signals: tuple[str, ...] = ()
    every: float = 0.1
    kpis: tuple[Shown, ...] = ()
    heat: tuple[tuple[str, str], ...] = ()
    file: Path | None = field(default=None, compare=False)

    @property
    def common(self) -> Words:
        """What every run is told."""
        return ("run", self.system, "--fmu-dir", self.fmu_dir, "--engine", self.engine,
                *self.settings)  # fmt: skip

    @property
    def _effective(self) -> Words:
        """What runs are told, without how long they may take: `--resume` may give them longer."""
        pairs = zip(self.settings[::2], self.settings[1::2], strict=True)
        return tuple(word for pair in pairs if pair[0] not in TIME_LIMITS for word in pair)

    def combinations(self) -> Iterator[tuple[dict[str, Value], Words]]:
        """Yield labels by axis, and words, of each combination of the axes' options."""
        for chosen in itertools.product(*(axis.options for axis in self.axes)):
            labels = {a.name: o.label for a, o in zip(self.axes, chosen, strict=True)}
            yield labels, tuple(word for option in chosen for word in option.words)

    def points(self) -> list[dict[str, Value]]:
        """Return the values of the factors, a set per run of each combination."""
        return sampling.points(list(self.factors), self.runs, self.seed, self.sampling)

    def describe(self) -> dict[str, Any]:
        """Return the plan for the report, as JSON has it."""
        return {
            "name": self.name, "title": self.title or self.name, "system": str(self.system),
            "sampling": self.sampling, "runs": self.runs, "seed": self.seed,
            "engine": self.engine, "factors": [asdict(f) for f in self.factors],
            "axes": {a.name: [o.label for o in a.options] for a in self.axes},
            "kpis": [asdict(k) for k in self.kpis], "heat": [list(pair) for pair in self.heat],
            "signals": list(self.signals), "every": self.every,
            "fmuDir": str(self.fmu_dir), "settings": [str(w) for w in self.settings],
        }  # fmt: skip

    def identity(self) -> dict[str, Any]:
        """Return what the rows depend on besides the content of files."""
        axes = {a.name: [[o.label, *map(_name, o.words)] for o in a.options] for a in self.axes}
        drawn = [{**asdict(f), "label": "", "unit": ""} for f in self.factors]
        return {"factors": drawn, "axes": axes, "settings": [_name(w) for w in self._effective],
                "runs": self.runs, "seed": self.seed, "sampling": self.sampling,
                "engine": self.engine, "signals": [*self.signals, self.every]}  # fmt: skip


def _name(word: str | Path) -> str:
    """Return a word; of a file its name, as its content counts, not where it lies."""
    return word.name if isinstance(word, Path) else word
