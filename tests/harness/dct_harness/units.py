"""Units: conversion to SI by the BaseUnit exponents, factor and offset of FMI 2.0."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any

from .errors import ConfigError, did_you_mean

BASES = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
HEADER = re.compile(r"^(?P<name>.*\S)\s+[\[(](?P<unit>[^\])]*)[\])]$")  # of a column: `name [unit]`
TURN = 2 * math.pi  # rad
MINUTE, HOUR = 60.0, 3600.0  # s
ZERO_CELSIUS = 273.15  # K


@dataclass(frozen=True)
class Unit:
    """A unit: value in SI = factor * value + offset; `exponents` of the base units by name."""

    name: str
    exponents: tuple[tuple[str, int], ...] = ()
    factor: float = 1.0
    offset: float = 0.0

    @property
    def dimension(self) -> str:
        """Exponents as text, ``kg m2 s-2``; ``1`` for none."""
        parts = [f"{base}{'' if n == 1 else n}" for base, n in self.exponents]
        return " ".join(parts) or "1"

    def difference(self) -> Unit:
        """Return the unit for differences, which have no offset (FMI: relativeQuantity)."""
        return Unit(self.name, self.exponents, self.factor)


def _unit(name: str, factor: float = 1.0, offset: float = 0.0, **exponents: int) -> Unit:
    ordered = tuple((base, exponents[base]) for base in BASES if exponents.get(base))
    return Unit(name, ordered, factor, offset)


def _torque(name: str, factor: float = 1.0) -> Unit:
    return _unit(name, factor, kg=1, m=2, s=-2)


def _speed(name: str, factor: float) -> Unit:
    return _unit(name, factor, s=-1, rad=1)


# For FMUs that state no BaseUnit, and for `unit = "..."` in a mapping.
_LIST = (
    _unit("1"), _unit("-"), _unit("%", 0.01),
    _unit("s", s=1), _unit("ms", 1e-3, s=1),
    _unit("m", m=1), _unit("mm", 1e-3, m=1), _unit("cm", 1e-2, m=1),
    _unit("m2", m=2), _unit("mm2", 1e-6, m=2), _unit("cm2", 1e-4, m=2),
    _unit("rad", rad=1), _unit("deg", math.pi / 180, rad=1),
    _unit("rad/s", s=-1, rad=1), _speed("rpm", TURN / MINUTE), _speed("1/min", TURN / MINUTE),
    _speed("r/min", TURN / MINUTE), _speed("rev/min", TURN / MINUTE), _speed("rev/s", TURN),
    _speed("deg/s", math.pi / 180),
    _unit("m/s", m=1, s=-1), _unit("km/h", 1e3 / HOUR, m=1, s=-1),
    _unit("kph", 1e3 / HOUR, m=1, s=-1), _unit("kmph", 1e3 / HOUR, m=1, s=-1),
    _unit("m/s2", m=1, s=-2), _unit("m/s^2", m=1, s=-2), _unit("m/s3", m=1, s=-3),
    _unit("kg", kg=1), _unit("t", 1e3, kg=1), _unit("kg.m2", kg=1, m=2),
    _unit("N", kg=1, m=1, s=-2), _unit("kN", 1e3, kg=1, m=1, s=-2),
    _torque("N.m"), _torque("Nm"), _torque("N*m"), _torque("kN.m", 1e3), _torque("kNm", 1e3),
    _unit("N/m", kg=1, s=-2), _unit("N/mm", 1e3, kg=1, s=-2), _unit("1/s", s=-1),
    _unit("N.m/rad", kg=1, m=2, s=-2, rad=-1), _unit("kN.m/rad", 1e3, kg=1, m=2, s=-2, rad=-1),
    _unit("N.m.s/rad", kg=1, m=2, s=-1, rad=-1),
    _unit("Pa", kg=1, m=-1, s=-2), _unit("kPa", 1e3, kg=1, m=-1, s=-2),
    _unit("MPa", 1e6, kg=1, m=-1, s=-2), _unit("bar", 1e5, kg=1, m=-1, s=-2),
    _unit("J", kg=1, m=2, s=-2), _unit("kJ", 1e3, kg=1, m=2, s=-2),
    _unit("W", kg=1, m=2, s=-3), _unit("kW", 1e3, kg=1, m=2, s=-3),
    _unit("K", K=1), _unit("degC", 1.0, ZERO_CELSIUS, K=1), _unit("°C", 1.0, ZERO_CELSIUS, K=1),
    _unit("kg/m3", kg=1, m=-3), _unit("m3", m=3), _unit("m3/J", kg=-1, m=1, s=2),
    _unit("J/K", kg=1, m=2, s=-2, K=-1), _unit("W/K", kg=1, m=2, s=-3, K=-1),
)  # fmt: skip
KNOWN = {unit.name: unit for unit in _LIST}
SPELLINGS = {
    "": "1", "U/min": "rpm", "min^-1": "rpm", "°": "deg", "kmh": "km/h", "N·m": "N.m",
    "N m": "N.m", "m/s²": "m/s2",
}  # fmt: skip


def find(name: str) -> Unit | None:
    """Return a unit by its name or another spelling of it; None if it is not known."""
    return KNOWN.get(SPELLINGS.get(name, name))


def hint(name: str) -> str:
    """Return the known unit that was probably meant, as errors say it."""
    return did_you_mean(name, [*KNOWN, *SPELLINGS])


def to_si(name: str) -> tuple[str, float, float]:
    """Return SI unit, factor and offset: si = factor * value + offset.

    Raises
    ------
    ConfigError
        The unit is not known.
    """
    unit = find(name)
    if unit is None:
        what = f"unit '{name}' is not known; give factor and offset to SI.{hint(name)}"
        raise ConfigError(what)
    plain = (u for u in KNOWN.values() if u.exponents == unit.exponents)
    coherent = next(u.name for u in plain if (u.factor, u.offset) == (1.0, 0.0))
    return coherent, unit.factor, unit.offset


def declared(description: Any, variable: Any) -> tuple[str, Unit | None]:
    """Return the unit's name that an FMU states for a variable, and the unit if it is known.

    A BaseUnit in the FMU counts first, then the unit's name; ("", None) when none is stated.
    """
    kind = variable.declaredType
    name = variable.unit or (kind.unit if kind else None) or ""
    stated = {unit.name: unit.baseUnit for unit in description.unitDefinitions}
    base = stated.get(name)
    named = find(name) if name else None
    unit = named if base is None else _of_base(name, base)
    relative = variable.relativeQuantity or bool(kind and kind.relativeQuantity)
    return name, unit.difference() if unit and relative else unit


def _of_base(name: str, base: Any) -> Unit:
    exponents = {b: int(getattr(base, b) or 0) for b in BASES}
    return _unit(name, float(base.factor or 1.0), float(base.offset or 0.0), **exponents)


def conversion(source: Unit, target: Unit) -> tuple[float, float]:
    """Return a, b of target value = a * source value + b.

    Raises
    ------
    ValueError
        The units measure different quantities.
    """
    if source.exponents != target.exponents:
        raise ValueError(
            f"'{source.name}' ({source.dimension}) cannot become "
            f"'{target.name}' ({target.dimension})"
        )
    return source.factor / target.factor, (source.offset - target.offset) / target.factor
