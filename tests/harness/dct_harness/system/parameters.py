"""Parameter sets of a component: values in the system file, and SSP parameter files (.ssv)."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from .. import units
from ..errors import ConfigError, unreadable

VALUES = "{http://ssp-standard.org/SSP1/SystemStructureParameterValues}"
READERS = {"Real": float, "Integer": int, "String": str, "Enumeration": str}
BOOLEANS = {"true": True, "1": True, "false": False, "0": False}


def gather(system: Path, given: Any) -> dict[str, Any]:
    """Return the parameters of a component by name; of two values the last one counts.

    Parameters
    ----------
    system
        The system file; names of parameter files are relative to it.
    given
        A table of values, the name of a parameter file, or a list of both.
    """
    found: dict[str, Any] = {}
    for part in given if isinstance(given, list) else [given]:
        found |= read(system.parent / part) if isinstance(part, str) else part
    return found


def files(system: Path, given: Any) -> list[Path]:
    """Return the parameter files among what `gather` is given."""
    listed = given if isinstance(given, list) else [given]
    return [system.parent / part for part in listed if isinstance(part, str)]


def read(path: Path) -> dict[str, Any]:
    """Return the values of a parameter file by name; those with a unit in SI.

    Raises
    ------
    ConfigError
        The file cannot be read, is no parameter set, or has a value that makes no sense.
    """
    try:
        root = ElementTree.fromstring(path.read_bytes())
    except OSError as error:
        raise ConfigError(unreadable(path, "parameter file", error, ".ssv")) from error
    except ElementTree.ParseError as error:
        raise ConfigError(f"{path}: is not valid XML: {error}") from error
    if root.tag != f"{VALUES}ParameterSet":
        raise ConfigError(f"{path}: is no SSP 1.0 parameter set: its root is <{root.tag}>")
    return {p.get("name", ""): _value(path, p) for p in root.iter(f"{VALUES}Parameter")}


def _value(path: Path, parameter: ElementTree.Element) -> Any:
    where = f"{path}: parameter '{parameter.get('name')}'"
    if len(parameter) != 1:
        raise ConfigError(f"{where} needs exactly one value")
    element = parameter[0]
    kind, text = element.tag.removeprefix(VALUES), element.get("value", "")
    try:
        value = BOOLEANS[text] if kind == "Boolean" else READERS[kind](text)
    except (KeyError, ValueError) as error:
        raise ConfigError(f"{where}: '{text}' is no {kind}") from error
    return _in_si(where, value, element.get("unit")) if kind == "Real" else value


def _in_si(where: str, value: float, name: str | None) -> float:
    if name is None:
        return value
    unit = units.find(name)
    if unit is None:
        known = ", ".join(units.KNOWN)
        raise ConfigError(f"{where}: the unit '{name}' is not known ({known}).{units.hint(name)}")
    return unit.factor * value + unit.offset
