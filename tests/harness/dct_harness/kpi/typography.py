"""Numbers and units as people read them: minus signs, powers of ten, units, digits that tell."""

from __future__ import annotations

import math
import re

from .table import UNDEFINED, number

RAISED = str.maketrans("-.0123456789", "⁻·⁰¹²³⁴⁵⁶⁷⁸⁹", "^")
NEGATIVE = re.compile(r"(?<![\w.])-(?=\.?\d)")
POWER = re.compile(r"(?<=[a-zA-Z])\^?-?\d+(?:\.\d+)?")
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[-+]\d+)?(?![\w.])")
PRINTED = {"1": "", "degC": "°C", "deg": "°"}
TOLD = 2  # digits of what changed
PLAIN = (-4, 7)  # decimal exponents from and up to which numbers need no power of ten


def minus(text: str) -> str:
    """Return a text whose negative numbers have a minus sign, ``−3 %``."""
    return NEGATIVE.sub("−", text)


def unit(name: str) -> str:
    """Return an FMI unit as people print it: ``kg.m2`` is kg·m², ``1`` is nothing."""
    if name in PRINTED:
        return PRINTED[name]
    return POWER.sub(lambda power: power[0].translate(RAISED), name).replace(".", "·")


def figure(value: float | None, digits: int) -> str:
    """Return a value with so many significant digits, ``−0.012``, ``3.2·10⁻⁷``."""
    if value is None:
        return UNDEFINED
    if not math.isfinite(value):
        return minus(f"{value:g}")
    if not _needs_power(value):
        return minus(number(value, digits))
    mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
    return minus(f"{mantissa}·10{str(int(exponent)).translate(RAISED)}")


def shortened(text: str, digits: int) -> str:
    """Return a text whose numbers have no more significant digits than so many."""

    def shorter(found: re.Match[str]) -> str:
        told = len(found[0].partition("e")[0].replace(".", "").lstrip("-0"))
        return figure(float(found[0]), min(digits, max(1, told)))

    return NUMBER.sub(shorter, text)


def pair(was: float | None, now: float | None) -> tuple[str, str]:
    """Return two values of one signal, to the digits that tell what has changed between them."""
    if was is None or now is None or was == now or not math.isfinite(now - was):
        return figure(was, TOLD + 1), figure(now, TOLD + 1)
    largest, changed = max(was, now, key=abs), _exponent(now - was)
    if _needs_power(largest):
        digits = TOLD + max(0, _exponent(largest) - changed)
        return figure(was, digits), figure(now, digits)
    whole = was.is_integer() and now.is_integer()
    places = 0 if whole else max(0, TOLD - 1 - changed)
    return _rounded(was, places), _rounded(now, places)


def _rounded(value: float, places: int) -> str:
    return minus(f"{round(value, places) + 0.0:.{places}f}")  # no −0


def _needs_power(value: float) -> bool:
    return value != 0 and not PLAIN[0] <= _exponent(value) < PLAIN[1]


def _exponent(value: float) -> int:
    return math.floor(math.log10(abs(value)))
