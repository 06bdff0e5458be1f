"""What a signal may differ by: one default, and rules by name from a TOML file."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass, field, fields, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from ..errors import ConfigError, did_you_mean

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


@dataclass(frozen=True)
class Tolerance:
    """Bounds of one signal; `ignore` leaves it out.

    `abs` in the signal's unit, `rel` of the reference's largest magnitude, `tube` [s],
    `nrmse` of the reference's RMS (None: not asked for).
    """

    abs: float = 1e-9
    rel: float = 1e-6
    tube: float = 0.0
    nrmse: float | None = None
    ignore: bool = False


KEYS = tuple(f.name for f in fields(Tolerance))


@dataclass(frozen=True)
class Tolerances:
    """Rules in the order of the file: of those that match a name, the last wins, key by key."""

    default: Tolerance = field(default_factory=Tolerance)
    rules: tuple[tuple[str, dict[str, Any]], ...] = ()

    def of(self, name: str) -> Tolerance:
        """Return the tolerance of a signal."""
        found = self.default
        for pattern, values in self.rules:
            if fnmatchcase(name, pattern):
                found = replace(found, **values)
        return found

    def unused(self, names: list[str]) -> list[str]:
        """Return the patterns that match none of these names."""
        return [p for p, _ in self.rules if not any(fnmatchcase(n, p) for n in names)]


def load(path: Path, default: Tolerance) -> Tolerances:
    """Read a tolerance file: `[default]`, then `[[signals]]` with `name` (a glob) and bounds.

    Raises
    ------
    ConfigError
        The file cannot be read, or a key or value is none.
    """
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(f"{path}: cannot read the tolerances: {error.strerror}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path}: is not valid TOML: {error}") from error
    for key in data:
        if key not in ("default", "signals"):
            hint = did_you_mean(key, ("default", "signals"))
            raise ConfigError(f"{path}: no table '{key}'.{hint}")
    rules = data.get("signals", [])
    base, tables = data.get("default", {}), rules if isinstance(rules, list) else [rules]
    if not all(isinstance(table, dict) for table in (base, *tables)):
        raise ConfigError(f"{path}: write [default] and [[signals]] tables")
    start = replace(default, **_bounds(path, "default", base))
    return Tolerances(start, tuple(_rule(path, k, t) for k, t in enumerate(tables, 1)))


def _rule(path: Path, number: int, table: dict[str, Any]) -> tuple[str, dict[str, Any]]:
    where = f"signals entry {number}"
    name = table.get("name")
    if not isinstance(name, str) or not name:
        raise ConfigError(f'{path}: {where}: needs a name, as "observer.*"')
    return name, _bounds(path, where, {k: v for k, v in table.items() if k != "name"})


def _bounds(path: Path, where: str, table: dict[str, Any]) -> dict[str, Any]:
    for key, value in table.items():
        if key not in KEYS:
            raise ConfigError(f"{path}: {where}: no key '{key}'.{did_you_mean(key, KEYS)}")
        is_flag = isinstance(value, bool)
        if (key == "ignore") != is_flag:
            raise ConfigError(f"{path}: {where}: {key} = {value!r} has the wrong type")
        if not is_flag and not (
            isinstance(value, (int, float)) and math.isfinite(value) and value >= 0
        ):
            raise ConfigError(f"{path}: {where}: {key} = {value!r} is not a number of at least 0")
    return table
