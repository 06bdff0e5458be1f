"""Unit and type of each recorded signal, from the model descriptions of the FMUs."""

from __future__ import annotations

from collections.abc import Container, Mapping
from typing import Any

from ..fmu.fmu import Fmu
from ..fmu.values import group_of, unit_of
from ..supplier.mapped import Mapped

TIME = {"time": {"unit": "s", "type": "Real"}}


def describe(
    names: list[str],
    fmus: Mapping[str, Fmu | Mapped],
    sources: dict[str, str],
    changed: Container[str],
) -> dict[str, dict[str, Any]]:
    """Return unit and type by name; a scenario signal has those of the inputs it feeds.

    `changed`: inputs that get another value than the signal's; its unit is then not told.
    """
    told = {f"{n}.{v.name}": {"unit": unit_of(v), "type": group_of(v)}
            for n, f in fmus.items() for v in (*f.inputs, *f.outputs)}  # fmt: skip
    for target, source in sources.items():
        told.setdefault(source, {**told[target], "unit": ""} if target in changed else told[target])
    return TIME | {name: told[name] for name in names}
