"""Figures of a study as numbers: shares, curves over a factor, heat maps, sensitivities, bands."""

from __future__ import annotations

import importlib
import math
from dataclasses import dataclass
from itertools import pairwise
from statistics import NormalDist
from typing import Any

import numpy as np

from ..errors import ConfigError
from .study_data import Json, Series, Shown, StudyData

BINS = 8  # of a factor, equally full
CELLS = 6  # of a heat map, each way, equally wide
LEAST = 3  # runs in a cell whose median is told
CONFIDENCE = 0.95
RESAMPLES = 200
SEED = 1  # of the resamples; SALib takes 0 for none
INDICES = ("S1", "S1_conf", "ST", "ST_conf")
ENOUGH = 64  # runs for sensitivities of a sample that was not made for them


def summary(shown: Shown, series: Series) -> Json:
    """Return median, 95 % quantile, worst value, and the share of runs of use."""
    known = series.values[np.isfinite(series.values)]
    worst = series.values[shown.worst_first(series.values)[0]]
    bounded = shown.limit is not None
    return {
        "label": series.label, "place": series.place, "runs": len(known),
        "median": float(np.median(known)), "high": float(np.quantile(known, 0.95)),
        "worst": float(worst), "share": float(shown.keeps(known).mean()) if bounded else None,
    }  # fmt: skip


