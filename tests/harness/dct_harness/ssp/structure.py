"""The systems inside an SSD as one flat system: components, and who feeds whom with what change.

A component of a nested system is called `outer/inner/component`. Connectors of systems are passed
through: units, transformations and values bound to them add up on the way.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree.ElementTree import Element

from .. import units
from ..errors import ConfigError, did_you_mean
from ..fmu.values import items
from ..system.transforms import Transform

GIVE = ("output", "calculatedParameter", "constant")
TAKE = ("input", "parameter", "structuralParameter")
FMU = "application/x-fmu-sharedlibrary"


class Node(NamedTuple):
    """A connector: of a component, or of a system (the root is '')."""

    element: str
    connector: str

    def __str__(self) -> str:
        return f"{self.element}.{self.connector}" if self.element else self.connector


@dataclass
class Feed:
    """Where an input's value comes from: an output, or a connector of a system fed by nobody."""

    source: Node
    hops: list[tuple[Node, Node, Element]] = field(default_factory=list)


class Structure:
    """Components and connections of an SSD, once its FMUs are described."""

    def __init__(self, path: Path, root: Element) -> None:
        self.path = path
        self.components: dict[str, Element] = {}
        self.systems: dict[str, Element] = {}
        self.descriptions: dict[str, Any] = {}  # by component; set from outside
        self._hops: dict[Node, tuple[Node, Element]] = {}
        self._units = {u.get("name", ""): unit(path, u) for u in every(root, "Units", "Unit")}
        self._codes = {
            e.get("name", ""): {i.get("name", ""): _number(path, i, "value", "0") for i in e}
            for e in every(root, "Enumerations", "Enumeration")
        }
        self._connectors: dict[Node, Element] = {}
        system = one(root, "System")
        if system is None:
            raise ConfigError(f"{path}: has no System")
        self.root = system
        self._collect(system, "")

    def _collect(self, system: Element, name: str) -> None:
        """Note a system, its components, and the systems inside it."""
        self.systems[name] = system
        self._note_connectors(system, name)
        for element in children(system, "Elements"):
            full = self._full(name, element.get("name", ""))
            if tag(element) == "System":
                self._collect(element, full)
            elif tag(element) == "Component":
                self._check(element, full)
                self.components[full] = element
                self._note_connectors(element, full)
            else:
                raise ConfigError(f"{self.path}: {tag(element)} '{full}' is not supported")

    def _full(self, system: str, name: str) -> str:
        if not name or set(name) & set("./") or name == "scenario":
            raise ConfigError(
                f"{self.path}: an element is called '{name}'; '.', '/' and 'scenario' have a "
                "meaning in results: rename it"
            )
        full = f"{system}/{name}" if system else name
        if full in self.components or full in self.systems:
            raise ConfigError(f"{self.path}: two elements are called '{full}'")
        return full

    def _check(self, element: Element, name: str) -> None:
        if element.get("type", FMU) != FMU:
            raise ConfigError(
                f"{self.path}: component '{name}' is of type {element.get('type')}; only FMUs can "
                "run: put the system itself in its place"
            )

    def _note_connectors(self, element: Element, name: str) -> None:
        for connector in every(element, "Connectors", "Connector"):
            if one(connector, "Dimension") is not None:
                raise ConfigError(f"{self.path}: connector '{name}.{connector.get('name')}' "
                                  "is an array; FMI 2.0 has none")  # fmt: skip
            self._connectors[Node(name, connector.get("name", ""))] = connector

    def connect(self) -> None:
        """Read all connections; the FMUs are described by now."""
        for name, system in self.systems.items():
            for connection in every(system, "Connections", "Connection"):
                giver, taker = self._directed(name, connection)
                if taker in self._hops:
                    raise ConfigError(f"{self.path}: '{taker}' has two sources")
                self._hops[taker] = giver, connection

    def _directed(self, system: str, connection: Element) -> tuple[Node, Node]:
        """Return giver and taker; start and end of a connection do not say which is which."""
        ends = []
        for side in ("start", "end"):
            element = connection.get(f"{side}Element")
            full = system if element is None else f"{system}/{element}" if system else element
            node = Node(full, connection.get(f"{side}Connector", ""))
            self._exists(node, inside=element is None)
            ends.append((node, self._gives(node, inside=element is None)))
        (start, first), (end, second) = ends
        return (end, start) if first is False or (first is None and second) else (start, end)

    def _exists(self, node: Node, inside: bool) -> None:
        if not inside and node.element not in self.components and node.element not in self.systems:
            known = (*self.components, *self.systems)
            raise ConfigError(f"{self.path}: no '{node}'.{did_you_mean(node.element, known)}")
        if node.element in self.components:
            self.variable(node)

    def _gives(self, node: Node, inside: bool) -> bool | None:
        """Return whether a connector gives a value to the system that its connection is in."""
        connector = self._connectors.get(node)
        kind = connector.get("kind") if connector is not None else None
        if kind is None and node.element in self.components:
            kind = self.variable(node).causality
        if kind in GIVE or kind in TAKE:
            return (kind in GIVE) != inside
        return None

    def variable(self, node: Node) -> Any:
        """Return the variable of an FMU behind a connector."""
        known = {v.name: v for v in self.descriptions[node.element].modelVariables}
        if node.connector not in known:
            raise ConfigError(f"{self.path}: no '{node}'.{did_you_mean(node.connector, known)}")
        return known[node.connector]

    def feeds(self) -> Iterator[tuple[Node, Feed]]:
        """Yield each fed connector of a component, and where its value comes from."""
        for taker in self._hops:
            if taker.element in self.components:
                yield taker, self._trace(taker)

    def _trace(self, taker: Node) -> Feed:
        hops: list[tuple[Node, Node, Element]] = []
        node = taker
        while node in self._hops and (node == taker or node.element not in self.components):
            giver, connection = self._hops[node]
            hops.insert(0, (giver, node, connection))
            if len(hops) > len(self._hops):
                raise ConfigError(f"{self.path}: '{taker}' is fed by a ring of connectors")
            node = giver
        return Feed(node, hops)

    def unit(self, node: Node) -> units.Unit | None:
        """Return the unit of a connector; that of the FMU counts first."""
        if node.element in self.components:
            variable = self.variable(node)
            if variable.type != "Real":
                return None
            found = units.declared(self.descriptions[node.element], variable)[1]
            if found is not None:
                return found
        connector = self._connectors.get(node)
        kinds = list(connector) if connector is not None else []
        name = next((k.get("unit") for k in kinds if k.get("unit")), "") or ""
        return self._units.get(name) or (units.find(name) if name else None)

    def change(self, feed: Feed) -> Transform:
        """Return what happens to a value from its source to the input: per hop, units first."""
        found, carried = Transform(), self.unit(feed.source)
        for giver, taker, connection in feed.hops:
            told = transformation(self.path, connection, self._coder(giver), self._coder(taker))
            unit = self.unit(taker)
            try:
                if carried and unit and not told.table and not _suppressed(connection):
                    found = found.then(Transform(*units.conversion(carried, unit)))
                found = found.then(told)
            except ValueError as error:
                raise ConfigError(f"{self.path}: '{giver}' to '{taker}': {error}") from error
            carried = unit or (None if told.changes else carried)
        return found

    def _coder(self, node: Node) -> Callable[[str | None], float]:
        """Return what makes the number of a table's cell: an item's, a boolean's, or its own."""
        if node.element in self.components:
            known = {n: float(v) for n, v in items(self.variable(node)).items()}
        else:
            connector = self._connectors.get(node)
            kinds = list(connector) if connector is not None else []
            known = next((self._codes.get(k.get("name", ""), {}) for k in kinds), {})

        def number(text: str | None) -> float:
            if text in known:
                return known[text]
            words = {"true": "1", "false": "0"}
            return real(self.path, str(node), words.get(text or "", text))

        return number


