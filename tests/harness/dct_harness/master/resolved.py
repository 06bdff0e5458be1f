"""A system as a run resolves it, in terms of the FMUs' own variables; no library is loaded."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import ConfigError
from ..fmu.ports import Ports
from ..supplier.links import Link
from ..supplier.mapped import Mapped, apply_shared, their_value
from ..supplier.mapping import Mapping
from ..system import scenario as scenarios
from ..system.system import NOISE, System
from ..system.transforms import Transform
from .connections import check_types, resolve, transforms


@dataclass(frozen=True)
class Wire:
    """A connection as SSP has it: variables of the FMUs themselves, and what changes a value."""

    source: str
    target: str
    change: Transform
    told: bool  # the transformation is all; units are not converted besides


class Resolved:
    """A system with its sources, and what a mapping file says of a supplier's plant worked in."""

    def __init__(self, system: System, paths: dict[str, Path], mapping: Mapping | None) -> None:
        self.system, self.paths = system, paths
        if any(system.noise.values()):
            raise ConfigError(f"{system.at(NOISE)}: {NOISE}: what is exported has none; "
                              "leave it out")  # fmt: skip
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

    def target(self, end: str) -> str:
        """Return the name under which a run knows an input of an FMU."""
        component, _, name = end.partition(".")
        port = self.ports[component]
        links = port.into if isinstance(port, Mapped) else []
        ours = next((k.ours.name for k in links if k.theirs.name == name), name)
        return f"{component}.{ours}"

    def ours(self, end: str) -> Any:
        """Return the variable that a run has in place of an FMU's own input."""
        component, _, name = self.target(end).partition(".")
        return next(v for v in self.ports[component].inputs if v.name == name)

    def variable(self, end: str) -> Any:
        component, _, name = end.partition(".")
        return self.raw[component].variables[name]

    def values(self, name: str) -> dict[str, Any]:
        """Return the values that a component is given, by its FMU's own names."""
        port, raw = self.ports[name], self.raw[name]
        given = self.system.components[name].parameters
        named = dict(their_value(port, n, v) for n, v in given.items())
        return {n: raw.check_start(n, v) for n, v in named.items()}

    def wire(self, target: str) -> Wire:
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


def _inward(link: Link) -> Transform:
    """Return what makes our value of theirs."""
    return Transform(link.gain, link.shift, {t: o for o, t in link.table})


def _outward(link: Link) -> Transform:
    """Return what makes their value of ours; of several codes of theirs the first is sent."""
    table = dict(reversed(link.table))
    return Transform(1 / link.gain, -link.shift / link.gain, table)
