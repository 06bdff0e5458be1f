"""One mapped variable: our variable, the supplier's, and how a value passes between them."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..contract import Contract
from ..errors import ConfigError, did_you_mean
from ..fmu.values import group_of, items
from ..units import KNOWN, Unit, conversion, declared, find, hint
from .mapping import Entry, Mapping


@dataclass(frozen=True)
class Link:
    """ours = gain * theirs + shift, or `table`: (our value, their value) pairs."""

    ours: Any
    theirs: Any
    gain: float = 1.0
    shift: float = 0.0
    table: tuple[tuple[float, float], ...] = ()

    def to_ours(self, value: float) -> float:
        """Return our value for one of theirs; raises KeyError where the table has none."""
        if self.table:
            return {t: o for o, t in self.table}[float(value)]
        return self.gain * value + self.shift

    def to_theirs(self, value: float) -> float:
        """Return their value for one of ours; raises KeyError where the table has none."""
        if self.table:
            return dict(reversed(self.table))[float(value)]
        return (value - self.shift) / self.gain


class Linker:
    """Makes links; knows the supplier's description and where an error is to be mended."""

    def __init__(self, mapping: Mapping, description: Any, contract: Contract) -> None:
        self._path, self._description, self._contract = mapping.path, description, contract
        self._theirs = {v.name: v for v in description.modelVariables}

    def links(self, entries: dict[str, Entry], causality: str) -> list[Link]:
        """Return the links of a section whose variables have one causality in both FMUs."""
        return [self._link(e, causality) for e in entries.values() if e.variable]

    def _link(self, entry: Entry, causality: str) -> Link:
        theirs = self._theirs.get(entry.variable)
        if theirs is None:
            same = [n for n, v in self._theirs.items() if v.causality == causality]
            hint = self._hint(entry, same) or " Is it the FMU this mapping was written for?"
            who = self._description.modelName
            raise self._error(entry, f"{who} has no such variable.{hint}")
        if theirs.causality != causality:
            raise self._error(entry, f"is of causality {theirs.causality}, not {causality}")
        ours = self._contract.variables.get(entry.name) or self._own(entry, theirs)
        if entry.table:
            return Link(ours, theirs, table=self._table(entry, ours, theirs))
        self._check_types(entry, ours, theirs, causality)
        if ours.type != "Real":
            return Link(ours, theirs)
        return Link(ours, theirs, *self._line(entry, ours, theirs))

    @staticmethod
    def _hint(entry: Entry, names: list[str]) -> str:
        return did_you_mean(entry.variable, names)

    def _error(self, entry: Entry, what: str) -> ConfigError:
        return ConfigError(f"{self._path}: '{entry.name}' = '{entry.variable}': {what}")

    def _own(self, entry: Entry, theirs: Any) -> Any:
        """Return a variable under a name of the user's own, in SI."""
        own = copy.copy(theirs)
        own.name = entry.name
        own.unit = self._unit(entry, theirs).dimension if theirs.type == "Real" else None
        return own

    def unit_of_own(self, entry: Entry) -> Unit:
        """Return the SI unit of a variable under a name of the user's own."""
        return Unit("SI", self._unit(entry, self._theirs[entry.variable]).exponents)

    def _check_types(self, entry: Entry, ours: Any, theirs: Any, causality: str) -> None:
        source, target = (theirs, ours) if causality == "output" else (ours, theirs)
        order = ("Boolean", "Integer", "Real")
        known = group_of(source) in order and group_of(target) in order
        wider = known and order.index(group_of(source)) <= order.index(group_of(target))
        coded = items(ours) != items(theirs)
        if not wider or (coded and entry.name in self._contract.variables):
            raise self._error(
                entry, f"is {theirs.type}, ours is {ours.type}; say with a table which value "
                "stands for which",
            )  # fmt: skip

    def _unit(self, entry: Entry, theirs: Any) -> Unit:
        if entry.unit:
            known = find(entry.unit)
            if known is None:
                what = f"unknown unit '{entry.unit}' ({', '.join(KNOWN)}).{hint(entry.unit)}"
                raise self._error(entry, what)
            return known
        name, unit = declared(self._description, theirs)
        if unit is None and name:
            raise self._error(entry, f"the FMU defines no BaseUnit for '{name}'; say unit = …")
        return unit or Unit("")

    def _line(self, entry: Entry, ours: Any, theirs: Any) -> tuple[float, float]:
        """Return gain and shift: units first, then the entry's factor and offset."""
        unit = self._unit(entry, theirs)
        if ours.name not in self._contract.variables:
            target = Unit("SI", unit.exponents)
        else:
            target = self._contract.unit(ours.name)
        if not unit.name and target.exponents:
            raise self._error(
                entry, f"the FMU states no unit; say unit = … (ours is {target.name})"
            )
        try:
            a, b = conversion(unit, target)
        except ValueError as error:
            raise self._error(entry, f"{error}; if the FMU's unit is wrong say unit = …") from error
        return entry.factor * a, entry.factor * b + entry.offset

    def _table(self, entry: Entry, ours: Any, theirs: Any) -> tuple[tuple[float, float], ...]:
        """Return pairs of numbers; several values of theirs may stand for one of ours."""
        pairs = []
        for key, given in entry.table.items():
            for value in given if isinstance(given, list) else [given]:
                pairs.append((self._code(entry, ours, key), self._code(entry, theirs, value)))
        sources = [t for _, t in pairs]
        if len(set(sources)) < len(sources):
            raise self._error(entry, "the table gives one value of theirs two meanings")
        return tuple(pairs)

    def _code(self, entry: Entry, variable: Any, text: Any) -> float:
        """Return the number of an item, or a number or boolean as it is written."""
        if str(text) in items(variable):
            return float(items(variable)[str(text)])
        try:
            return float({"true": 1, "false": 0}.get(str(text).lower(), text))
        except ValueError:
            known = ", ".join(items(variable)) or "it is no enumeration"
            raise self._error(
                entry, f"table: '{variable.name}' has no item '{text}' ({known})"
            ) from None


