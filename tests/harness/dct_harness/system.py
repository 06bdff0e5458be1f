"""System file: components, scenario, step; read, checked against the schema, overridden."""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Any

import jsonschema

from . import parameters
from .errors import ConfigError, did_you_mean
from .kpi.registry import BY_KEY
from .transforms import Transform

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

Value = float | int | bool | str
ORDER = ("plant", "observer", "control")


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
    explicit: bool = False  # no connections by equal names; other inputs keep their start values
    transforms: dict[str, Transform] = field(default_factory=dict)  # by input

    def override(self, text: str) -> None:
        """Apply one `component.variable=value` of the command line."""
        key, equals, value = text.partition("=")
        component, dot, variable = key.strip().partition(".")
        if not (equals and dot and variable):
            raise ConfigError(f"--set {text}: write component.variable=value")
        if component not in self.components:
            hint = did_you_mean(component, self.components)
            raise ConfigError(f"--set {text}: {self.path} has no component '{component}'.{hint}")
        self.components[component].parameters[variable] = _parse(value.strip())

    def as_dict(self) -> dict[str, Any]:
        """Return the effective content, for `run.json`."""
        parts = {
            n: {"fmu": c.fmu, "parameters": c.parameters, "substeps": c.substeps}
            for n, c in self.components.items()
        }
        return {
            "name": self.name, "title": self.title, "step": self.step, "stop": self.stop,
            "file": str(self.path), "scenario": str(self.scenario or ""), "components": parts,
            "connections": [{"from": s, "to": t} for t, s in self.connections.items()],
            "kpis": self.kpis, "coupling": self.coupling,
        }  # fmt: skip


def _parse(text: str) -> Value:
    """Read a TOML value; anything else is a string."""
    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text
    return value if isinstance(value, (bool, int, float, str)) else text


def load(path: Path) -> System:
    """Read and check a system file; errors name file, key and remedy."""
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(f"{path}: cannot read the system file: {error.strerror}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path}: is not valid TOML: {error}") from error
    _validate(path, data)
    head = data["system"]
    components = {n: Component(c["fmu"], parameters.gather(path, c.get("parameters", {})),
                               c.get("substeps", 1))
                  for n, c in sorted(data["components"].items(), key=_rank)}  # fmt: skip
    targets = [c["to"] for c in data.get("connections", [])]
    for target in targets:
        if targets.count(target) > 1:
            raise ConfigError(f"{path}: connections: '{target}' has two sources; keep one")
    _check_kpis(path, data.get("kpis", []))
    return System(
        head["name"], head.get("title", head["name"]), float(head["step"]), float(head["stop"]),
        path.parent / head["scenario"], components,
        {c["to"]: c["from"] for c in data.get("connections", [])}, path,
        data.get("kpis", []), head.get("coupling", "gauss-seidel"),
    )  # fmt: skip


def _check_kpis(path: Path, limits: list[dict[str, Any]]) -> None:
    """Refuse a limit on a KPI that does not exist."""
    for limit in limits:
        if limit["kpi"] not in BY_KEY:
            hint = did_you_mean(limit["kpi"], BY_KEY)
            raise ConfigError(f"{path}: kpis: no KPI '{limit['kpi']}'.{hint}")


def _rank(item: tuple[str, Any]) -> int:
    """Order plant, observer, control first; others keep the order of the file."""
    return ORDER.index(item[0]) if item[0] in ORDER else len(ORDER)


def _validate(path: Path, data: dict[str, Any]) -> None:
    text = resources.files(__package__).joinpath("schema/system.schema.json").read_text("utf-8")
    schema = json.loads(text)
    error = jsonschema.exceptions.best_match(
        jsonschema.Draft202012Validator(schema).iter_errors(data)
    )
    if error is None:
        return
    hint = ""
    if error.validator == "additionalProperties":
        known = error.schema.get("properties", {})
        extra = next((k for k in error.instance if k not in known), "")
        hint = did_you_mean(extra, known)
    key = ".".join(str(part) for part in error.absolute_path) or "(top level)"
    raise ConfigError(f"{path}: {key}: {error.message}.{hint}")
