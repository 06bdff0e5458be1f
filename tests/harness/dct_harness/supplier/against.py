"""Does a plant keep the contract of DctPlant: what is missing, of another type, unit or sign."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..contract import Contract
from ..contract import plant as plant_contract
from ..errors import ConfigError
from ..units import conversion, declared
from .links import Linker
from .mapping import Entry, Mapping

SECTIONS = (("inputs", "input"), ("outputs", "output"), ("parameters", "parameter"))
WHEEL, VEHICLE = "wheel.speed", "vehicle.speed"
ACTUATORS = ("position", "pressure")


@dataclass(frozen=True)
class Finding:
    """One line of the contract; `fault` means that the plant cannot be used like this."""

    name: str
    theirs: str
    verdict: str
    fault: bool = False


def identity(description: Any, path: Path) -> Mapping:
    """Return the mapping of an FMU that has our names already."""
    contract = plant_contract()
    names = {v.name: v for v in description.modelVariables}
    tables = {
        section: {n: Entry(n, n) for n in contract.of(causality) if n in names}
        for section, causality in SECTIONS
    }
    return Mapping(path, tables["inputs"], tables["outputs"], {}, tables["parameters"],
                   {}, {}, [], [])  # fmt: skip


def findings(description: Any, mapping: Mapping, same_names: bool) -> list[Finding]:
    """Return a line for each input and output, and for each parameter that is mapped."""
    contract = plant_contract()
    linker = Linker(mapping, description, contract)
    found = []
    for section, causality in SECTIONS:
        entries = getattr(mapping, section)
        for name in contract.of(causality):
            if name in entries:
                found.append(_mapped(linker, contract, description, entries[name], causality,
                                     same_names))  # fmt: skip
            elif causality != "parameter":
                found.append(_missing(contract, entries, name))
    return found


def untold(mapping: Mapping) -> list[str]:
    """Return the parameters of the vehicle that the observer keeps: the mapping does not say them.

    Left out are those that are 0 in Table 1: parts that its vehicle lacks.
    """
    contract = plant_contract()
    told = {*mapping.parameters, *mapping.known} if mapping.share else set()
    return [n for n, v in contract.of("parameter").items()
            if n in contract.believed - told and float(v.start)]  # fmt: skip


def _missing(contract: Contract, entries: dict[str, Entry], name: str) -> Finding:
    part, _, what = name.partition(".")
    if name in contract.needed:
        return Finding(name, "", f"missing: the observer needs it{_derived(name, entries)}", True)
    if name == "engine.torque":
        return Finding(name, "", "missing: nothing drives the plant", True)
    if what in ACTUATORS and not any(f"{part}.{a}" in entries for a in ACTUATORS):
        return Finding(name, "", "missing: nothing closes this clutch", True)
    causality = contract.variables[name].causality
    effect = "what a scenario says of it has no effect" if causality == "input" else "optional"
    return Finding(name, "", f"not there; {effect}")


def _derived(name: str, entries: dict[str, Entry]) -> str:
    if name != WHEEL or VEHICLE not in entries:
        return ""
    return f'; {{ derive = "{VEHICLE}", radius = … }}, if the FMU has none'


def _mapped(
    linker: Linker, contract: Contract, description: Any, entry: Entry, causality: str,
    same_names: bool,
) -> Finding:  # fmt: skip
    """Return what an entry is worth; with equal names nothing would be converted in a run."""
    if entry.terms:
        return Finding(entry.name, " - ".join(s for s, _ in entry.terms), "ok, derived")
    try:
        (link,) = linker.links({entry.name: entry}, causality)
    except ConfigError as error:
        return Finding(entry.name, entry.variable, str(error).partition(f"'{entry.variable}': ")[2],
                       True)  # fmt: skip
    unit = declared(description, link.theirs)[0] or entry.unit
    ours = contract.unit(entry.name)
    if link.theirs.type == "Real" and same_names:
        stated = declared(description, link.theirs)[1]
        if stated and conversion(stated, ours) != (1.0, 0.0):
            text = f"is in {unit}, ours in {ours.name}; convert it with --map"
            return Finding(entry.name, entry.variable, text, True)
    return Finding(entry.name, entry.variable, f"ok{f', in {unit}' if unit else ''}")
