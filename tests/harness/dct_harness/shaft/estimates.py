"""Stiffness and damping of the drive shaft from a launch, (17)-(18), and what noise does to them.

    T_o = k (θ + θ_0) + c θ',   θ' = ω_c/g − ω_w

`paper`      least squares (18) as printed: θ integrated from the start of the data, no θ_0. Noise
             of the speeds stands in the regressor θ', and draws c towards 0 (attenuation): noise of
             variance s² on a θ' of variance v makes it tend to c v/(v + s²).
`prefilter`  the same on signals through one low-pass. The relation is linear, so it holds between
             filtered signals too, while most of the noise is gone; what is left still attenuates.
`iv`         instrumental variables: β = (ZᵀX)⁻¹ ZᵀT_o, with θ' in Z replaced by the mean of its
             neighbours. White noise of a sample is not in its neighbours: nothing is drawn to 0.

θ_0, the twist at the start of the window, is fitted by the last two: the window may start anywhere.

Standard errors take the noise of speeds and torque as white, and its size from how samples differ
from their neighbours. The noise n of θ' then stands in the residual as −(k h L + c) n, L the
running sum: what θ integrates of it is the larger part, and is not white at all.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from ..errors import ConfigError, instant
from ..kpi.filters import low_pass

METHODS = ("paper", "prefilter", "iv")
CUTOFF = 8.0  # Hz of the prefilter: above the shaft's own 2 Hz, below most of the noise
NEIGHBOURS = 0.02  # s on either side of a sample whose mean is its instrument
LEAST = 20  # samples that a fit needs
EVEN = 1e-3  # of the step: steps that differ by less are one
BLIND = 1e9  # condition of the regressors from which on rounding decides: nothing moves them


@dataclass(frozen=True)
class Estimated:
    """A value with its standard error, in the same unit."""

    value: float
    error: float


@dataclass(frozen=True)
class Window:
    """The rows used: from the first |T_o| ≥ `built_up` [N·m] on for `length` [s]."""

    built_up: float = 20.0
    length: float = 1.0
    start: float = -math.inf  # s, not before


@dataclass(frozen=True)
class Fit:
    """What one method finds: k [N·m/rad], c [N·m·s/rad], R² about the mean, rows, times [s]."""

    method: str
    stiffness: Estimated
    damping: Estimated
    r_squared: float
    samples: int
    start: float
    end: float


def identify(
    time: np.ndarray, rate: np.ndarray, torque: np.ndarray, window: Window, method: str
) -> Fit:
    """Fit the drive shaft.

    Parameters
    ----------
    time
        Instants [s], shape (n,), equidistant.
    rate
        θ' = ω_c/g − ω_w [rad/s], shape (n,).
    torque
        T_o [N·m], shape (n,).
    window
        The rows to use. It must be short: θ integrates every offset of the speeds.
    method
        One of `METHODS`.

    Raises
    ------
    ConfigError
        Steps differ, T_o does not build up, the window holds too few rows, or its speeds or torque
        stand still.
    """
    step = _step(time)
    inside = _rows(time, torque, window)
    noise = (_white(rate), _white(torque))
    through = partial(low_pass, step=step, cutoff=CUTOFF) if method == "prefilter" else np.copy
    rate, torque = through(rate), through(torque)
    x = _regressors(rate, step, offset=method != "paper")
    z = x * inside[:, None]
    if method == "iv":
        z[inside, 1] = _neighbours(rate, max(1, round(NEIGHBOURS / step)))[inside]
    _check_moves(x[inside], torque[inside], time[inside])
    inverse = np.linalg.inv(z.T @ x)
    beta = inverse @ z.T @ torque
    errors = _errors(inverse @ z.T, beta, noise, step, through)
    k, c = (Estimated(float(b), float(e)) for b, e in zip(beta[:2], errors[:2], strict=True))
    share = _explained(torque[inside], (x @ beta)[inside])
    first, last = time[inside][[0, -1]].tolist()
    return Fit(method, k, c, share, int(inside.sum()), first, last)


def _explained(torque: np.ndarray, fitted: np.ndarray) -> float:
    """Return R² about the mean."""
    residual, total = torque - fitted, torque - torque.mean()
    return 1 - float(residual @ residual / (total @ total))


def _regressors(rate: np.ndarray, step: float, offset: bool) -> np.ndarray:
    """Return the columns θ, θ' and, with an offset, 1."""
    twist = np.concatenate([[0.0], np.cumsum(step * (rate[1:] + rate[:-1]) / 2)])
    ones = [np.ones_like(twist)] if offset else []
    return np.column_stack([twist, rate, *ones])


