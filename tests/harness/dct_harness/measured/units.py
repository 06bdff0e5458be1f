"""Units in which people measure, as factor and offset to SI: si = factor · value + offset."""

from __future__ import annotations

import math

from ..errors import ConfigError, did_you_mean

TURN = 2 * math.pi
_LINEAR = {
    "rad/s": (("rpm", "1/min", "min^-1", "U/min", "r/min", "rev/min"), TURN / 60),
    "rad": (("deg", "°"), math.pi / 180),
    "m": (("mm",), 1e-3),
    "m/s": (("km/h", "kph", "kmh"), 1 / 3.6),
    "N.m": (("Nm", "N·m", "N m", "N*m"), 1.0),
    "N": (("kN",), 1e3),
    "Pa": (("bar",), 1e5),
    "W": (("kW",), 1e3),
    "J": (("kJ",), 1e3),
    "s": (("ms",), 1e-3),
    "m/s2": (("m/s^2", "m/s²"), 1.0),
    "1": (("%",), 1e-2),
}
_SPECIAL = {
    "kN.m": ("N.m", 1e3, 0.0), "kNm": ("N.m", 1e3, 0.0), "kPa": ("Pa", 1e3, 0.0),
    "MPa": ("Pa", 1e6, 0.0), "hPa": ("Pa", 1e2, 0.0), "degC": ("K", 1.0, 273.15),
    "°C": ("K", 1.0, 273.15), "us": ("s", 1e-6, 0.0), "g": ("m/s2", 9.80665, 0.0),
}  # fmt: skip
_SI = ("rad/s", "rad", "m", "m/s", "m/s2", "N", "N.m", "Pa", "W", "J", "s", "K", "1", "", "N/m",
       "kg", "kg.m2", "rad/s2", "N.m.s/rad", "N.m/rad")  # fmt: skip

TO_SI: dict[str, tuple[str, float, float]] = {
    **{name: (name, 1.0, 0.0) for name in _SI},
    **{n: (si, factor, 0.0) for si, (names, factor) in _LINEAR.items() for n in names},
    **_SPECIAL,
}


def to_si(unit: str) -> tuple[str, float, float]:
    """Return SI unit, factor and offset.

    Raises
    ------
    ConfigError
        The unit is not known.
    """
    if unit not in TO_SI:
        raise ConfigError(
            f"unit '{unit}' is not known; give factor and offset to SI.{did_you_mean(unit, TO_SI)}"
        )
    return TO_SI[unit]
