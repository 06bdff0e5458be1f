"""Filters of the KPIs: a zero-phase Gaussian, and the weighting Wd of ISO 2631-1."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

FILTER_REACH = 4.0  # standard deviations of the Gaussian kept: the tail left is 6e-5
# ISO 2631-1:1997, table A.1, horizontal weighting Wd: corner frequencies [Hz] and quality.
WD_BAND = (0.4, 100.0)
WD_TRANSITION = (2.0, 2.0, 0.63)
WD_RINGS = 20.0  # s; exp(-2π 0.4 Hz t / √2), the slowest part of its response, is 4e-16 by then


def low_pass(values: np.ndarray, step: float, cutoff: float) -> np.ndarray:
    """Filter with a zero-phase Gaussian, −3 dB at `cutoff` [Hz]; `step` [s]; ends held.

    |H(f)| = exp(−(2π f σ)² / 2) with σ = sqrt(ln 2) / (2π cutoff).
    """
    sigma = math.sqrt(math.log(2)) / (2 * math.pi * cutoff) / step
    reach = min(math.ceil(FILTER_REACH * sigma), len(values))
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    padded = np.pad(values, reach, mode="edge")
    return np.convolve(padded, kernel / kernel.sum(), mode="valid")


def power_of_two(least: int) -> int:
    """Return the smallest power of two that is not below `least`, a good length of a spectrum."""
    return 1 << (least - 1).bit_length()


def weighting_d(frequency: np.ndarray) -> np.ndarray:
    """Return the complex response of Wd at frequencies [Hz]: band limits, then transition."""
    s = 2j * math.pi * np.asarray(frequency, dtype=float)
    low, high = (2 * math.pi * f for f in WD_BAND)
    root = math.sqrt(2)
    band = s**2 / (s**2 + root * low * s + low**2)
    band *= high**2 / (s**2 + root * high * s + high**2)
    third, fourth = (2 * math.pi * f for f in WD_TRANSITION[:2])
    quality = WD_TRANSITION[2]
    return band * (1 + s / third) / (1 + s / (quality * fourth) + (s / fourth) ** 2)


def weight_d(values: np.ndarray, step: float) -> np.ndarray:
    """Return an acceleration weighted by Wd, from rest; `step` [s].

    The response is applied to the spectrum of the signal padded with zeros, for so long that none
    of it comes round to the start, and to a power of two: other lengths may take 20 times as long.
    """
    count = power_of_two(len(values) + math.ceil(WD_RINGS / step))
    return np.fft.irfft(np.fft.rfft(values, count) * _response(count, step), count)[: len(values)]


@lru_cache(1)
def _response(count: int, step: float) -> np.ndarray:
    """Return Wd at the frequencies of a spectrum of so many samples: of many runs the same."""
    return weighting_d(np.fft.rfftfreq(count, step))
