"""A mapping file to start from: the likeliest partner of each variable, the rest as comments."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from ..contract import Contract
from ..fmu.values import items
from ..units import declared
from .against import VEHICLE, WHEEL
from .naming import ALIKE, likeness, unit_of, unit_of_name, words

SECTIONS = (("inputs", "input"), ("outputs", "output"), ("parameters", "parameter"))
HEAD = """# Mapping of {model} to the names of DctPlant, written by `dct-harness map`.
# Matched by name, unit and description: read every line. Lines with a # have no partner yet.
# Then: dct-harness check {path} --against plant --map THIS_FILE
supplier = {model}
share = ["observer", "control"] # take this plant's values of [parameters] and [known]
"""


def pairs(contract: Contract, description: Any, causality: str) -> dict[str, tuple[Any, float]]:
    """Return our name -> the likeliest variable of theirs and how likely, best first, each once.

    A parameter of theirs may stand for that of either clutch or shaft.
    """
    theirs = [v for v in description.modelVariables if v.causality == causality]
    scored = [
        (likeness(ours, contract.unit(name), v, unit_of(description, v)), name, v)
        for name, ours in contract.of(causality).items() for v in theirs
    ]  # fmt: skip
    found: dict[str, tuple[Any, float]] = {}
    taken: dict[str, Any] = {}  # a parameter of theirs may be that of both clutches
    for score, name, variable in sorted(scored, key=lambda s: -s[0]):
        kind = words(name)[0] if causality == "parameter" else name
        if score >= ALIKE and name not in found and taken.setdefault(variable.name, kind) == kind:
            found[name] = variable, score
    return found


def text(contract: Contract, description: Any, path: Path) -> str:
    """Return the mapping file."""
    lines = [HEAD.format(model=json.dumps(description.modelName), path=path)]
    used: set[str] = set()
    for section, causality in SECTIONS:
        found = pairs(contract, description, causality)
        used |= {v.name for v, _ in found.values()}
        lines.append(f"[{section}]")
        for name in contract.of(causality):
            lines += _lines(contract, description, name, found.get(name))
        lines.append("")
    lines += _known(contract, found)
    lines.append("# Not used above:")
    rest = (v for v in description.modelVariables if v.name not in used)
    lines += [f"# {v.causality or 'local':9} {v.name} {_what(description, v)}" for v in rest]
    return "\n".join(lines) + "\n"


def _known(contract: Contract, given: dict[str, Any]) -> list[str]:
    """Return what the observer believes of the vehicle and the FMU has no parameter for."""
    lines = ["[known] # what the FMU does not tell; the observer takes Table 1 instead"]
    for name, ours in contract.of("parameter").items():
        if name in contract.believed and name not in given:
            told = f"[{contract.unit(name).name}] {ours.description}"
            lines.append(f'# "{name}" = {float(ours.start):g} # {told}')
    return [*lines, ""]


def _lines(
    contract: Contract, description: Any, name: str, found: tuple[Any, float] | None
) -> list[str]:
    ours = contract.variables[name]
    if found is None:
        if ours.causality == "parameter":
            return []
        need = " NEEDED by the observer." if name in contract.needed else ""
        blank = f'{{ derive = "{VEHICLE}", radius = "?" }}' if name == WHEEL else '""'
        return [f"#{need} {ours.description}", f'# "{name}" = {blank}']
    theirs, score = found
    if ours.type != "Real" and items(ours) | items(theirs):
        value = _table(theirs, ours)
    elif ours.type == "Real" and declared(description, theirs)[1] is None:
        unit = unit_of_name(theirs.name) or "?" * bool(contract.unit(name).exponents) or "1"
        value = f'{{ variable = {json.dumps(theirs.name)}, unit = "{unit}" }}'
    else:
        value = json.dumps(theirs.name)
    return [f'"{name}" = {value} # {score:.0%} {_what(description, theirs)}']


def _table(theirs: Any, ours: Any) -> str:
    """Return an entry whose table the reader has to fill: our items, or the gears of a shaft."""
    count = max(len(items(theirs)), 2)
    first = 2 if ours.name.startswith("shaft2") else 1
    keys = list(items(ours)) or [0, *range(first, 9, 2)][:count]
    rows = ", ".join(f'{key} = "?"' for key in keys)
    return f"{{ variable = {json.dumps(theirs.name)}, table = {{ {rows} }} }}"


def _what(description: Any, variable: Any) -> str:
    """Return unit or items and description of a variable, for a comment."""
    unit = declared(description, variable)[0]
    listed = ", ".join(items(variable))
    kind = f"{{{listed}}}" if listed else unit or variable.type
    return f"{kind}: {variable.description or 'no description'}".replace("\n", " ")
