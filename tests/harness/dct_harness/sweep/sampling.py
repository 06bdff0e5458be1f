"""What a sweep varies, and which values each of its runs has.

COMPONENT.VARIABLE=uniform(LOW,HIGH)                   a number, equally likely in between
COMPONENT.VARIABLE=normal(MEAN,DEVIATION)              a number of a normal distribution
COMPONENT.VARIABLE=lognormal(MEDIAN,SIGMA)             its logarithm has the deviation SIGMA
COMPONENT.VARIABLE=truncated(MEAN,DEVIATION,LOW,HIGH)  normal, cut off at both ends
COMPONENT.VARIABLE=choice(A,B,…)                       each of these, with every set of the numbers
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import ConfigError, did_you_mean
from ..system.system import Value, parse_value
from .distributions import NUMBERS, written

FACTOR = re.compile(r"^(?P<name>[^=]+)=(?P<kind>\w+)\((?P<rest>.*)\)$")
CHOICE = "choice"
KINDS = (*NUMBERS, CHOICE)
METHODS = ("random", "latin-hypercube", "sobol", "saltelli", "grid")
VARY_HELP = f"COMPONENT.VARIABLE={', '.join(map(written, NUMBERS))} or choice(A,B,…)"


@dataclass(frozen=True)
class Factor:
    """One varied quantity; `given` are the numbers of its distribution, or the choices.

    `targets` are the parameters that take its value (none: the one of its name); where it is
    `relative`, each takes its own value times it. `levels`: of a grid; 0: as many as `runs`.
    """

    name: str
    kind: str
    given: tuple[Any, ...]
    targets: tuple[str, ...] = ()
    relative: bool = False
    whole: bool = False
    levels: int = 0
    label: str = ""
    unit: str = ""

    @property
    def parameters(self) -> tuple[str, ...]:
        """Parameters that take the value, as `component.variable`."""
        return self.targets or (self.name,)

    @property
    def is_number(self) -> bool:
        """Whether values are drawn, not chosen."""
        return self.kind != CHOICE

    @property
    def title(self) -> str:
        """Name for people, with its unit."""
        return (self.label or self.name) + (f" [{self.unit}]" if self.unit else "")

    def at(self, u: np.ndarray) -> np.ndarray:
        """Return quantiles; a whole number is the floor of its quantile."""
        found = NUMBERS[self.kind].quantiles(u, self.given)
        return np.floor(found) if self.whole else found


def parse(text: str) -> Factor:
    """Return the factor of a `--vary` option.

    Raises
    ------
    ConfigError
        It says none.
    """
    match = FACTOR.match(text.strip())
    if match is None or match["kind"] not in KINDS:
        hint = did_you_mean(match["kind"], KINDS) if match else ""
        raise ConfigError(f"--vary {text}: write {VARY_HELP}.{hint}")
    parts = [part.strip() for part in match["rest"].split(",")]
    name, kind = match["name"].strip(), match["kind"]
    if kind == CHOICE:
        if not all(parts) or len(set(parts)) < len(parts):
            raise ConfigError(f"--vary {text}: name each choice once")
        return Factor(name, kind, tuple(parse_value(part) for part in parts))
    try:
        numbers = tuple(float(part) for part in parts)
    except ValueError:
        numbers = ()
    if not NUMBERS[kind].takes(numbers):
        raise ConfigError(f"--vary {text}: write {VARY_HELP}; LOW < HIGH, DEVIATION > 0")
    return Factor(name, kind, numbers)


def points(factors: list[Factor], runs: int, seed: int, method: str) -> list[dict[str, Value]]:
    """Return the values of each run: sets of numbers, each with every set of choices.

    A sweep without numbers has each set of choices once. Same arguments, same values.

    Raises
    ------
    ConfigError
        A parameter is varied twice, there is no run, or the method cannot make so many.
    """
    if runs < 1 or seed < 0:
        raise ConfigError(f"--runs {runs} --seed {seed}: needs at least one run, a seed from 0")
    names = [f.name for f in factors]
    twice = next((n for n in names if names.count(n) > 1), None)
    if twice is not None:
        raise ConfigError(f"--vary {twice}: is varied twice; keep one")
    numeric = [f for f in factors if f.is_number]
    choices = [[(f.name, v) for v in f.given] for f in factors if not f.is_number]
    sets = _MAKE[method](numeric, runs, seed) if numeric else [{}]
    return [{**numbers, **dict(chosen)} for numbers in sets
            for chosen in itertools.product(*choices)]  # fmt: skip


def _random(factors: list[Factor], runs: int, seed: int) -> list[dict[str, float]]:
    """Return independent draws; each factor has a stream of its own, and more runs only add."""
    streams = np.random.SeedSequence(seed).spawn(len(factors))
    unit = [np.random.default_rng(stream).random(runs) for stream in streams]
    return _rows(factors, np.column_stack(unit))


def _latin_hypercube(factors: list[Factor], runs: int, seed: int) -> list[dict[str, float]]:
    """Return a sample with one value in each of `runs` equally likely parts of every factor."""
    unit = _qmc().LatinHypercube(len(factors), seed=np.random.default_rng(seed)).random(runs)
    return _rows(factors, unit)


def _sobol(factors: list[Factor], runs: int, seed: int) -> list[dict[str, float]]:
    """Return the beginning of a scrambled Sobol sequence, balanced at powers of two."""
    power = _power(runs, "sobol")
    unit = _qmc().Sobol(len(factors), seed=np.random.default_rng(seed)).random_base2(power)
    return _rows(factors, unit)


def _saltelli(factors: list[Factor], runs: int, seed: int) -> list[dict[str, float]]:
    """Return Saltelli's sample for Sobol indices: `runs` · (factors + 2) sets."""
    _power(runs, "saltelli")
    try:
        from SALib.sample import sobol
    except ImportError as error:
        raise ConfigError("saltelli needs `pip install 'dct-harness[sweep]'`") from error
    problem = {"num_vars": len(factors), "names": [f.name for f in factors],
               "bounds": [[0.0, 1.0]] * len(factors)}  # fmt: skip
    return _rows(factors, sobol.sample(problem, runs, calc_second_order=False, seed=seed))


