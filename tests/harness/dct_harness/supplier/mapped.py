"""A supplier's plant under the names, units and codings of DctPlant."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np

from ..contract import plant as plant_contract
from ..errors import ConfigError, FmuRuntimeError, did_you_mean, instant
from ..fmu.fmu import Fmu
from ..fmu.values import Read, group_of
from ..system.parameters import BOOLEANS
from ..units import Unit
from .links import Link, Linker, Translation
from .mapping import Entry, Mapping, theirs


class Mapped:
    """Stands in for an `Fmu`; everything that is not mapped stays the supplier's."""

    def __init__(self, fmu: Fmu, mapping: Mapping) -> None:
        self._fmu, self._mapping = fmu, mapping
        self._slopes: tuple[np.ndarray, np.ndarray] | None = None  # ours, theirs
        contract = plant_contract()
        linker = Linker(mapping, fmu.description, contract)
        self._in = linker.links(mapping.inputs, "input")
        self._out = linker.links({**mapping.outputs, **mapping.extra}, "output")
        self._set = {k.ours.name: k for k in linker.links(mapping.parameters, "parameter")}
        self._derived = [e for e in mapping.outputs.values() if e.terms]
        self.inputs = [k.ours for k in self._in]
        self.outputs = [k.ours for k in self._out]
        self.outputs += [contract.variables[e.name] for e in self._derived]
        self._units = {n: contract.unit(n).name for n in self._set}
        own = {e.name: linker.unit_of_own(e) for e in mapping.extra.values()}
        self._sides = {v.name: own.get(v.name) or contract.unit(v.name)
                       for v in (*self.inputs, *self.outputs)}  # fmt: skip
        self._refuse_two_sources()
        self._choose(fmu)

    def _choose(self, fmu: Fmu) -> None:
        """Let the FMU exchange the mapped variables only."""
        both = (("inputs", self._mapping.inputs), ("outputs", self._mapping.outputs))
        for side, entries in both:
            named = {**entries, **self._mapping.extra} if side == "outputs" else entries
            chosen = set(theirs(named.values()))
            setattr(fmu, side, [v for v in getattr(fmu, side) if v.name in chosen])

    def _refuse_two_sources(self) -> None:
        names = [k.theirs.name for k in self._in]
        for name in names:
            if names.count(name) > 1:
                raise ConfigError(
                    f"{self._mapping.path}: inputs: '{name}' of the FMU is given twice; keep one"
                )

    def __getattr__(self, name: str) -> Any:
        """Return what the supplier's FMU has: name, path, log, wall_time, close, …"""
        return getattr(self._fmu, name)

    @property
    def variables(self) -> dict[str, Any]:
        """Parameters by our names; all of the supplier's by its names."""
        return {**self._fmu.variables, **{n: k.ours for n, k in self._set.items()}}

    def unit(self, name: str) -> Unit | None:
        """Return the unit in which an input or output passes: that of ours, SI."""
        return self._sides.get(name)

    def feedthrough(self, initial: bool = False) -> dict[str, set[str]]:
        """Return output -> inputs that it depends on at the same instant, by our names."""
        raw = self._fmu.feedthrough(initial)
        names = {k.theirs.name: k.ours.name for k in self._in}
        every = names.keys()
        found = {k.ours.name: {names[n] for n in every & raw.get(k.theirs.name, every)}
                 for k in self._out}  # fmt: skip
        for entry in self._derived:
            found[entry.name] = set().union(*(found[source] for source, _ in entry.terms))
        return found

    def steer(self, names: Collection[str]) -> None:
        """Take our names of the supplier's tunable parameters as inputs."""
        more = [k for n, k in self._set.items() if n in names and k.theirs.variability == "tunable"]
        self._in += more
        self.inputs += [k.ours for k in more]
        self._fmu.steer({k.theirs.name for k in more})

    def sets(self, name: str) -> bool:
        """Return whether a parameter of ours is mapped."""
        return name in self._set

    def initialize(self, stop: float, values: dict[str, Any]) -> None:
        """As `Fmu.initialize`, with names of ours (SI) or of the supplier (its units)."""
        self._fmu.initialize(stop, dict(self.their_value(n, v) for n, v in values.items()))

    def their_value(self, name: str, value: Any) -> tuple[str, Any]:
        """Return name and value of the supplier for one of ours (SI), or for its own."""
        links = {**{k.ours.name: k for k in self._in}, **self._set}
        if name in links:
            link = links[name]
            try:
                return link.theirs.name, _typed(link, value)
            except ValueError as error:
                what = f"'{name}' = '{link.theirs.name}': {error}"
                raise ConfigError(f"{self._mapping.path}: {what}", name) from error
        if name not in self._fmu.variables:
            hint = did_you_mean(name, self._set)
            raise ConfigError(
                f"{self._mapping.path}: parameters: nothing stands for '{name}' = {value!r} of "
                f"the system; map it, or list it in 'ignore'.{hint}", name,
            )  # fmt: skip
        return name, value

    def shared(self, values: dict[str, Any]) -> dict[str, Any]:
        """Return the mapped parameters by our names in SI; `values` are what a run sets."""
        found: dict[str, Any] = {}
        for name, link in self._set.items():
            given = values.get(name, values.get(link.theirs.name))
            if name in values:
                found[name] = given
            elif given is not None or link.theirs.start is not None:
                found[name] = link.to_ours(_number(link.theirs.start if given is None else given))
        return found

    @property
    def inner(self) -> Fmu:
        """The supplier's FMU itself."""
        return self._fmu

    @property
    def file(self) -> Path:
        """The mapping file."""
        return self._mapping.path

    @property
    def into(self) -> list[Link]:
        """Links of the inputs."""
        return self._in

    @property
    def out(self) -> list[Link]:
        """Links of the outputs."""
        return self._out

    @property
    def sums(self) -> list[tuple[Entry, Any]]:
        """Outputs that are sums of others, after those of `out`, and what they are of ours."""
        return list(zip(self._derived, self.outputs[len(self._out) :], strict=True))

    def link_of_output(self, name: str) -> tuple[Link, float]:
        """Return the link of one of our outputs, and by what its value is multiplied besides.

        Raises
        ------
        ConfigError
            The output is a sum of several.
        """
        terms = next((e.terms for e in self._derived if e.name == name), ((name, 1.0),))
        if len(terms) > 1:
            raise ConfigError(
                f"{self._mapping.path}: outputs.{name}: a difference of two outputs has no "
                "counterpart in SSP; let the FMU give it"
            )
        source, weight = terms[0]
        return next(k for k in self._out if k.ours.name == source), weight

    def bind(self, inputs: np.ndarray, outputs: np.ndarray) -> None:
        """Attach our buffers, as `Fmu.bind`."""
        self._ours = inputs, outputs
        fmu = self._fmu
        named = {v.name for v in self.inputs}
        links = [k for k in self._in if k.ours.name in named]
        written = {k.theirs.name for k in links}
        fmu.inputs = [v for v in fmu.inputs if v.name in written]
        self._theirs = np.zeros(len(fmu.inputs)), np.zeros(len(fmu.outputs))
        fmu.bind(*self._theirs)
        ours = [[v.name for v in side] for side in (self.inputs, self.outputs)]
        theirs_ = [[v.name for v in side] for side in (fmu.inputs, fmu.outputs)]
        self._send = Translation(links, ours[0], theirs_[0], outward=True)
        self._receive = Translation(self._out, theirs_[1], ours[1], outward=False)
        self._sums = [_Sum(e, ours[1]) for e in self._derived]

    def bind_slopes(self, slopes: np.ndarray) -> None:
        """Attach our buffer of input derivatives, as `Fmu.bind_slopes`."""
        self._slopes = slopes, np.zeros(len(self._fmu.inputs))
        self._fmu.bind_slopes(self._slopes[1])

    def get_slopes(self) -> np.ndarray:
        """Return the derivatives of our outputs."""
        found = np.zeros(len(self.outputs))
        self._receive.slopes(self._fmu.get_slopes(), found)
        for total in self._sums:
            total(found)
        return found

    def advance_inputs(self, h: float) -> None:
        """As `Fmu.advance_inputs`; both sides, since every step translates anew."""
        if self._slopes:
            self._ours[0][:] += self._slopes[0] * h

    def set_inputs(self) -> None:
        """Write our inputs to the FMU."""
        self._translate(self._send, self._ours[0], self._theirs[0])
        self._fmu.set_inputs()

    def get_outputs(self) -> None:
        """Read the FMU's outputs as ours."""
        self._fmu.get_outputs()
        self._received()

    def step(self, t: float, h: float) -> None:
        """Advance from `t` to `t + h` [s] with the bound buffers."""
        self._translate(self._send, self._ours[0], self._theirs[0])
        if self._slopes:
            self._send.slopes(*self._slopes)
        self._fmu.step(t, h)
        self._received()

    def _received(self) -> None:
        self._translate(self._receive, self._theirs[1], self._ours[1])
        for total in self._sums:
            total(self._ours[1])

    def _translate(self, translation: Translation, source: np.ndarray, target: np.ndarray) -> None:
        try:
            translation(source, target)
        except LookupError as error:
            raise FmuRuntimeError(
                f"{self._fmu.name}: {error.args[0]} at t = {instant(self._fmu.now)} s; "
                f"add it to {self._mapping.path}"
            ) from error

    def parameters(self, read: Read) -> dict[str, dict[str, Any]]:
        """Return the supplier's parameters as they are, and the mapped ones as ours in SI."""
        raw = self._fmu.parameters(read)
        mapped = {n: k for n, k in self._set.items() if k.theirs.name in raw}
        return {
            **{n: {"value": k.to_ours(raw[k.theirs.name]["value"]), "unit": self._units[n]}
               for n, k in mapped.items()},
            **raw,
        }  # fmt: skip

    def identity(self) -> dict[str, str]:
        """Return what `run.json` records of the FMU and of its mapping."""
        return {**self._fmu.identity(), "mapping": str(self._mapping.path)}


