"""A system, with its scenario, limits and the mapping of a supplier's plant, as one SSP 1.0 file.

Reading it back gives the same results, bit for bit. What SSP has no words for (step, order of
coupling, substeps, limits of KPIs, where the scenario is) stands in an annotation of type
`dct-harness` that other tools pass over.
"""

from __future__ import annotations

import hashlib
import zipfile
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

from ..master.resolved import Resolved, Wire
from ..supplier.mapping import Mapping
from ..system.system import System
from . import ssd_xml as xml
from .ssd_xml import Dictionary, sub

ANNOTATION = "dct-harness"
SCENARIO = "resources/scenario.csv"
FMU = "application/x-fmu-sharedlibrary"
EPOCH = (1980, 1, 1, 0, 0, 0)  # same input, same bytes


class Export(Resolved):
    """One system, resolved as a run would resolve it; no library is loaded."""

    def __init__(self, system: System, paths: dict[str, Path], mapping: Mapping | None) -> None:
        super().__init__(system, paths, mapping)
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
            if (values := self._values(name)) is not None:
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
        wires = [self.wire(target) for target in self.sources]
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
            variables = [self.ours(w.target) for w in taken]
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
                 or self.target(f"{name}.{v.name}") in steered]  # fmt: skip
        listed = sub(one, "ssd:Connectors") if shown else one
        for variable in shown:
            unit = self._unit(f"{name}.{variable.name}")
            xml.connector(listed, variable.name, variable.causality, variable, unit, self.known)
        if self.values(name):
            bindings = sub(one, "ssd:ParameterBindings")
            sub(bindings, "ssd:ParameterBinding", source=_set(name))

    def _unit(self, end: str) -> str | None:
        component = end.partition(".")[0]
        variable = self.variable(end)
        if variable.type != "Real":
            return None
        return self.known.unit(self.raw[component].description, variable)

    def _values(self, name: str) -> Element | None:
        """Return the parameter set of a component, by its FMU's own names; None if empty."""
        given = self.values(name)
        if not given:
            return None
        # One name for the sets of all components: ecos applies those of one name at a time.
        head = {"version": "1.0", "name": self.system.name}
        root = Element(xml.tag("ssv:ParameterSet"), head)
        listed = sub(root, "ssv:Parameters")
        for variable, value in given.items():
            xml.parameter(listed, self.raw[name].variables[variable], value)
        return root

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
                given = self.ours(wire.target) if scripted else self.variable(wire.source)
                xml.transformation(one, wire.change, given, self.variable(wire.target))

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