def transformation(
    path: Path, element: Element, source: Callable[[str | None], float],
    target: Callable[[str | None], float],
) -> Transform:  # fmt: skip
    """Return the transformation that stands in a connection or a mapping entry."""
    for child in element:
        if tag(child) == "LinearTransformation":
            factor = _number(path, child, "factor", "1")
            return Transform(factor, _number(path, child, "offset", "0"))
        if tag(child).endswith("MappingTransformation"):
            rows = (e for e in child if tag(e) == "MapEntry")
            return Transform(table={source(e.get("source")): target(e.get("target")) for e in rows})
    return Transform()


def _suppressed(connection: Element) -> bool:
    return connection.get("suppressUnitConversion") in ("true", "1")


def real(path: Path, what: str, text: str | None) -> float:
    """Read a number; errors name the file and what it is."""
    try:
        return float(text or "")
    except ValueError:
        raise ConfigError(f"{path}: '{what}': '{text}' is no number and no known item") from None


def _number(path: Path, element: Element, name: str, otherwise: str) -> float:
    """Read an attribute that is a number."""
    return real(path, name, element.get(name, otherwise))


def whole(path: Path, element: Element, name: str, otherwise: str) -> int:
    """Read an attribute that is a whole number."""
    text = element.get(name, otherwise)
    try:
        return int(text)
    except ValueError:
        raise ConfigError(f"{path}: '{name}': '{text}' is no whole number") from None


def unit(path: Path, element: Element) -> units.Unit:
    """Return a unit that an SSD or a parameter set defines."""
    name, base = element.get("name", ""), one(element, "BaseUnit")
    if base is None:
        return units.Unit(name)
    exponents = ((b, whole(path, base, b, "0")) for b in units.BASES)
    factor, offset = _number(path, base, "factor", "1"), _number(path, base, "offset", "0")
    return units.Unit(name, tuple((b, n) for b, n in exponents if n), factor, offset)


def tag(element: Element) -> str:
    """Return the name of an element without its namespace; SSP 1.0 and 2.0 share them anyway."""
    return element.tag.rpartition("}")[2]


def one(element: Element, name: str) -> Element | None:
    """Return the first child of a name."""
    return next((e for e in element if tag(e) == name), None)


def children(element: Element, group: str) -> list[Element]:
    """Return the children of a child."""
    found = one(element, group)
    return list(found) if found is not None else []


def every(element: Element, group: str, name: str) -> list[Element]:
    """Return the children of a name inside a child."""
    return [e for e in children(element, group) if tag(e) == name]
