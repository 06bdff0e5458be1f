"""Rows of a study as columns: factors, axes, and the KPIs to show as one line per estimate."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import ConfigError
from ..kpi import registry
from ..kpi.registry import Kpi
from ..results import read_json
from ..sweep.store import GOOD, PLAN, course_file, read_rows

Json = dict[str, Any]
AGAIN = "make it again with `dct-harness sweep`"
POOLED = ("noise seed",)  # axes whose runs are shown together
USUAL = (registry.PERCENT.key, registry.TRACKING.key, registry.RMSE.key)
PLAIN = ("run", "verdict", "error", "command")


@dataclass(frozen=True)
class Series:
    """One estimate in one choice of every axis: its runs, and KPIs (NaN where there is none)."""

    label: str
    estimate: str
    rows: np.ndarray
    values: np.ndarray
    place: int  # in the order of colours


@dataclass(frozen=True)
class Shown:
    """A KPI with its series; `low` and `high` bound what is of use."""

    kpi: Kpi
    signal: str
    low: float | None
    high: float | None
    series: list[Series]

    @property
    def slug(self) -> str:
        """Part of a name in the page."""
        return f"{self.kpi.key}-{self.signal}".replace(".", "-")

    @property
    def limit(self) -> float | None:
        """The one bound that matters, else None."""
        return self.high if self.high is not None else self.low

    def keeps(self, values: np.ndarray) -> np.ndarray:
        """Return whether values are within the bounds."""
        low = -np.inf if self.low is None else self.low
        high = np.inf if self.high is None else self.high
        found: np.ndarray = (values >= low) & (values <= high)
        return found

    def worst_first(self, values: np.ndarray) -> np.ndarray:
        """Return indices from the worst value on, those without a value left out."""
        order = np.argsort(values if self.low is not None and self.high is None else -values)
        found: np.ndarray = order[np.isfinite(values[order])]
        return found


class StudyData:
    """The plan of a study and its rows; courses lie in its folder."""

    def __init__(self, plan: Json, rows: list[Json], folder: Path) -> None:
        self.plan, self.rows, self.folder = plan, rows, folder

    @classmethod
    def read(cls, folder: Path) -> StudyData:
        """Read the folder of a sweep.

        Raises
        ------
        ConfigError
            It holds no study with rows.
        """
        plan: Json = read_json(folder / PLAN, AGAIN)
        rows = [row for _, row in sorted(read_rows(folder).items())]
        if not rows:
            raise ConfigError(f"{folder}: holds no run yet; make them with `dct-harness sweep`")
        return cls(plan, rows, folder)

    @property
    def factors(self) -> list[Json]:
        """Factors that are numbers."""
        return [f for f in self.plan["factors"] if f["kind"] != "choice"]

    @cached_property
    def axes(self) -> list[str]:
        """What sorts runs into series: axes and choices."""
        chosen = [f["name"] for f in self.plan["factors"] if f["kind"] == "choice"]
        return [a for a in self.plan["axes"] if a not in POOLED] + chosen

    @property
    def failed(self) -> list[Json]:
        """Rows of runs that did not reach their end."""
        return [row for row in self.rows if row["verdict"] not in GOOD]

    def column(self, name: str) -> np.ndarray:
        """Return numbers of all runs, NaN where a run has none, shape (runs,)."""
        return np.array([np.nan if (v := row.get(name)) is None else float(v) for row in self.rows])

    def factor(self, name: str) -> Json:
        """Return a factor by its name."""
        return next(f for f in self.factors if f["name"] == name)

    def drawn(self) -> np.ndarray:
        """Return the numbers of all factors, shape (runs, factors)."""
        return np.column_stack([self.column(f["name"]) for f in self.factors])

    @cached_property
    def shown(self) -> list[Shown]:
        """The KPIs that the plan shows, else the usual ones, as far as there are values."""
        told = self.plan["kpis"] or self._usual()
        made = (self._shown(given) for given in told)
        return [shown for shown in made if shown.series]

    def _usual(self) -> list[Json]:
        names = dict.fromkeys(name for row in self.rows for name in row if "/" in name)
        split = [name.split("/") for name in names]
        for key in USUAL:
            signals = dict.fromkeys(s for k, s, *_ in split if k == key)
            if signals:
                return [{"kpi": key, "signal": s, "estimates": [], "min": None, "max": None}
                        for s in signals]  # fmt: skip
        return []

    def _shown(self, given: Json) -> Shown:
        head = f"{given['kpi']}/{given['signal']}"
        names = dict.fromkeys(n for row in self.rows for n in row)
        told = [n for n in names if n == head or n.startswith(f"{head}/")]
        estimates = given["estimates"] or [n[len(head) + 1 :] for n in told]
        found: list[Series] = []
        for labels, mask in self._groups():
            for estimate in estimates:
                values = self.column(f"{head}/{estimate}" if estimate else head)[mask]
                if np.isfinite(values).any():
                    words = [*map(str, labels), *([estimate] if len(estimates) > 1 else [])]
                    label = " · ".join(words) or estimate or given["signal"]
                    found.append(Series(label, estimate, np.flatnonzero(mask), values, len(found)))
        return Shown(registry.BY_KEY[given["kpi"]], given["signal"], given["min"], given["max"],
                     found)  # fmt: skip

    def _groups(self) -> list[tuple[tuple[Any, ...], np.ndarray]]:
        """Return what sorts runs into series, and the runs of each."""
        keys = [tuple(row.get(a) for a in self.axes) for row in self.rows]
        return [(key, np.array([k == key for k in keys])) for key in dict.fromkeys(keys)]

    def courses(self, limit: int) -> tuple[np.ndarray, list[str], np.ndarray]:
        """Return run indices, signals with `time` first, and values (runs, samples, signals).

        Of more runs than `limit` some, evenly chosen. Runs of another length than the first are
        left out, and so are those without courses.
        """
        from pyarrow import parquet

        there = [k for k, row in enumerate(self.rows)
                 if course_file(self.folder, row["run"]).is_file()]  # fmt: skip
        chosen = there[:: max(1, -(-len(there) // limit))]
        found, names, tables = list[int](), list[str](), list[np.ndarray]()
        for k in chosen:
            table = parquet.read_table(course_file(self.folder, self.rows[k]["run"]))
            names = names or table.column_names
            values = np.column_stack([table[n].to_numpy() for n in names])
            if not tables or values.shape == tables[0].shape:
                found.append(k)
                tables.append(values)
        return np.array(found, dtype=int), names, np.array(tables)


def pairs(plan: Json) -> list[tuple[str, str]]:
    """Return pairs of factors for heat maps: those of the plan, else the first two."""
    numbers = [f["name"] for f in plan["factors"] if f["kind"] != "choice"]
    told = [(a, b) for a, b in plan["heat"]]
    return told or list(itertools.islice(itertools.combinations(numbers, 2), 1))