class _Sum:
    """An output that is a weighted sum of others."""

    def __init__(self, entry: Entry, names: list[str]) -> None:
        self._to = names.index(entry.name)
        self._terms = [(names.index(source), weight) for source, weight in entry.terms]

    def __call__(self, outputs: np.ndarray) -> None:
        outputs[self._to] = sum(weight * outputs[k] for k, weight in self._terms)


def their_value(component: Any, name: str, value: Any) -> tuple[str, Any]:
    """Return name and value as the FMU of a component has them."""
    if isinstance(component, Mapped):
        return component.their_value(name, value)
    return name, value


def _typed(link: Link, value: Any) -> Any:
    """Return the supplier's start value for one of ours, as the type it has there.

    Raises
    ------
    ValueError
        The table has no row for it, or what it becomes is no value of that type.
    """
    if isinstance(value, str):
        return value
    ours, kind = float(value), group_of(link.theirs)
    try:
        theirs = link.to_theirs(ours)
    except KeyError:
        raise ValueError(f"{ours!r} is in no row of its table") from None
    if kind == "Real":
        return theirs
    if kind == "Boolean" and theirs in (0.0, 1.0):
        return bool(theirs)
    if kind == "Integer" and theirs.is_integer():
        return int(theirs)
    whole = "give a value that is a whole number there"
    remedy = "give true or false" if kind == "Boolean" else whole
    raise ValueError(f"{ours!r} would be {theirs!r} there, which is {kind}; {remedy}")


def _number(value: Any) -> float:
    """Return a value that a run sets, or a start value as a description writes it."""
    return float(BOOLEANS.get(value, value))


def apply_shared(
    mapping: Mapping, plant: Mapped, fmus: dict[str, Any], given: dict[str, dict[str, Any]]
) -> None:
    """Give components in `share` what they have as parameter and nobody set.

    First what the mapping says under [known], then the plant's own parameters.
    """
    there = [fmus[name] for name in mapping.share if name in fmus]
    names = {n for fmu in there for n in fmu.variables}
    for name in mapping.known if there else ():
        if name not in names:
            hint = did_you_mean(name, names)
            raise ConfigError(f"{mapping.path}: known: nobody in 'share' has '{name}'.{hint}")
    values = {**plant.shared(given["plant"]), **mapping.known}
    for fmu in there:
        for name, value in values.items():
            if name in fmu.variables and fmu.variables[name].causality == "parameter":
                given[fmu.name].setdefault(name, value)
