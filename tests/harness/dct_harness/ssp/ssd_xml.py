"""Elements of SSP 1.0 files: connectors, units, enumerations, parameter values, connections."""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from ..fmu.values import items
from ..system.transforms import Transform
from ..units import Unit, declared

BASE = "http://ssp-standard.org/SSP1/SystemStructure"
SPACES = {
    "ssd": f"{BASE}Description", "ssc": f"{BASE}Common", "ssv": f"{BASE}ParameterValues",
}  # fmt: skip
RUN = "dct-harness:run"  # of what SSP has no words for


def tag(short: str) -> str:
    """Return `ssd:Name` with its namespace written out."""
    prefix, _, name = short.partition(":")
    return f"{{{SPACES[prefix]}}}{name}"


def sub(parent: Element, name: str, /, **attributes: Any) -> Element:
    """Add an element; attributes that are None are left out."""
    given = {k: text(v) for k, v in attributes.items() if v is not None}
    return SubElement(parent, tag(name), given)


def text(value: Any) -> str:
    """Return a value as XML writes it; every digit of a number."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value) if isinstance(value, float) else str(value)


def document(root: Element) -> bytes:
    """Return a file."""
    for prefix, uri in {**SPACES, "run": RUN}.items():
        ElementTree.register_namespace(prefix, uri)
    ElementTree.indent(root)
    return ElementTree.tostring(root, "utf-8", xml_declaration=True) + b"\n"


class Dictionary:
    """Units and enumerations that a file uses, each once."""

    def __init__(self) -> None:
        self.units: dict[str, Unit] = {}
        self.enumerations: dict[str, dict[str, int]] = {}

    def unit(self, description: Any, variable: Any) -> str | None:
        """Return the name under which a variable's unit stands in the file; None if unknown."""
        name, unit = declared(description, variable)
        if unit is None:
            return None
        while name in self.units and self.units[name] != unit:
            name += "_"  # another FMU means something else by it
        self.units[name] = unit
        return name

    def enumeration(self, variable: Any) -> str:
        """Return the name under which a variable's enumeration stands in the file."""
        name = variable.declaredType.name if variable.declaredType else variable.name
        while self.enumerations.get(name, items(variable)) != items(variable):
            name += "_"
        self.enumerations[name] = items(variable)
        return str(name)

    def write(self, root: Element) -> None:
        """Add the Enumerations and Units of an SSD."""
        if self.enumerations:
            listed = sub(root, "ssd:Enumerations")
        for name, known in self.enumerations.items():
            one = sub(listed, "ssc:Enumeration", name=name)
            for item, value in known.items():
                sub(one, "ssc:Item", name=item, value=value)
        if self.units:
            units(sub(root, "ssd:Units"), self.units)


def units(parent: Element, known: dict[str, Unit]) -> None:
    """Add units with their BaseUnit."""
    for name, unit in known.items():
        base = dict(unit.exponents)
        line = {"factor": unit.factor if unit.factor != 1 else None,
                "offset": unit.offset if unit.offset else None}  # fmt: skip
        sub(sub(parent, "ssc:Unit", name=name), "ssc:BaseUnit", **base, **line)


def connector(
    parent: Element, name: str, kind: str, variable: Any, unit: str | None, known: Dictionary
) -> None:
    """Add a connector of a variable's type."""
    one = sub(parent, "ssd:Connector", name=name, kind=kind)
    if variable.type == "Real":
        sub(one, "ssc:Real", unit=unit)
    elif variable.type == "Enumeration":
        sub(one, "ssc:Enumeration", name=known.enumeration(variable))
    else:
        sub(one, f"ssc:{variable.type}")


def parameter(parent: Element, variable: Any, value: Any) -> None:
    """Add a value of a parameter set; in the unit of the variable."""
    one = sub(parent, "ssv:Parameter", name=variable.name)
    named = {number: item for item, number in items(variable).items()}
    if variable.type == "Enumeration":
        sub(one, "ssv:Enumeration", value=named.get(value, value))
    else:
        sub(one, f"ssv:{variable.type}", value=float(value) if variable.type == "Real" else value)


def transformation(parent: Element, change: Transform, source: Any, target: Any) -> None:
    """Add what a connection does to values; `source` and `target` are the variables at its ends."""
    if not change.table:
        given = {"factor": change.factor, "offset": change.offset}
        sub(parent, "ssc:LinearTransformation", **given)
        return
    kinds = {source.type, target.type}
    kind = kinds.pop() if len(kinds) == 1 else "Enumeration"
    kind = kind if kind in ("Boolean", "Integer") else "Enumeration"
    listed = sub(parent, f"ssc:{kind}MappingTransformation")
    for code, other in change.table.items():
        sub(listed, "ssc:MapEntry", source=_code(source, code), target=_code(target, other))


def _code(variable: Any, value: float) -> str:
    """Return an item's name, a boolean, or a whole number."""
    if variable.type == "Boolean":
        return text(bool(value))
    named = {number: item for item, number in items(variable).items()}
    return named.get(int(value), str(int(value)))
