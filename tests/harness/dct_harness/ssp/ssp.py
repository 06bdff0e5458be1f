"""SSP 1.0 and 2.0 system files (.ssp) of FMI 2.0 components, as a `System`.

Nested systems, connections, linear and table transformations, unit conversion, parameter sets (ssv,
inline or in files) with parameter mappings (ssm). Inputs of the system are columns of the scenario.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from .. import units
from ..errors import ConfigError, FmuInvalidError, did_you_mean
from ..fmu.archive import described, extract, opened, refuse_doctype
from ..fmu.values import KINDS, group_of
from ..system import scenario as scenarios
from ..system.system import Component, System
from ..system.transforms import Transform
from .structure import Node, Structure, every, one, real, tag, transformation, unit, whole

STRUCTURE = "SystemStructure.ssd"
STEP = 1e-3  # s, where nobody says another one
VERSIONS = ("1.", "2.")


class Package:
    """An opened .ssp; its FMUs lie in `folder` until it is removed."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.folder = tempfile.TemporaryDirectory(prefix="dct-harness-ssp-")
        try:
            with opened(path) as archive:
                extract(path, archive, Path(self.folder.name))
            self._root = self._xml(STRUCTURE)
            version = self._root.get("version", "")
            if not version.startswith(VERSIONS):
                raise ConfigError(f"{path}: is of SSP version '{version}'; known are 1.0 and 2.0")
            self._flat = Structure(path, self._root)
        except BaseException:
            self.folder.cleanup()
            raise
        self.paths: dict[str, Path] = {}
        self._bound: dict[Node, tuple[str, units.Unit | None, Transform]] = {}

    def _xml(self, name: str) -> Element:
        text = self._member(name).read_bytes()
        refuse_doctype(self.path, text, name)
        try:
            return ElementTree.fromstring(text)
        except ElementTree.ParseError as error:
            raise FmuInvalidError(f"{self.path}: {name}: {error}") from error

    def _member(self, name: str) -> Path:
        """Return a file of the archive."""
        file = (Path(self.folder.name) / name).resolve()
        if not file.is_relative_to(Path(self.folder.name).resolve()) or not file.is_file():
            raise ConfigError(f"{self.path}: has no '{name}'")
        return file

    def system(self, scenario: Path | None, step: float | None, stop: float | None) -> System:
        """Return the system.

        A stop time comes from the command line or the DefaultExperiment; scenario, step and the
        like from the command line or the annotation that `export-ssp` writes.
        """
        told = self._stop()
        if stop is None and told is None:
            raise ConfigError(f"{self.path}: says no stopTime; give --stop SECONDS")
        components = {n: self._component(n, e) for n, e in self._flat.components.items()}
        self._flat.connect()
        self._bind_all(components)
        connections, transforms = self._connections(components)
        notes = self._notes()
        scenario = scenario or self._scenario(notes)
        if scenario is None and any(s.startswith("scenario.") for s in connections.values()):
            raise ConfigError(f"{self.path}: has inputs of its own; give --scenario FILE.csv")
        for note in (e for e in notes if tag(e) == "Substeps"):
            component = note.get("component", "")
            if component not in components:
                raise ConfigError(f"{self.path}: Substeps: no component '{component}'")
            components[component].substeps = whole(self.path, note, "count", "1")
        name = self._flat.root.get("name") or self.path.stem
        return System(
            name, notes.get("title", name),
            step or real(self.path, "step", notes.get("step", str(STEP))),
            float(stop if stop is not None else told or 0), scenario, components, connections,
            self.path, [self._limit(e) for e in notes if tag(e) == "Limit"],
            notes.get("coupling", "gauss-seidel"), notes.get("interpolate") == "true",
            explicit=True, transforms=transforms,
        )  # fmt: skip

    def _stop(self) -> float | None:
        experiment = one(self._root, "DefaultExperiment")
        told = experiment.get("stopTime") if experiment is not None else None
        return None if told is None else real(self.path, "stopTime", told)

    def _notes(self) -> Element:
        """Return what `export-ssp` has noted; an empty element if nothing."""
        for note in every(self._root, "Annotations", "Annotation"):
            if note.get("type") == "dct-harness" and len(note):
                return note[0]
        return Element("Run")

    def _scenario(self, notes: Element) -> Path | None:
        name = notes.get("scenario")
        return None if name is None else self._member(name)

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

    def _component(self, name: str, element: Element) -> Component:
        source = element.get("source", "")
        file = (Path(self.folder.name) / source).resolve()
        if not file.is_relative_to(Path(self.folder.name).resolve()) or not file.is_file():
            raise ConfigError(f"{self.path}: component '{name}' has no file '{source}' inside")
        self.paths[name] = file
        self._flat.descriptions[name] = described(file)
        return Component(source)

    def _connections(
        self, components: dict[str, Component]
    ) -> tuple[dict[str, str], dict[str, Transform]]:
        """Return sources and transforms by input; what is bound to connectors becomes a value."""
        connections: dict[str, str] = {}
        transforms: dict[str, Transform] = {}
        for taker, feed in self._flat.feeds():
            change, source = self._flat.change(feed), feed.source
            if source in self._bound:
                self._pass_on(source, taker, change, components)
            elif source.element in components or source.element == "":
                connections[str(taker)] = f"{source.element or 'scenario'}.{source.connector}"
                if change.changes:
                    transforms[str(taker)] = change
        return connections, transforms

    def _pass_on(
        self, source: Node, taker: Node, change: Transform, components: dict[str, Component]
    ) -> None:
        """Give a component the value that is bound to a connector of a system around it."""
        text, given, mapped = self._bound[source]
        variable = self._flat.variable(taker)
        if variable.type not in ("Real", "Integer"):
            value: Any = self._value(taker, variable, text, None, Transform())
        else:
            number = real(self.path, str(source), text)
            unit_there = self._flat.unit(source)
            if given and unit_there:
                number = Transform(*units.conversion(given, unit_there)).at(number)
            value = KINDS[group_of(variable)](change.at(mapped.at(number)))
        components[taker.element].parameters[taker.connector] = value

    def _bind_all(self, components: dict[str, Component]) -> None:
        """Put all parameter sets into the components; those of outer systems count more."""
        for name, element in self._flat.components.items():
            self._bind(element, name, components)
        for name in sorted(self._flat.systems, key=lambda n: -n.count("/") if n else 1):
            self._bind(self._flat.systems[name], name, components)

    def _bind(self, element: Element, base: str, components: dict[str, Component]) -> None:
        """Put the parameter sets of a component or system into what they name."""
        for binding in every(element, "ParameterBindings", "ParameterBinding"):
            values = self._values(binding)
            for source, target, change in self._mapping(binding, values):
                name = f"{binding.get('prefix', '')}{target}"
                node = self._named(base, name)
                text, given = values[source]
                if node.element in components:
                    variable = self._flat.variable(node)
                    value = self._value(node, variable, text, given, change)
                    components[node.element].parameters[node.connector] = value
                else:
                    self._bound[node] = text, given, change

    def _named(self, base: str, name: str) -> Node:
        """Return the connector that a hierarchical name means, seen from an element."""
        if base in self._flat.components:
            return Node(base, name)
        inside = f"{base}/" if base else ""
        found = [c for c in (*self._flat.components, *self._flat.systems) if c.startswith(inside)
                 and c and name.startswith(f"{c[len(inside):].replace('/', '.')}.")]  # fmt: skip
        if found:
            best = max(found, key=len)
            return Node(best, name[len(best) - len(inside) + 1 :])
        connectors = every(self._flat.systems[base], "Connectors", "Connector")
        known = [c.get("name", "") for c in connectors]
        if name not in known:
            hint = did_you_mean(name, (*known, *self._flat.components))
            raise ConfigError(f"{self.path}: parameter '{name}': no such component.{hint}")
        return Node(base, name)

    def _values(self, binding: Element) -> dict[str, tuple[str, units.Unit | None]]:
        """Return name -> text and unit of a parameter set."""
        inline = one(binding, "ParameterValues")
        root = inline[0] if inline is not None and len(inline) else None
        if root is None:
            root = self._xml(binding.get("source", ""))
        known = {u.get("name"): unit(self.path, u) for u in every(root, "Units", "Unit")}
        found = {}
        for parameter in every(root, "Parameters", "Parameter"):
            for value in (v for v in parameter if tag(v) != "Annotations"):
                name = value.get("unit")
                text = value.get("value", value.get("name", ""))
                found[parameter.get("name", "")] = (
                    text,
                    known.get(name) or (units.find(name) if name else None),
                )
        return found

    def _mapping(
        self, binding: Element, values: dict[str, Any]
    ) -> list[tuple[str, str, Transform]]:
        """Return source, target and transform of each parameter that is bound."""
        mapping = one(binding, "ParameterMapping")
        if mapping is None:
            return [(name, name, Transform()) for name in values]
        root = self._xml(mapping.get("source", "")) if mapping.get("source") else mapping
        found = []
        for entry in (e for e in root.iter() if tag(e) == "MappingEntry"):
            source, target = entry.get("source", ""), entry.get("target", "")
            if source not in values:
                hint = did_you_mean(source, values)
                raise ConfigError(f"{self.path}: mapping: no parameter '{source}'.{hint}")
            found.append((source, target, self._told(entry, source)))
        return found

    def _told(self, entry: Element, source: str) -> Transform:
        words = {"true": "1", "false": "0"}

        def number(text: str | None) -> float:
            return real(self.path, source, words.get(text or "", text))

        return transformation(self.path, entry, number, number)

    def _value(
        self, node: Node, variable: Any, text: str, given: units.Unit | None, change: Transform
    ) -> Any:
        """Return a bound value as the FMU takes it."""
        if variable.type == "Enumeration" or group_of(variable) == "String":
            return text
        if group_of(variable) == "Boolean":
            true = text in ("true", "1")
            return bool(change.at(float(true))) if change.table else true
        value = real(self.path, str(node), text)
        theirs = self._flat.unit(node) if variable.type == "Real" else None
        if given and theirs:
            try:
                a, b = units.conversion(given, theirs)
            except ValueError as error:
                raise ConfigError(f"{self.path}: parameter '{node}': {error}") from error
            value = a * value + b
        return KINDS[group_of(variable)](change.at(value))

    def _limit(self, element: Element) -> dict[str, Any]:
        """Return a limit of a KPI, as a system file has it."""
        return {k: real(self.path, k, v) if k in ("min", "max") else v
                for k, v in element.attrib.items()}  # fmt: skip
