"""Which source each FMU input reads: a [[connections]] entry, an equal name, the scenario.

A tunable parameter counts as an input where the scenario has a column of its name: friction that
fades during a shift, say.

An estimate carries the name of the truth. Where both are there, the control reads the observer's.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..contract import plant as plant_contract
from ..errors import ConfigError, did_you_mean, instant
from ..fmu.fmu import Fmu
from ..fmu.values import group_of
from ..supplier.mapped import Mapped
from ..system.scenario import Scenario
from ..system.system import System
from ..system.transforms import Transform
from ..units import Unit, conversion


def resolve(system: System, fmus: Mapping[str, Fmu | Mapped], signals: list[str]) -> dict[str, str]:
    """Return input -> source, both as `<component>.<variable>`; constants are left out."""
    outputs = {f"{n}.{v.name}" for n, f in fmus.items() for v in f.outputs}
    known = outputs | {f"scenario.{name}" for name in signals}
    inputs = {f"{n}.{v.name}": v.name for n, f in fmus.items() for v in f.inputs}
    for target, source in system.connections.items():
        for key, end, names in (("to", target, inputs), ("from", source, known)):
            if end not in names:
                raise ConfigError(
                    f"{system.at_connection(target, key)}: connections: no '{end}'."
                    f"{did_you_mean(end, names)}"
                )
    found = {}
    for target, variable in inputs.items():
        component = target.partition(".")[0]
        if target in system.connections:
            found[target] = system.connections[target]
        elif not system.explicit and variable not in system.components[component].parameters:
            found[target] = _source(system, component, variable, outputs, known, inputs)
    return found


def _source(
    system: System, component: str, variable: str, outputs: set[str], known: set[str],
    inputs: Mapping[str, str],
) -> str:  # fmt: skip
    """Return the one equal-named output of another component, else the scenario's signal."""
    others = (n for n in system.components if n != component)
    what = f"{system.at('components', component)}: '{component}.{variable}'"
    equal = [f"{n}.{variable}" for n in others if f"{n}.{variable}" in outputs]
    if component == "control" and equal == [f"plant.{variable}", f"observer.{variable}"]:
        equal = equal[1:]
    if len(equal) > 1:
        raise ConfigError(
            f"{what} has several sources ({', '.join(equal)}); "
            "choose one with a [[connections]] entry"
        )
    signal = equal[0] if equal else f"scenario.{variable}"
    if signal not in known:
        raise ConfigError(
            f"{what} has no source: add a column '{variable}' to "
            f"{system.scenario}, a [[connections]] entry, or a value under "
            f"components.{component}.parameters.{_hint(component, variable, known, inputs)}"
        )
    return signal


def _hint(component: str, variable: str, known: set[str], inputs: Mapping[str, str]) -> str:
    """Return a column like it that nobody reads; of a plant with names of its own what it needs."""
    ours = plant_contract()
    if component == "plant" and variable not in ours.variables:
        return " A plant with names of its own needs --map; `dct-harness map` writes one."
    if component == "plant" and variable in ours.needed:
        return " A plant gives that: `dct-harness check FMU --against plant` tells if this is one."
    columns = {name.removeprefix("scenario.") for name in known if name.startswith("scenario.")}
    return did_you_mean(variable, sorted(columns - set(inputs.values())))


def types(fmus: Mapping[str, Fmu | Mapped]) -> dict[str, str]:
    """Return Real, Integer or Boolean of each input and output; enumerations are integers."""
    return {f"{n}.{v.name}": group_of(v) for n, f in fmus.items() for v in (*f.inputs, *f.outputs)}


def held(fmus: Mapping[str, Fmu | Mapped], sources: dict[str, str]) -> set[str]:
    """Return the sources that are held between rows of a scenario, as an input of them is discrete.

    Integers and booleans are, and Reals that say so; a tunable Real may change in a ramp.
    """
    inputs = {f"{n}.{v.name}": v for n, f in fmus.items() for v in f.inputs}
    return {s for t, s in sources.items()
            if group_of(inputs[t]) != "Real" or inputs[t].variability == "discrete"}  # fmt: skip


def check_types(
    system: System, fmus: Mapping[str, Fmu | Mapped], sources: dict[str, str], script: Scenario
) -> None:
    """Refuse a connection that would change values: types differ, or a scenario breaks one."""
    typed = types(fmus)
    for target, source in sources.items():
        component, _, name = source.partition(".")
        if typed[target] != "Real" and target in system.transforms and not system.explicit:
            raise ConfigError(
                f"{_place(system, target)}: '{target}' is {typed[target]}; factor and offset are "
                "for real inputs"
            )
        if component == "scenario":
            _check_column(script, name, target, typed[target])
        elif typed[source] != typed[target] and not _converted(system, target):
            raise ConfigError(
                f"{_place(system, target)}: '{source}' is {typed[source]} but '{target}' is "
                f"{typed[target]}; choose another source with a [[connections]] entry"
            )


def _place(system: System, target: str) -> str:
    """Return where a connection stands, or the component whose input found it by its name."""
    if target in system.connections:
        return system.at_connection(target, "from")
    return system.at("components", target.partition(".")[0])


def transforms(
    system: System, fmus: Mapping[str, Fmu | Mapped], sources: dict[str, str]
) -> dict[str, Transform]:
    """Return what a value needs on its way to each input that takes it in another unit.

    The factor and offset of a [[connections]] entry stand for themselves; an SSP file has told
    everything. Where one end declares no unit that is known, a value passes as it is.

    Raises
    ------
    ConfigError
        The units of the ends measure different quantities.
    """
    found = dict(system.transforms)
    typed = types(fmus)
    for target, source in sources.items() if not system.explicit else ():
        if target in found or source.startswith("scenario.") or typed[target] != "Real":
            continue
        ends = [_unit(fmus, end) for end in (source, target)]
        if ends[0] is not None and ends[1] is not None:
            change = Transform(*_converted_unit(system, source, target, ends[0], ends[1]))
            found |= {target: change} if change.changes else {}
    return found


def _unit(fmus: Mapping[str, Fmu | Mapped], end: str) -> Unit | None:
    component, _, name = end.partition(".")
    return fmus[component].unit(name)


def _converted_unit(
    system: System, source: str, target: str, giver: Unit, taker: Unit
) -> tuple[float, float]:
    try:
        return conversion(giver, taker)
    except ValueError as error:
        raise ConfigError(
            f"{_place(system, target)}: '{source}' to '{target}': {error}; connect another output, "
            "or say factor = … in a [[connections]] entry"
        ) from error


def _converted(system: System, target: str) -> bool:
    """Return whether a table says what each value of the source stands for."""
    return target in system.transforms and bool(system.transforms[target].table)


def _check_column(script: Scenario, name: str, target: str, kind: str) -> None:
    """Refuse scenario values that an integer or boolean input cannot take as they are."""
    values = script.signals[name]
    fits = {
        "Real": np.ones(len(values), dtype=bool),
        "Integer": values == np.round(values),
        "Boolean": (values == 0) | (values == 1),
    }[kind]
    if not fits.all():
        row = int(np.argmin(fits))
        value, t = float(values[row]), float(script.time[row])
        raise ConfigError(
            f"{script.path}: column '{name}' is {value!r} at t = {instant(t)} s, "
            f"but '{target}' is {kind}"
        )
