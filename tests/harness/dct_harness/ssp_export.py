"""A system, with its scenario, limits and the mapping of a supplier's plant, as one SSP 1.0 file.

Reading it back gives the same results, bit for bit. What SSP has no words for (step, order of
coupling, substeps, limits of KPIs, where the scenario is) stands in an annotation of type
`dct-harness` that other tools pass over.
"""

from __future__ import annotations

import hashlib
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement

from . import scenario as scenarios
from . import ssd_xml as xml
from .connections import check_types, resolve, transforms
from .errors import ConfigError
from .links import Link
from .mapped import Mapped, apply_shared, their_value
from .mapping import Mapping
from .ports import Ports
from .ssd_xml import Dictionary, sub
from .system import System
from .transforms import Transform

ANNOTATION = "dct-harness"
SCENARIO = "resources/scenario.csv"
FMU = "application/x-fmu-sharedlibrary"
EPOCH = (1980, 1, 1, 0, 0, 0)  # same input, same bytes


@dataclass(frozen=True)
class Wire:
    """A connection as SSP has it: variables of the FMUs themselves, and what changes a value."""

    source: str
    target: str
    change: Transform
    told: bool  # the transformation is all; units are not converted besides


class Export:
    """One system, resolved as a run would resolve it; no library is loaded."""

    def __init__(self, system: System, paths: dict[str, Path], mapping: Mapping | None) -> None:
        self.system, self.paths = system, paths
        self.raw = {name: Ports(name, path) for name, path in paths.items()}
        self.ports: dict[str, Any] = {n: Ports(n, p) for n, p in paths.items()}
        if mapping is not None:
            self.ports["plant"] = Mapped(self.ports["plant"], mapping)
            given = {n: c.parameters for n, c in system.components.items()}
            apply_shared(mapping, self.ports["plant"], self.ports, given)
        self.script = scenarios.load(system.scenario)
        for port in self.ports.values():
            port.steer(self.script.signals)
        self.sources = resolve(system, self.ports, list(self.script.signals))
        check_types(system, self.ports, self.sources, self.script)
        self.changes = transforms(system, self.ports, self.sources)
        self.known = Dictionary()

    def write(self, out: Path) -> None:
        """Write the file whole."""
        out.parent.mkdir(parents=True, exist_ok=True)
        members = self._members()
        part = out.with_name(out.name + ".part")
        with zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, content in members.items():
                info = zipfile.ZipInfo(name, EPOCH)
                info.external_attr = 0o644 << 16
                info.compress_type = (
                    zipfile.ZIP_STORED if name.endswith(".fmu") else zipfile.ZIP_DEFLATED
                )
                archive.writestr(info, content)
        part.replace(out)

    def _members(self) -> dict[str, bytes]:
        found = {}
        files = self._files()
        found["SystemStructure.ssd"] = xml.document(self._structure(files))
        for name, file in files.items():
            found.setdefault(file, self.paths[name].read_bytes())
            if values := self._values(name):
                found[_set(name)] = xml.document(values)
        if self.system.scenario is not None:
            found[SCENARIO] = self.system.scenario.read_bytes()
        return found

    def _files(self) -> dict[str, str]:
        """Return component -> member; components of one FMU share it."""
        found: dict[str, str] = {}
        digests: dict[str, str] = {}
        for name, path in self.paths.items():
            digest = hashlib.sha256(path.read_bytes()).hexdigest()
            member = f"resources/{path.name}"
            if digests.get(member, digest) != digest:
                member = f"resources/{name}-{path.name}"
            digests[member] = digest
            found[name] = member
        return found

    def _structure(self, files: dict[str, str]) -> Element:
        head = {"version": "1.0", "name": self.system.name, "generationTool": "dct-harness"}
        root = Element(xml.tag("ssd:SystemStructureDescription"), head)
        system = sub(root, "ssd:System", name=self.system.name, description=self.system.title)
        wires = [self._wire(target) for target in self.sources]
        self._inputs(system, wires)
        elements = sub(system, "ssd:Elements")
        for name, file in files.items():
            self._component(elements, name, file)
        self._connections(system, wires)
        self.known.write(root)
        sub(root, "ssd:DefaultExperiment", startTime=0.0, stopTime=self.system.stop)
        self._annotation(root)
        return root

    def _inputs(self, system: Element, wires: list[Wire]) -> None:
        """Add a connector for each column of the scenario that is used."""
        fed: dict[str, list[Wire]] = {}
        for wire in wires:
            component, _, column = wire.source.partition(".")
            if component == "scenario":
                fed.setdefault(column, []).append(wire)
        listed = sub(system, "ssd:Connectors") if fed else system
        for column, taken in fed.items():
            variables = [self._ours(w.target) for w in taken]
            units = {self._unit(w.target) for w in taken}
            unit = units.pop() if len(units) == 1 and not taken[0].told else None
            kind = "parameter" if variables[0].causality == "parameter" else "input"
            xml.connector(listed, column, kind, variables[0], unit, self.known)

    def _component(self, elements: Element, name: str, file: str) -> None:
        one = sub(elements, "ssd:Component", name=name, type=FMU, source=file,
                  implementation="CoSimulation")  # fmt: skip
        steered = {t for t in self.sources if t.startswith(f"{name}.")}
        port = self.raw[name]
        shown = [v for v in port.description.modelVariables if v.causality in ("input", "output")
                 or self._target(f"{name}.{v.name}") in steered]  # fmt: skip
        listed = sub(one, "ssd:Connectors") if shown else one
        for variable in shown:
            unit = self._unit(f"{name}.{variable.name}")
            xml.connector(listed, variable.name, variable.causality, variable, unit, self.known)
        if self._values(name):
            bindings = sub(one, "ssd:ParameterBindings")
            sub(bindings, "ssd:ParameterBinding", source=_set(name))

    def _target(self, end: str) -> str:
        """Return the name under which a run knows an input of an FMU."""
        component, _, name = end.partition(".")
        port = self.ports[component]
        links = port.into if isinstance(port, Mapped) else []
        ours = next((k.ours.name for k in links if k.theirs.name == name), name)
        return f"{component}.{ours}"

    def _ours(self, end: str) -> Any:
        """Return the variable that a run has in place of an FMU's own input."""
        component, _, name = self._target(end).partition(".")
        return next(v for v in self.ports[component].inputs if v.name == name)

    def _variable(self, end: str) -> Any:
        component, _, name = end.partition(".")
        return self.raw[component].variables[name]

    def _unit(self, end: str) -> str | None:
        component = end.partition(".")[0]
        variable = self._variable(end)
        if variable.type != "Real":
            return None
        return self.known.unit(self.raw[component].description, variable)

    def _values(self, name: str) -> Element | None:
        """Return the parameter set of a component, by its FMU's own names; None if empty."""
        given = self.system.components[name].parameters
        port, raw = self.ports[name], self.raw[name]
        named = dict(their_value(port, n, v) for n, v in given.items())
        if not named:
            return None
        # One name for the sets of all components: ecos applies those of one name at a time.
        head = {"version": "1.0", "name": self.system.name}
        root = Element(xml.tag("ssv:ParameterSet"), head)
        listed = sub(root, "ssv:Parameters")
        for variable, value in named.items():
            raw.check_start(variable, value)
            xml.parameter(listed, raw.variables[variable], value)
        return root

    def _wire(self, target: str) -> Wire:
        """Return the connection to an input, in terms of the FMUs' own variables."""
        source = self.sources[target]
        start, before = self._end(source, "output")
        end, after = self._end(target, "input")
        own = self.changes.get(target, Transform())
        told = target in self.system.transforms or before is not None or after is not None
        if not told:
            return Wire(start, end, Transform(), False)
        try:
            change = (before or Transform()).then(own).then(after or Transform())
        except ValueError as error:
            raise ConfigError(f"{self.system.path}: '{source}' to '{target}': {error}") from error
        return Wire(start, end, change, True)

    def _end(self, end: str, side: str) -> tuple[str, Transform | None]:
        """Return an FMU's own variable, and what lies between it and ours: outward for inputs."""
        component, _, name = end.partition(".")
        port = self.ports.get(component)
        if not isinstance(port, Mapped):
            return end, None
        if side == "output":
            link, weight = port.link_of_output(name)
            return f"{component}.{link.theirs.name}", _inward(link).then(Transform(weight))
        link = next(k for k in port.into if k.ours.name == name)
        return f"{component}.{link.theirs.name}", _outward(link)

    def _connections(self, system: Element, wires: list[Wire]) -> None:
        listed = sub(system, "ssd:Connections") if wires else system
        for wire in wires:
            giver, _, source = wire.source.partition(".")
            taker, _, target = wire.target.partition(".")
            one = sub(
                listed, "ssd:Connection",
                startElement=giver if giver != "scenario" else None, startConnector=source,
                endElement=taker, endConnector=target,
                suppressUnitConversion=True if wire.told else None,
            )  # fmt: skip
            if wire.change.changes:
                scripted = giver == "scenario"
                given = self._ours(wire.target) if scripted else self._variable(wire.source)
                xml.transformation(one, wire.change, given, self._variable(wire.target))

    def _annotation(self, root: Element) -> None:
        """Add what a run needs beside SSP."""
        model = self.system
        listed = sub(root, "ssd:Annotations")
        note = sub(listed, "ssc:Annotation", type=ANNOTATION)
        run = SubElement(note, f"{{{xml.RUN}}}Run", {
            "step": repr(model.step), "coupling": model.coupling,
            "interpolate": xml.text(model.interpolate), "title": model.title,
            **({"scenario": SCENARIO} if model.scenario is not None else {}),
        })  # fmt: skip
        for name, component in model.components.items():
            if component.substeps != 1:
                given = {"component": name, "count": str(component.substeps)}
                SubElement(run, f"{{{xml.RUN}}}Substeps", given)
        for limit in model.kpis:
            SubElement(run, f"{{{xml.RUN}}}Limit", {k: xml.text(v) for k, v in limit.items()})


def _set(name: str) -> str:
    return f"resources/{name}.ssv"


def _inward(link: Link) -> Transform:
    """Return what makes our value of theirs."""
    return Transform(link.gain, link.shift, {t: o for o, t in link.table})


def _outward(link: Link) -> Transform:
    """Return what makes their value of ours; of several codes of theirs the first is sent."""
    table = dict(reversed(link.table))
    return Transform(1 / link.gain, -link.shift / link.gain, table)