def _grid(factors: list[Factor], runs: int, seed: int) -> list[dict[str, float]]:
    """Return every combination of levels: evenly from end to end, else by equal probability."""
    return [dict(zip([f.name for f in factors], chosen, strict=True))
            for chosen in itertools.product(*(_levels(f, runs) for f in factors))]  # fmt: skip


def _levels(factor: Factor, runs: int) -> list[float]:
    count = factor.levels or runs
    inner = (np.arange(count) + 0.5) / count
    ends = np.linspace(0.0, 1.0, count) if count > 1 else inner
    found: list[float] = factor.at(ends if factor.kind == "uniform" else inner).tolist()
    return found


def _power(runs: int, method: str) -> int:
    """Return the exponent of a power of two."""
    power = runs.bit_length() - 1
    if runs != 1 << power:
        near = f"{1 << power} or {2 << power}"
        raise ConfigError(f"--runs {runs}: {method} needs a power of two: {near}")
    return power


def _qmc() -> Any:
    try:
        from scipy.stats import qmc
    except ImportError as error:
        raise ConfigError("this sampling needs `pip install 'dct-harness[sweep]'`") from error
    return qmc


def _rows(factors: list[Factor], unit: np.ndarray) -> list[dict[str, float]]:
    """Return values of the factors for places in the unit cube, shape (runs, factors)."""
    columns = [factor.at(unit[:, k]).tolist() for k, factor in enumerate(factors)]
    names = [f.name for f in factors]
    return [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]


_MAKE: dict[str, Callable[[list[Factor], int, int], list[dict[str, float]]]] = {
    "random": _random, "latin-hypercube": _latin_hypercube, "sobol": _sobol,
    "saltelli": _saltelli, "grid": _grid,
}  # fmt: skip
