"""System file: components, scenario, step; read, checked against the schema, overridden."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ..errors import ConfigError, did_you_mean
from ..kpi.estimation import ESTIMATES
from ..kpi.registry import BY_KEY
from . import parameters, tomlfile
from .tomlplaces import Places
from .transforms import Transform

Value = float | int | bool | str
ORDER = ("plant", "observer", "control")
NOISE, SEED = "noise", "seed"


@dataclass
class Component:
    """One FMU: its file as written, and parameter or start values by variable name."""

    fmu: str
    parameters: dict[str, Value] = field(default_factory=dict)
    substeps: int = 1  # equal steps of this component in a communication step


@dataclass
class System:
    """A checked system file; `step`, `stop` in s, `connections` input -> source, `kpis` limits."""

    name: str
    title: str
    step: float
    stop: float
    scenario: Path | None
    components: dict[str, Component]
    connections: dict[str, str]
    path: Path
    kpis: list[dict[str, Any]] = field(default_factory=list)
    coupling: str = "gauss-seidel"
    interpolate: bool = False  # inputs have slopes where the FMU can follow
    explicit: bool = False  # no connections by equal names; other inputs keep their start values
    transforms: dict[str, Transform] = field(default_factory=dict)  # by input
    places: Places = field(default_factory=Places)  # of the keys in the file
    overridden: set[tuple[str, str]] = field(default_factory=set)  # component, variable
    files: list[Path] = field(default_factory=list)  # parameter files that it names
    noise: dict[str, float] = field(default_factory=dict)  # output -> standard deviation
    seed: int = 0  # of the noise

    def copy(self) -> System:
        """Return a system whose values can be overridden without changing those of this one."""
        components = {n: replace(c, parameters=dict(c.parameters))
                      for n, c in self.components.items()}  # fmt: skip
        return replace(self, components=components, overridden=set(self.overridden),
                       noise=dict(self.noise))  # fmt: skip

    def at(self, *keys: str | int) -> str:
        """Return `file:line:column` of a key, or of the nearest one above it."""
        return tomlfile.where(self.path, self.places, *keys)

    def at_connection(self, target: str, end: str) -> str:
        """Return where `from` or `to` of the connection to an input stands."""
        return self.at("connections", list(self.connections).index(target), end)

    def at_parameter(self, component: str, name: str) -> str | None:
        """Return where the file gives the value of a component; None if it does not."""
        if (component, name) in self.overridden:
            return None
        head = ("components", component, "parameters")
        found = [keys for keys in self.places if keys[:3] == head and keys[-1] == name]
        return self.at(*found[-1]) if found else None

    def override(self, text: str) -> None:
        """Apply one `component.variable=value` of the command line."""
        key, equals, value = text.partition("=")
        component, dot, variable = key.strip().partition(".")
        if not (equals and dot and variable):
            raise ConfigError(f"--set {text}: write component.variable=value")
        if component == NOISE:
            self._override_noise(text, variable, parse_value(value.strip()))
            return
        if component not in self.components:
            known = ", ".join(self.components)
            hint = did_you_mean(component, self.components)
            hint = hint or f" Write COMPONENT.{key.strip()}, with one of these before it."
            what = f"{self.path} has no component '{component}' ({known}).{hint}"
            raise ConfigError(f"--set {text}: {what}")
        self.components[component].parameters[variable] = parse_value(value.strip())
        self.overridden.add((component, variable))

    def _override_noise(self, text: str, name: str, value: Value) -> None:
        """Set the seed, or the standard deviation of an output."""
        right = type(value) is int if name == SEED else type(value) in (int, float)
        if not right or float(value) < 0:
            what = "a whole number" if name == SEED else "a standard deviation"
            raise ConfigError(f"--set {text}: {name} is {what} of at least 0")
        if name == SEED:
            self.seed = int(value)
        else:
            self.noise[name] = float(value)

    def as_dict(self) -> dict[str, Any]:
        """Return the effective content, for `run.json`."""
        parts = {
            n: {"fmu": c.fmu, "parameters": c.parameters, "substeps": c.substeps}
            for n, c in self.components.items()
        }
        return {
            "name": self.name, "title": self.title, "step": self.step, "stop": self.stop,
            "file": str(self.path), "scenario": str(self.scenario or ""), "components": parts,
            "connections": [{"from": s, "to": t, **self.transforms.get(t, Transform()).as_dict()}
                            for t, s in self.connections.items()],
            "kpis": self.kpis, "coupling": self.coupling, "interpolate": self.interpolate,
            "noise": {SEED: self.seed, **self.noise} if self.noise else {},
        }  # fmt: skip


def parse_value(text: str) -> Value:
    """Read a TOML value; anything else is a string."""
    try:
        value = tomlfile.loads(f"value = {text}")["value"]
    except tomlfile.TOMLDecodeError:
        return text
    return value if isinstance(value, (bool, int, float, str)) else text


def load(path: Path) -> System:
    """Read and check a system file; errors name file, line, column, key and remedy."""
    document = tomlfile.read(path, "system file", "system.schema.json")
    data = document.data
    head = data["system"]
    components = {n: Component(c["fmu"], parameters.gather(path, c.get("parameters", {})),
                               c.get("substeps", 1))
                  for n, c in sorted(data["components"].items(), key=_rank)}  # fmt: skip
    _check_targets(document)
    _check_kpis(document)
    noise = dict(data.get(NOISE, {}))
    return System(
        head["name"], head.get("title", head["name"]), float(head["step"]), float(head["stop"]),
        path.parent / head["scenario"], components,
        {c["to"]: c["from"] for c in data.get("connections", [])}, path,
        data.get("kpis", []), head.get("coupling", "gauss-seidel"),
        head.get("interpolate", False), places=document.places,
        transforms=_transforms(data.get("connections", [])),
        seed=noise.pop(SEED, 0), noise={n: float(d) for n, d in noise.items()},
        files=[f for c in data["components"].values()
               for f in parameters.files(path, c.get("parameters", {}))],
    )  # fmt: skip


def _transforms(connections: list[dict[str, Any]]) -> dict[str, Transform]:
    """Return what [[connections]] entries say of values on their way, by input."""
    told = (c for c in connections if "factor" in c or "offset" in c)
    return {c["to"]: Transform(float(c.get("factor", 1)), float(c.get("offset", 0))) for c in told}


def _check_targets(document: tomlfile.Document) -> None:
    """Refuse an input with two sources."""
    targets = [c["to"] for c in document.data.get("connections", [])]
    for k, target in enumerate(targets):
        if target in targets[:k]:
            first = document.at("connections", targets.index(target), "to")
            raise ConfigError(
                f"{document.at('connections', k, 'to')}: connections: '{target}' has two sources "
                f"(the other one: {first}); keep one"
            )


def _check_kpis(document: tomlfile.Document) -> None:
    """Refuse a limit on a KPI or an estimate that does not exist."""
    estimates = list(dict.fromkeys([*ESTIMATES, *document.data["components"]]))
    for k, limit in enumerate(document.data.get("kpis", [])):
        by = limit.get("estimate", "")
        if by and by not in estimates:
            where, hint = document.at("kpis", k, "estimate"), did_you_mean(by, estimates)
            raise ConfigError(f"{where}: kpis: no estimate '{by}' ({', '.join(estimates)}).{hint}")
        if limit["kpi"] not in BY_KEY:
            hint = did_you_mean(limit["kpi"], BY_KEY)
            where = document.at("kpis", k, "kpi")
            raise ConfigError(f"{where}: kpis: no KPI '{limit['kpi']}'.{hint}")


def _rank(item: tuple[str, Any]) -> int:
    """Order plant, observer, control first; others keep the order of the file."""
    return ORDER.index(item[0]) if item[0] in ORDER else len(ORDER)
