"""Units of measurements to SI: si = factor · value + offset. Adds spellings to `..units`."""

from __future__ import annotations

from ..errors import ConfigError, did_you_mean
from ..units import KNOWN

ALIASES = {
    "": "1", "U/min": "rpm", "min^-1": "rpm", "°": "deg", "kmh": "km/h", "N·m": "N.m",
    "N m": "N.m", "m/s²": "m/s2",
}  # fmt: skip


def to_si(unit: str) -> tuple[str, float, float]:
    """Return SI unit, factor and offset.

    Raises
    ------
    ConfigError
        The unit is not known.
    """
    found = KNOWN.get(ALIASES.get(unit, unit))
    if found is None:
        hint = did_you_mean(unit, [*KNOWN, *ALIASES])
        raise ConfigError(f"unit '{unit}' is not known; give factor and offset to SI.{hint}")
    plain = (u for u in KNOWN.values() if u.exponents == found.exponents)
    coherent = next(u.name for u in plain if (u.factor, u.offset) == (1.0, 0.0))
    return coherent, found.factor, found.offset
