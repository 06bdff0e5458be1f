"""The runs of a study, each with the words that tell `run` what is its own; the files it needs."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple

from ..errors import ConfigError, did_you_mean
from ..fmu.ports import Ports
from ..supplier.mapped import Mapped
from ..system import tomlfile
from ..system.system import NOISE, Value
from ..verbs import selection
from .sampling import Factor
from .study import Study, Words
from .study_file import assignment


class Job(NamedTuple):
    """One run: its number, what was chosen for it, and how it differs from other runs.

    `shared`: words that runs of the same combination of axes have, too; `sets`: its own values, as
    `component.variable=value`.
    """

    number: int
    chosen: dict[str, Value]
    shared: Words = ()
    sets: tuple[str, ...] = ()

    @property
    def words(self) -> Words:
        """Its words after those of all runs."""
        return (*self.shared, *(word for text in self.sets for word in ("--set", text)))


def jobs(study: Study) -> list[Job]:
    """Return all runs, numbered from 1.

    Raises
    ------
    ConfigError
        A factor sets what does not exist, or is relative to what has no value.
    """
    points = study.points()
    found: list[Job] = []
    for labels, words in study.combinations():
        base = bases(study, words)
        for point in points:
            own = [text for f in study.factors for text in _set(f, point[f.name], base)]
            found.append(Job(len(found) + 1, {**point, **labels}, words, tuple(own)))
    return found


def command(study: Study, job: Job) -> str:
    """Return the command that repeats a run: same values, same engine, same bits."""
    return shlex.join(["dct-harness", *map(str, (*study.common, *job.words))])


def _set(factor: Factor, value: Value, base: dict[str, float]) -> list[str]:
    """Return what gives a factor's parameters their values, as `component.variable=value`."""
    found = []
    for target in factor.parameters:
        told = value * base[target] if factor.relative else value  # type: ignore[operator]
        found.append(assignment(target, _whole(told) if factor.whole else told))
    return found


def _whole(value: Any) -> Any:
    return int(value) if float(value).is_integer() else value


def chosen(study: Study, words: Words, see: Callable[[selection.Chosen], Any]) -> Any:
    """Return what `see` makes of the system that words choose."""
    from ..cli import parser

    args = parser().parse_args([*map(str, study.common), *map(str, words), "-q"])
    with selection.opened(args) as found:
        return see(found)


def bases(study: Study, words: Words) -> dict[str, float]:
    """Return what parameters that relative factors set have otherwise; checks all names."""

    def see(found: selection.Chosen) -> dict[str, float]:
        model, paths, mapping, _ = found
        ports: dict[str, Any] = {n: Ports(n, p) for n, p in paths.items() if p.is_file()}
        if mapping is not None and "plant" in ports:
            ports["plant"] = Mapped(ports["plant"], mapping)
        return {target: value for factor in study.factors for target in factor.parameters
                if (value := _base(study, factor, target, model, ports)) is not None}  # fmt: skip

    base: dict[str, float] = chosen(study, words, see)
    return base


def _base(study: Study, factor: Factor, target: str, model: Any, ports: dict[str, Any]) -> Any:
    """Return the value of the system or the start value of the FMU; None where nobody asks.

    Noise has the deviation of the system file; a run says when there is no such output.
    """
    component, _, variable = target.partition(".")
    if component == NOISE:
        return _number(study, factor, target, model.noise.get(variable))
    if component not in model.components:
        hint = did_you_mean(component, model.components)
        raise ConfigError(f"{_place(study, factor)}: '{target}': {model.path} has no component "
                          f"'{component}'.{hint}")  # fmt: skip
    if component not in ports:
        return None  # the FMU is not there; the runs say so
    known = ports[component].variables
    if variable not in known:
        hint = did_you_mean(variable, known)
        raise ConfigError(f"{_place(study, factor)}: '{target}': the FMU of '{component}' has no "
                          f"variable '{variable}'.{hint}")  # fmt: skip
    value = model.components[component].parameters.get(variable, known[variable].start)
    return _number(study, factor, target, value)


def _number(study: Study, factor: Factor, target: str, value: Any) -> float | None:
    """Return what a factor is relative to; None where it is not."""
    if not factor.relative:
        return None
    try:
        return float(value)
    except (TypeError, ValueError):
        raise ConfigError(f"{_place(study, factor)}: '{target}' has no number to be relative to; "
                          "give it one under [set]") from None  # fmt: skip


def _place(study: Study, factor: Factor) -> str:
    """Return where a factor stands."""
    if study.file is None or not study.file.is_file():
        return f"--vary {factor.name}"
    document = tomlfile.read(study.file, "study", "study.schema.json")
    return document.at("factors", factor.name, "set")


def files(study: Study) -> list[Path]:
    """Return all files that runs read, each once: systems, scenarios, FMUs, mappings, values."""

    def see(found: selection.Chosen) -> list[Path]:
        model, paths, _, package = found
        inside = package.folder.name if package else None
        listed = [*model.files, model.scenario, *_phases(model.scenario), *paths.values()]
        return [p for p in listed if p is not None and not (inside and str(p).startswith(inside))]

    listed: list[Path] = [study.system, *_paths(study.settings)]
    for _, words in study.combinations():
        listed += [*_paths(words), *chosen(study, words, see)]
    there = (p.resolve() for p in listed if p.is_file())
    return list(dict.fromkeys(there))


def _paths(words: Iterable[str | Path]) -> list[Path]:
    return [word for word in words if isinstance(word, Path)]


def _phases(scenario: Path | None) -> list[Path]:
    """Return where phases of a scenario may stand."""
    if scenario is None:
        return []
    return [scenario.with_name(name) for name in (f"{scenario.stem}.phases.csv", "phases.csv")]
