"""What a sweep varies, and which values each of its runs has.

COMPONENT.VARIABLE=uniform(LOW,HIGH)       a number, equally likely in between
COMPONENT.VARIABLE=normal(MEAN,DEVIATION)  a number of a normal distribution
COMPONENT.VARIABLE=choice(A,B,…)           each of these, with every set of the numbers
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from .errors import ConfigError, did_you_mean
from .system import Value, parse_value

FACTOR = re.compile(r"^(?P<name>[^=]+)=(?P<kind>\w+)\((?P<rest>.*)\)$")
KINDS = ("uniform", "normal", "choice")
METHODS = ("random", "latin-hypercube", "sobol")
VARY_HELP = "COMPONENT.VARIABLE=uniform(LOW,HIGH), normal(MEAN,DEVIATION) or choice(A,B,…)"


@dataclass(frozen=True)
class Factor:
    """One varied parameter; `given` are the two numbers of a distribution, or the choices."""

    name: str
    kind: str
    given: tuple[Any, ...]


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
    if kind == "choice":
        if not all(parts) or len(set(parts)) < len(parts):
            raise ConfigError(f"--vary {text}: name each choice once")
        return Factor(name, kind, tuple(parse_value(part) for part in parts))
    return Factor(name, kind, _numbers(text, kind, parts))


def _numbers(text: str, kind: str, parts: list[str]) -> tuple[float, float]:
    try:
        a, b = (float(part) for part in parts)
    except ValueError:
        a = b = np.nan
    if not np.isfinite([a, b]).all() or b < (a if kind == "uniform" else 0.0):
        raise ConfigError(f"--vary {text}: write {VARY_HELP}")
    return a, b


def points(factors: list[Factor], runs: int, seed: int, method: str) -> list[dict[str, Value]]:
    """Return the values of each run: `runs` sets of numbers, each with every set of choices.

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
    numeric = [f for f in factors if f.kind != "choice"]
    choices = [[(f.name, v) for v in f.given] for f in factors if f.kind == "choice"]
    sets = _MAKE[method](numeric, runs, seed) if numeric else [{}]
    return [{**numbers, **dict(chosen)} for numbers in sets
            for chosen in itertools.product(*choices)]  # fmt: skip


def _random(factors: list[Factor], runs: int, seed: int) -> list[dict[str, float]]:
    """Return independent draws; each factor has a stream of its own, and more runs only add."""
    streams = np.random.SeedSequence(seed).spawn(len(factors))
    columns = []
    for factor, stream in zip(factors, streams, strict=True):
        generator = np.random.default_rng(stream)
        draw = generator.uniform if factor.kind == "uniform" else generator.normal
        a, b = factor.given
        columns.append(draw(a, b, runs))
    return _rows(factors, np.column_stack(columns))


def _latin_hypercube(factors: list[Factor], runs: int, seed: int) -> list[dict[str, float]]:
    """Return a sample with one value in each of `runs` equally likely parts of every factor."""
    qmc = _scipy()[0]
    unit = qmc.LatinHypercube(len(factors), seed=np.random.default_rng(seed)).random(runs)
    return _rows(factors, _stretched(factors, unit))


def _sobol(factors: list[Factor], runs: int, seed: int) -> list[dict[str, float]]:
    """Return the beginning of a scrambled Sobol sequence, balanced at powers of two."""
    power = runs.bit_length() - 1
    if runs != 1 << power:
        near = f"{1 << power} or {2 << power}"
        raise ConfigError(f"--runs {runs}: sobol needs a power of two: {near}")
    qmc = _scipy()[0]
    unit = qmc.Sobol(len(factors), seed=np.random.default_rng(seed)).random_base2(power)
    return _rows(factors, _stretched(factors, unit))


def _scipy() -> tuple[Any, Any]:
    try:
        from scipy import special
        from scipy.stats import qmc
    except ImportError as error:
        raise ConfigError("this sampling needs `pip install 'dct-harness[sweep]'`") from error
    return qmc, special


def _stretched(factors: list[Factor], unit: np.ndarray) -> np.ndarray:
    """Return values of the factors for places in the unit cube, shape (runs, factors)."""
    found = np.empty_like(unit)
    for k, factor in enumerate(factors):
        a, b = factor.given
        uniform = factor.kind == "uniform"
        found[:, k] = a + b * _scipy()[1].ndtri(unit[:, k]) if not uniform else (
            a + (b - a) * unit[:, k])  # fmt: skip
    return found


def _rows(factors: list[Factor], values: np.ndarray) -> list[dict[str, float]]:
    names = [f.name for f in factors]
    return [dict(zip(names, map(float, row), strict=True)) for row in values]


_MAKE: dict[str, Callable[[list[Factor], int, int], list[dict[str, float]]]] = {
    "random": _random, "latin-hypercube": _latin_hypercube, "sobol": _sobol,
}  # fmt: skip
