"""SSP 1.0 and 2.0 system files (.ssp) of FMI 2.0 components, as a `System`.

Connections, linear and table transformations, unit conversion, parameter sets (ssv, inline or in
files) with parameter mappings (ssm). Inputs of the system are columns of the scenario.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from . import scenario as scenarios
from . import units
from .archive import described, extract, opened, refuse_doctype
from .errors import ConfigError, did_you_mean
from .system import Component, System
from .transforms import Transform
from .values import KINDS, group_of, items

STRUCTURE = "SystemStructure.ssd"
STEP = 1e-3  # s, where nobody says another one


class Package:
    """An opened .ssp; its FMUs lie in `folder` until it is removed."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.folder = tempfile.TemporaryDirectory(prefix="dct-harness-ssp-")
        with opened(path) as archive:
            extract(path, archive, Path(self.folder.name))
        root = self._xml(STRUCTURE)
        self._system = _one(root, "System")
        if self._system is None:
            raise ConfigError(f"{path}: {STRUCTURE} has no System")
        self._root = root
        self.paths: dict[str, Path] = {}
        self._descriptions: dict[str, Any] = {}

    def _xml(self, name: str) -> ElementTree.Element:
        text = self._member(name).read_bytes()
        refuse_doctype(self.path, text, name)
        return ElementTree.fromstring(text)

    def system(self, scenario: Path | None, step: float | None, stop: float | None) -> System:
        """Return the system.

        A stop time comes from the command line or the DefaultExperiment; scenario, step and the
        like from the command line or the annotation that `export-ssp` writes.
        """
        experiment = _one(self._root, "DefaultExperiment")
        told = experiment.get("stopTime") if experiment is not None else None
        if stop is None and told is None:
            raise ConfigError(f"{self.path}: says no stopTime; give --stop SECONDS")
        components = {c.get("name", ""): self._component(c) for c in self._components()}
        connections, transforms = self._connections()
        self._bind(self._system, "", components)
        notes = self._notes()
        scenario = scenario or self._scenario(notes)
        if scenario is None and any(s.startswith("scenario.") for s in connections.values()):
            raise ConfigError(f"{self.path}: has inputs of its own; give --scenario FILE.csv")
        for one in (e for e in notes if _tag(e) == "Substeps"):
            components[one.get("component", "")].substeps = int(one.get("count", 1))
        name = self._system.get("name") or self.path.stem
        return System(
            name, notes.get("title", name), step or float(notes.get("step", STEP)),
            stop if stop is not None else float(told), scenario, components, connections,
            self.path, [_limit(e) for e in notes if _tag(e) == "Limit"],
            notes.get("coupling", "gauss-seidel"), notes.get("interpolate") == "true",
            explicit=True, transforms=transforms,
        )  # fmt: skip

    def _notes(self) -> ElementTree.Element:
        """Return what `export-ssp` has noted; an empty element if nothing."""
        for note in _all(self._root, "Annotations", "Annotation"):
            if note.get("type") == "dct-harness" and len(note):
                return note[0]
        return ElementTree.Element("Run")

    def _scenario(self, notes: ElementTree.Element) -> Path | None:
        name = notes.get("scenario")
        return None if name is None else self._member(name)

    def _member(self, name: str) -> Path:
        """Return a file of the archive."""
        file = (Path(self.folder.name) / name).resolve()
        if not file.is_relative_to(Path(self.folder.name).resolve()) or not file.is_file():
            raise ConfigError(f"{self.path}: has no '{name}'")
        return file

    @staticmethod
    def release(system: System) -> list[str]:
        """Drop connections from inputs of the system that the scenario has no column for.

        Their targets keep their start values; returns them.
        """
        columns = scenarios.load(system.scenario).signals
        free = [t for t, s in system.connections.items()
                if s.startswith("scenario.") and s.partition(".")[2] not in columns]  # fmt: skip
        for target in free:
            del system.connections[target]
        return free

    def _components(self) -> list[ElementTree.Element]:
        elements = _one(self._system, "Elements")
        found = list(elements) if elements is not None else []
        for element in found:
            if _tag(element) != "Component":
                what, name = _tag(element), element.get("name")
                raise ConfigError(f"{self.path}: {what} '{name}': only flat systems can run")
        return found

    def _component(self, element: ElementTree.Element) -> Component:
        name, source = element.get("name", ""), element.get("source", "")
        file = (Path(self.folder.name) / source).resolve()
        if not file.is_relative_to(Path(self.folder.name).resolve()) or not file.is_file():
            raise ConfigError(f"{self.path}: component '{name}' has no file '{source}' inside")
        self.paths[name] = file
        self._descriptions[name] = described(file)
        component = Component(source)
        self._bind(element, name, {name: component})
        return component

    def _connections(self) -> tuple[dict[str, str], dict[str, Transform]]:
        connections: dict[str, str] = {}
        transforms: dict[str, Transform] = {}
        for c in _all(self._system, "Connections", "Connection"):
            taker = c.get("endElement")
            if taker is None:
                continue  # an output of the system: all outputs are recorded
            target = f"{taker}.{c.get('endConnector')}"
            source = f"{c.get('startElement') or 'scenario'}.{c.get('startConnector')}"
            if target in connections:
                raise ConfigError(f"{self.path}: '{target}' has two sources")
            connections[target] = source
            found = self._transform(c, source, target)
            if found.changes:
                transforms[target] = found
        return connections, transforms

    def _transform(self, c: ElementTree.Element, source: str, target: str) -> Transform:
        found = Transform()
        for child in c:
            if _tag(child) == "LinearTransformation":
                found = Transform(float(child.get("factor", 1)), float(child.get("offset", 0)))
            elif _tag(child).endswith("MappingTransformation"):
                rows = {self._code(source, e.get("source")): self._code(target, e.get("target"))
                        for e in child}  # fmt: skip
                found = Transform(table=rows)
        if c.get("suppressUnitConversion") == "true" or source.startswith("scenario."):
            return found
        ends = [self._unit_of(end) for end in (source, target)]
        if None in ends or found.table:
            return found
        try:
            return found.after(*units.conversion(*ends))
        except ValueError as error:
            raise ConfigError(f"{self.path}: '{source}' to '{target}': {error}") from error

    def _variable(self, end: str) -> Any:
        component, _, name = end.partition(".")
        known = {v.name: v for v in self._descriptions[component].modelVariables} if (
            component in self._descriptions) else {}  # fmt: skip
        if name not in known:
            raise ConfigError(f"{self.path}: no '{end}'.{did_you_mean(name, known)}")
        return known[name]

    def _unit_of(self, end: str) -> units.Unit | None:
        variable = self._variable(end)
        if variable.type != "Real":
            return None
        return units.declared(self._descriptions[end.partition(".")[0]], variable)[1]

    def _code(self, end: str, text: str | None) -> float:
        """Return the number of a table's cell: an item's, a boolean's, or itself."""
        known = {} if end.startswith("scenario.") else items(self._variable(end))
        if text in known:
            return float(known[text])
        return float({"true": 1, "false": 0}.get(text or "", text))

    def _bind(
        self, element: ElementTree.Element, component: str, components: dict[str, Component]
    ) -> None:
        """Put the parameter sets of an element into its components."""
        for binding in _all(element, "ParameterBindings", "ParameterBinding"):
            values = self._values(binding)
            for source, target, change in self._mapping(binding, values):
                name = f"{component}.{target}" if component else target
                owner, _, parameter = f"{binding.get('prefix', '')}{name}".partition(".")
                if owner not in components:
                    raise ConfigError(f"{self.path}: parameter '{target}': no such component")
                value, unit = values[source]
                variable = self._variable(f"{owner}.{parameter}")
                components[owner].parameters[parameter] = self._value(
                    variable, owner, value, unit, change
                )

    def _values(self, binding: ElementTree.Element) -> dict[str, tuple[str, units.Unit | None]]:
        """Return name -> text and unit of a parameter set."""
        inline = _one(binding, "ParameterValues")
        root = inline[0] if inline is not None and len(inline) else None
        if root is None:
            root = self._xml(binding.get("source", ""))
        known = {u.get("name"): _unit(u) for u in _all(root, "Units", "Unit")}
        found = {}
        for parameter in _all(root, "Parameters", "Parameter"):
            for value in parameter:
                name = value.get("unit")
                unit = known.get(name) or units.KNOWN.get(name or "")
                text = value.get("value", value.get("name", ""))
                found[parameter.get("name", "")] = text, unit
        return found

    def _mapping(
        self, binding: ElementTree.Element, values: dict[str, Any]
    ) -> list[tuple[str, str, Transform]]:
        """Return source, target and transform of each parameter that is bound."""
        mapping = _one(binding, "ParameterMapping")
        if mapping is None:
            return [(name, name, Transform()) for name in values]
        root = self._xml(mapping.get("source", "")) if mapping.get("source") else mapping
        found = []
        for entry in (e for e in root.iter() if _tag(e) == "MappingEntry"):
            linear = _one(entry, "LinearTransformation")
            change = Transform() if linear is None else Transform(
                float(linear.get("factor", 1)), float(linear.get("offset", 0)))  # fmt: skip
            source = entry.get("source", "")
            if source not in values:
                raise ConfigError(f"{self.path}: mapping: no parameter '{source}'")
            found.append((source, entry.get("target", ""), change))
        return found

    def _value(
        self, variable: Any, owner: str, text: str, unit: units.Unit | None, change: Transform
    ) -> Any:
        if variable.type == "Enumeration" or group_of(variable) == "String":
            return text
        if group_of(variable) == "Boolean":
            return text == "true"
        value = float(text)
        theirs = self._unit_of(f"{owner}.{variable.name}") if variable.type == "Real" else None
        if unit and theirs:
            a, b = units.conversion(unit, theirs)
            value = a * value + b
        return KINDS[group_of(variable)](change.factor * value + change.offset)


def _limit(element: ElementTree.Element) -> dict[str, Any]:
    """Return a limit of a KPI, as a system file has it."""
    return {k: float(v) if k in ("min", "max") else v for k, v in element.attrib.items()}


def _unit(element: ElementTree.Element) -> units.Unit:
    base = _one(element, "BaseUnit")
    told = dict(base.attrib) if base is not None else {}
    exponents = tuple((b, int(told[b])) for b in units.BASES if int(told.get(b, 0)))
    return units.Unit(element.get("name", ""), exponents, float(told.get("factor", 1)),
                      float(told.get("offset", 0)))  # fmt: skip


def _tag(element: ElementTree.Element) -> str:
    return element.tag.rpartition("}")[2]


def _one(element: ElementTree.Element, tag: str) -> ElementTree.Element | None:
    return next((e for e in element if _tag(e) == tag), None)


def _all(element: ElementTree.Element, group: str, tag: str) -> list[ElementTree.Element]:
    found = _one(element, group)
    return [e for e in found if _tag(e) == tag] if found is not None else []
