"""Mapping file: which of a supplier's variables stands for which of DctPlant's, and how.

ours = factor * theirs + offset      both in SI; units are converted by the harness
table: our value or item = the supplier's value or item
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..contract import Contract
from ..contract import plant as plant_contract
from ..errors import ConfigError, did_you_mean
from ..system import tomlfile
from ..system.system import ORDER, System, Value

# Output -> output it follows from, and the exponent of the wheel radius in V = r_w omega_w.
DERIVED = {"wheel.speed": ("vehicle.speed", -1), "vehicle.speed": ("wheel.speed", 1)}


@dataclass(frozen=True)
class Entry:
    """One variable of ours; exactly one of `variable`, `terms` says where it comes from."""

    name: str
    variable: str = ""
    unit: str = ""
    factor: float = 1.0
    offset: float = 0.0
    table: dict[str, Any] = field(default_factory=dict)
    terms: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True)
class Mapping:
    """A checked mapping file."""

    path: Path
    inputs: dict[str, Entry]
    outputs: dict[str, Entry]
    extra: dict[str, Entry]
    parameters: dict[str, Entry]
    values: dict[str, dict[str, Value]]
    known: dict[str, Value]
    share: list[str]
    ignore: list[str]

    def apply(self, system: System) -> None:
        """Put the mapping's values into a system, above those of its file."""
        for name in (*self.values, *self.share):
            if name not in system.components and name not in ORDER:
                hint = did_you_mean(name, (*system.components, *ORDER))
                raise ConfigError(f"{self.path}: {system.path} has no component '{name}'.{hint}")
        plant = system.components["plant"].parameters
        for name in self.ignore:
            plant.pop(name, None)
        for name, values in self.values.items():
            if name in system.components:
                system.components[name].parameters.update(values)


def load(path: Path) -> Mapping:
    """Read and check a mapping file; errors name file, line, key and remedy."""
    data = tomlfile.read(path, "mapping", "mapping.schema.json").data
    contract = plant_contract()
    tables = {}
    for section in ("inputs", "outputs", "extra", "parameters"):
        tables[section] = {n: _entry(path, section, n, e) for n, e in data.get(section, {}).items()}
    for section in ("inputs", "outputs", "parameters"):
        _check_names(path, section, tables[section], contract)
    _check_terms(path, tables["outputs"])
    return Mapping(
        path, tables["inputs"], tables["outputs"], tables["extra"], tables["parameters"],
        data.get("values", {}), data.get("known", {}), data.get("share", []),
        data.get("ignore", []),
    )  # fmt: skip


def _entry(path: Path, section: str, name: str, given: str | dict[str, Any]) -> Entry:
    if isinstance(given, str):
        return Entry(name, given)
    if "variable" in given:
        return Entry(name, **{"table": {}, **given})
    if section != "outputs":
        raise ConfigError(f"{path}: {section}.{name}: only an output can be derived")
    if "difference" in given:
        first, second = given["difference"]
        return Entry(name, terms=((first, 1.0), (second, -1.0)))
    return Entry(name, terms=(_derived(path, name, given),))


def _derived(path: Path, name: str, given: dict[str, Any]) -> tuple[str, float]:
    source, power = DERIVED.get(name, ("", 0))
    if given["derive"] != source or "radius" not in given:
        ways = "; ".join(f'"{n}" from "{s}" with radius' for n, (s, _) in DERIVED.items())
        raise ConfigError(f"{path}: outputs.{name}: can be derived: {ways}")
    return source, given["radius"] ** power


def _check_names(
    path: Path, section: str, entries: dict[str, Entry], contract: Contract
) -> None:  # fmt: skip
    """Refuse a name that DctPlant does not have, or has as something else."""
    known = contract.of(section.removesuffix("s"))
    for name in entries:
        if name not in known:
            remedy = " Give it under [extra] if it is one of your own." * (section == "outputs")
            hint = did_you_mean(name, known)
            raise ConfigError(f"{path}: {section}: DctPlant has no '{name}'.{hint}{remedy}")


def _check_terms(path: Path, outputs: dict[str, Entry]) -> None:
    for entry in outputs.values():
        for source, _ in entry.terms:
            if source not in outputs or outputs[source].terms:
                raise ConfigError(
                    f"{path}: outputs.{entry.name}: '{source}' must be mapped to a variable"
                )


def theirs(entries: Iterable[Entry]) -> list[str]:
    """Return the supplier's variables that entries name, each once, in order."""
    return list(dict.fromkeys(e.variable for e in entries if e.variable))