class Translation:
    """Carries a vector of values from one side of some links to the other."""

    def __init__(self, links: list[Link], sources: list[str], targets: list[str],
                 outward: bool) -> None:  # fmt: skip
        """`outward`: from ours to theirs; names give the order of the vectors."""
        ends = [(k.ours.name, k.theirs.name) if outward else (k.theirs.name, k.ours.name)
                for k in links]  # fmt: skip
        at, to = ({name: k for k, name in enumerate(names)} for names in (sources, targets))
        self._from = np.array([at[s] for s, _ in ends], dtype=np.intp)
        self._to = np.array([to[t] for _, t in ends], dtype=np.intp)
        self._names = ends
        gain, shift = (np.array([getattr(k, f) for k in links]) for f in ("gain", "shift"))
        self._gain: np.ndarray = 1 / gain if outward else gain
        self._shift: np.ndarray = -shift / gain if outward else shift
        step = -1 if outward else 1  # the first of several rows of theirs is the one we send
        self._tables = [
            (n, {(o if outward else t): (t if outward else o) for o, t in k.table[::step]})
            for n, k in enumerate(links) if k.table
        ]  # fmt: skip

    def slopes(self, source: np.ndarray, target: np.ndarray) -> None:
        """Write time derivatives; what a table codes has none."""
        values = source[self._from] * self._gain
        for n, _ in self._tables:
            values[n] = 0.0
        target[self._to] = values

    def __call__(self, source: np.ndarray, target: np.ndarray) -> None:
        """Write `target` from `source`; raises LookupError where a table has no row."""
        values = source[self._from]
        codes = [(n, table, float(values[n])) for n, table in self._tables]
        values *= self._gain
        values += self._shift
        for n, table, code in codes:
            if code not in table:
                name, other = self._names[n]
                raise LookupError(f"{name} = {code:g} is in no row of the table for '{other}'")
            values[n] = table[code]
        target[self._to] = values
