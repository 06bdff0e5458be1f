"""From the names and units of a measurement to ours, by a TOML file.

[[signals]]
from = "EngSpd"            # channel of the measurement
to = "engine.speed"        # our name, in SI units
unit = "rpm"               # only if the file does not tell it
factor = 0.10471975511966  # instead of a unit: si = factor · value + offset
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..errors import ConfigError, did_you_mean
from ..units import to_si
from .channels import Channel

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

KEYS = ("from", "to", "unit", "factor", "offset")


@dataclass(frozen=True)
class Mapping:
    """Entries of a map file, each a table with `from` and `to`."""

    path: Path
    entries: tuple[dict[str, Any], ...]

    @staticmethod
    def load(path: Path) -> Mapping:
        """Read and check a map file; errors name the entry."""
        try:
            data = tomllib.loads(path.read_text(encoding="utf-8"))
        except OSError as error:
            raise ConfigError(f"{path}: cannot read the map: {error.strerror}") from error
        except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
            raise ConfigError(f"{path}: is not valid TOML: {error}") from error
        entries = data.get("signals")
        if not isinstance(entries, list) or not all(isinstance(e, dict) for e in entries):
            raise ConfigError(f"{path}: needs [[signals]] tables with from and to")
        for number, entry in enumerate(entries, 1):
            _check(f"{path}: signals entry {number}", entry)
        targets = [entry["to"] for entry in entries]
        for target in targets:
            if targets.count(target) > 1:
                raise ConfigError(f"{path}: '{target}' is mapped twice")
        return Mapping(path, tuple(entries))

    def apply(self, channels: list[Channel]) -> list[Channel]:
        """Return the mapped channels under our names, in SI units."""
        known = {channel.name: channel for channel in channels}
        found = []
        for entry in self.entries:
            name = entry["from"]
            if name not in known:
                hint = did_you_mean(name, known)
                raise ConfigError(f"{self.path}: the measurement has no channel '{name}'.{hint}")
            found.append(self._convert(entry, known[name]))
        return found

    def _convert(self, entry: dict[str, Any], channel: Channel) -> Channel:
        if "factor" in entry or "offset" in entry:
            unit, factor, offset = "", entry.get("factor", 1.0), entry.get("offset", 0.0)
        else:
            try:
                unit, factor, offset = to_si(entry.get("unit", channel.unit))
            except ConfigError as error:
                raise ConfigError(f"{self.path}: '{entry['from']}': {error}") from None
        values = channel.values * factor + offset
        return replace(channel, name=entry["to"], values=values, unit=unit)


def _check(where: str, entry: dict[str, Any]) -> None:
    for key, value in entry.items():
        if key not in KEYS:
            raise ConfigError(f"{where}: no key '{key}'.{did_you_mean(key, KEYS)}")
        number = isinstance(value, (int, float)) and not isinstance(value, bool)
        fits = number and math.isfinite(value) if key in KEYS[3:] else isinstance(value, str)
        if not fits:
            raise ConfigError(f"{where}: {key} = {value!r} has the wrong type")
    if not (entry.get("from") and entry.get("to")):
        raise ConfigError(f"{where}: needs from and to")
    if "unit" in entry and ("factor" in entry or "offset" in entry):
        raise ConfigError(f"{where}: give a unit, or factor and offset, not both")