def _bins(x: np.ndarray, y: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return x and y in equally full bins of x; runs without a value are left out."""
    good = np.isfinite(y)
    order = np.argsort(x[good], kind="stable")
    parts = np.array_split(order, min(BINS, max(1, len(order) // LEAST)))
    return [(x[good][p], y[good][p]) for p in parts]


def curve(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return median of x, and of y, in equally full bins of x."""
    bins = _bins(x, y)
    return (np.array([np.median(x) for x, _ in bins]), np.array([np.median(y) for _, y in bins]))


def sides(shown: Shown, x: np.ndarray, y: np.ndarray) -> list[tuple[float, bool | None]]:
    """Return median of x, and whether the median of y keeps the limit, of each bin; None: unsure.

    A bin is sure where both ends of the 95 % confidence interval of its median are on one side: the
    values of ranks n/2 ± 0.98 √n, between which the median lies by the binomial distribution.
    """
    found = []
    for place, values in _bins(x, y):
        count = len(values)
        reach = NormalDist().inv_cdf((1 + CONFIDENCE) / 2) * count**0.5 / 2
        ranks = np.clip([np.floor(count / 2 - reach), np.ceil(count / 2 + reach)], 0, count - 1)
        kept = shown.keeps(np.sort(values)[ranks.astype(int)])
        sure = kept.all() or not kept.any()
        found.append((float(np.median(place)), bool(kept[0]) if sure else None))
    return found


def crossing(shown: Shown, x: np.ndarray, y: np.ndarray) -> str:
    """Return in words between which values of x the median of y passes the limit."""
    if shown.limit is None:
        return ""
    bins = sides(shown, x, y)
    sure = [side for side in bins if side[1] is not None]
    spans = [span(one, other) for (one, before), (other, after) in pairwise(sure)
             if before != after]  # fmt: skip
    if spans:
        return ", ".join(spans)
    if 2 * len(sure) < len(bins):
        return "at the limit"
    return "never" if sure[0][1] else "everywhere"


def span(low: float, high: float) -> str:
    """Return an interval with as many digits as make its width two units at least."""
    digits = max(0, math.ceil(-math.log10((high - low) / 2)))
    return f"{low:.{digits}f} to {high:.{digits}f}"


@dataclass(frozen=True)
class Heat:
    """Medians over two factors, shape (cells, cells), rows along the second; NaN: too few runs."""

    x: np.ndarray
    y: np.ndarray
    medians: np.ndarray


def heat(x: np.ndarray, y: np.ndarray, values: np.ndarray) -> Heat:
    """Return medians in equally wide cells; of a grid one cell per level."""
    edges = [_edges(v) for v in (x, y)]
    place = [np.clip(np.searchsorted(e, v, side="right") - 1, 0, len(e) - 2)
             for e, v in zip(edges, (x, y), strict=True)]  # fmt: skip
    medians = np.full((len(edges[1]) - 1, len(edges[0]) - 1), np.nan)
    gridded = all(len(np.unique(v)) <= CELLS for v in (x, y))
    for row, column in np.ndindex(medians.shape):
        inside = values[(place[0] == column) & (place[1] == row) & np.isfinite(values)]
        if len(inside) >= (1 if gridded else LEAST):
            medians[row, column] = np.median(inside)
    return Heat(edges[0], edges[1], medians)


def _edges(values: np.ndarray) -> np.ndarray:
    levels = np.unique(values)
    if 1 < len(levels) <= CELLS:
        middle = (levels[:-1] + levels[1:]) / 2
        return np.concatenate([[2 * levels[0] - middle[0]], middle, [2 * levels[-1] - middle[-1]]])
    low, high = float(values.min()), float(values.max())
    return np.linspace(low, high if high > low else low + 1.0, CELLS + 1)


@dataclass(frozen=True)
class Sensitivity:
    """Share of the variance by each factor, with the half width of its confidence interval.

    `total` counts what a factor does together with others; None where the sample cannot tell.
    """

    first: np.ndarray
    first_conf: np.ndarray
    total: np.ndarray | None
    total_conf: np.ndarray | None
    runs: int


def sensitivity(data: StudyData, series: Series) -> Sensitivity | None:
    """Return Sobol indices; None where there are too few runs or nothing varies.

    Of Saltelli's sample those of first and total order; of another random sample the first order,
    from the data as they are (RBD-FAST: Plischke, Reliab. Eng. Syst. Saf. 95, 2010).
    """
    count = len(data.factors)
    if count < 2 or np.nanstd(series.values) == 0:
        return None
    problem = {"num_vars": count, "names": [f["name"] for f in data.factors],
               "bounds": [_range(column) for column in data.drawn().T]}  # fmt: skip
    if data.plan["sampling"] == "saltelli":
        return _sobol(problem, _blocks(data, series))
    if data.plan["sampling"] == "grid":
        return None
    good = np.isfinite(series.values)
    return _given(problem, data.drawn()[series.rows][good], series.values[good])


def _range(column: np.ndarray) -> list[float]:
    return [float(column.min()), float(column.max()) or 1.0]


def _blocks(data: StudyData, series: Series) -> np.ndarray:
    """Return the values of whole blocks of factors + 2 runs; a block with a failure is left out.

    A run's place in its block follows from its number, so that a sweep that was cut has blocks too.
    """
    size = len(data.factors) + 2
    numbers = np.array([data.rows[k]["run"] for k in series.rows]) - 1
    per = _choices(data)
    place = (numbers // per) % (size * data.plan["runs"])
    known = dict(zip(place.tolist(), series.values.tolist(), strict=True))
    table = np.array([[known.get(b * size + k, np.nan) for k in range(size)]
                      for b in range(data.plan["runs"])])  # fmt: skip
    return table[np.isfinite(table).all(axis=1)]


def _choices(data: StudyData) -> int:
    """Return how many runs follow each other with the same numbers: the sets of choices."""
    sizes = [len(f["given"]) for f in data.plan["factors"] if f["kind"] == "choice"]
    return int(np.prod(sizes, dtype=int))


def _sobol(problem: Json, blocks: np.ndarray) -> Sensitivity | None:
    if len(blocks) < 2 or blocks.std() == 0:
        return None
    found = _salib("sobol").analyze(
        problem, blocks.ravel(), calc_second_order=False, num_resamples=RESAMPLES,
        conf_level=CONFIDENCE, seed=SEED)  # fmt: skip
    first, first_conf, total, total_conf = (np.asarray(found[k]) for k in INDICES)
    return Sensitivity(first, first_conf, total, total_conf, blocks.size)


def _given(problem: Json, x: np.ndarray, y: np.ndarray) -> Sensitivity | None:
    if len(y) < ENOUGH:
        return None
    found = _salib("rbd_fast").analyze(problem, x, y, num_resamples=RESAMPLES,
                                       conf_level=CONFIDENCE, seed=SEED)  # fmt: skip
    return Sensitivity(np.asarray(found["S1"]), np.asarray(found["S1_conf"]), None, None, len(y))


def _salib(name: str) -> Any:
    try:
        return importlib.import_module(f"SALib.analyze.{name}")
    except ImportError as error:
        raise ConfigError("sensitivities need `pip install 'dct-harness[sweep]'`") from error


def bands(values: np.ndarray) -> np.ndarray:
    """Return the 5, 25, 50, 75 and 95 % quantiles over runs, shape (5, samples)."""
    found: np.ndarray = np.quantile(values, [0.05, 0.25, 0.5, 0.75, 0.95], axis=0)
    return found