def _step(time: np.ndarray) -> float:
    steps = np.diff(time)
    step = float(np.median(steps)) if len(steps) else 0.0
    if len(time) < LEAST:
        raise ConfigError(f"the data have {len(time)} rows; a fit needs {LEAST}")
    others = np.flatnonzero(np.abs(steps - step) > EVEN * step)
    if others.size:
        k, usual = others[0], instant(step)
        raise ConfigError(
            f"after t = {instant(time[k])} s comes a step of {instant(steps[k])} s, most are "
            f"{usual} s; give --step {usual} to resample"
        )
    return step


def _check_moves(x: np.ndarray, torque: np.ndarray, time: np.ndarray) -> None:
    """Refuse rows in which nothing moves that stiffness and damping could be seen by."""
    span = f"from t = {instant(time[0])} s to {instant(time[-1])} s"
    if not np.ptp(torque):
        raise ConfigError(f"the torque stays {torque[0]:g} N·m {span}: nothing to find")
    sizes = np.sqrt(np.square(x).sum(axis=0))
    if not sizes.all() or np.linalg.cond(x / sizes) > BLIND:
        raise ConfigError(
            f"the speeds show no twist of the shaft that changes {span}; check the speed signals, "
            "or take another --start"
        )


def _rows(time: np.ndarray, torque: np.ndarray, window: Window) -> np.ndarray:
    """Return the rows of the window, shape (n,)."""
    built_up = (np.abs(torque) >= window.built_up) & (time >= window.start)
    if not built_up.any():
        late = np.abs(torque[time >= window.start])
        there = f"but {late.max():.4g} at most" if late.size else "for no row is that late"
        raise ConfigError(
            f"|T_o| never reaches {window.built_up:g} N·m, {there}: take data of a launch, say the "
            "unit where it is kN·m, or take another --built-up or --start"
        )
    first = time[np.argmax(built_up)]
    inside = built_up & (time <= first + window.length)
    if inside.sum() < LEAST:
        raise ConfigError(
            f"only {inside.sum()} rows of {LEAST} from t = {first:g} s on, as they are "
            f"{instant(np.median(np.diff(time)))} s apart; take a longer --length, or say the unit "
            "of the time where it is ms"
        )
    return inside


def _neighbours(values: np.ndarray, reach: int) -> np.ndarray:
    """Return the mean of the `reach` samples on either side of each, itself left out."""
    kernel = np.ones(2 * reach + 1)
    kernel[reach] = 0.0
    return np.convolve(np.pad(values, reach, mode="edge"), kernel / kernel.sum(), mode="valid")


def _white(values: np.ndarray) -> float:
    """Return the variance of white noise, from a sample less the mean of its two neighbours."""
    return float(np.mean(np.square(values - _neighbours(values, 1))[1:-1]) / 1.5)


def _errors(
    weights: np.ndarray,
    beta: np.ndarray,
    noise: tuple[float, float],
    step: float,
    through: Callable[[np.ndarray], np.ndarray],
) -> np.ndarray:
    """Return the standard errors of β = weights @ T_o, shape (parameters,).

    `noise`: variances of θ' and T_o, before the low-pass `through`.
    """
    running = np.cumsum(weights[:, ::-1], axis=1)[:, ::-1]  # transposed running sum
    of_rate = [through(row) for row in beta[0] * step * running + beta[1] * weights]
    of_torque = [through(row) for row in weights]
    parts = zip(noise, (np.array(of_rate), np.array(of_torque)), strict=True)
    return np.sqrt(sum(v * np.square(rows).sum(axis=1) for v, rows in parts))
