"""Reads a study file; errors name file, line, column, key and remedy."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from ..errors import ConfigError, did_you_mean
from ..kpi.registry import BY_KEY
from ..system import tomlfile
from .distributions import NUMBERS, written
from .sampling import CHOICE, Factor
from .study import Axis, Option, Shown, Study, Words

METHOD = "observer.observer.method"  # what `methods` sets
PLAIN = ("sampling", "runs", "seed", "engine", "executor", "jobs", "retries", "title")
TOLD = ("timeout", "call-timeout", "step", "stop")  # options of `run`


def is_study(path: Path) -> bool:
    """Return whether a file begins a study; one that cannot be read is none."""
    if path.suffix.lower() != ".toml":
        return False
    try:
        return "study" in tomlfile.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False


def load(path: Path) -> Study:
    """Read and check a study file.

    Raises
    ------
    ConfigError
        It cannot be read, breaks the schema, or names what does not exist.
    """
    document = tomlfile.read(path, "study", "study.schema.json")
    data, head = document.data, document.data["study"]
    keep = data.get("keep", {})
    return Study(
        head["name"], _file(document, "study", "system"), file=path,
        factors=tuple(_factor(document, name) for name in data.get("factors", {})),
        axes=tuple(filter(None, (make(document) for make in AXES))),
        settings=_settings(document), signals=tuple(keep.get("signals", ())),
        every=float(keep.get("every", Study.every)), kpis=_shown(document), heat=_heat(document),
        **{key: head[key] for key in PLAIN if key in head},
    )  # fmt: skip


def _file(document: tomlfile.Document, *keys: str) -> Path:
    """Return the path that a key gives, relative to the study file; it must be there."""
    value: Any = document.data
    for key in keys:
        value = value[key]
    found = document.path.parent / value
    if not found.is_file():
        raise ConfigError(
            f"{document.at(*keys)}: {'.'.join(keys)}: no file {found}; names are relative to "
            "the study file"
        )
    return found


def _factor(document: tomlfile.Document, name: str) -> Factor:
    given = document.data["factors"][name]
    kind = next(k for k in (*NUMBERS, "values") if k in given)
    numbers = tuple(given[kind])
    if kind in NUMBERS and not NUMBERS[kind].takes(numbers):
        place = document.at("factors", name, kind)
        raise ConfigError(f"{place}: factors.{name}.{kind}: no such distribution; it is "
                          f"{written(kind)} with LOW below HIGH, deviations above 0")  # fmt: skip
    targets = given.get("set", name)
    targets = tuple([targets] if isinstance(targets, str) else targets)
    if any("." not in target for target in targets):
        raise ConfigError(f"{document.at('factors', name)}: factors.{name}: sets no parameter; "
                          'add set = "COMPONENT.VARIABLE"')  # fmt: skip
    more = {key: given[key] for key in ("relative", "whole", "levels", "label", "unit")
            if key in given}  # fmt: skip
    return Factor(name, CHOICE if kind == "values" else kind, numbers, targets, **more)


def _settings(document: tomlfile.Document) -> Words:
    """Return what all runs are told."""
    found: list[str | Path] = []
    for key in TOLD:
        if key in document.data["study"]:
            found += [f"--{key}", repr(float(document.data["study"][key]))]
    for name, value in document.data.get("set", {}).items():
        found += setting(name, value)
    return tuple(found)


def setting(name: str, value: Any) -> list[str]:
    """Return the words that set a parameter."""
    return ["--set", assignment(name, value)]


def assignment(name: str, value: Any) -> str:
    """Return what follows `--set`; numbers keep every digit."""
    return f"{name}={json.dumps(value)}"


def _scenarios(document: tomlfile.Document) -> Axis | None:
    found = []
    for name, given in document.data.get("scenarios", {}).items():
        words: Words = ("--scenario", _file(document, "scenarios", name, "file"))
        if "stop" in given:
            words += ("--stop", repr(float(given["stop"])))
        found.append(Option(name, words))
    return Axis("scenario", tuple(found)) if found else None


def _presets(document: tomlfile.Document) -> Axis | None:
    found = []
    for name, given in document.data.get("presets", {}).items():
        words: list[str | Path] = []
        for component in given:
            words += ["--parameters", component, _file(document, "presets", name, component)]
        found.append(Option(name, tuple(words)))
    return Axis("preset", tuple(found)) if found else None


def _methods(document: tomlfile.Document) -> Axis | None:
    given = document.data.get("methods")
    if given is None:
        return None
    name = given.get("set", METHOD)
    return Axis("method", tuple(Option(m, tuple(setting(name, m))) for m in given["names"]))


def _mappings(document: tomlfile.Document) -> Axis | None:
    found = []
    for name, given in document.data.get("mappings", {}).items():
        plant = document.path.parent / given["plant"]  # often built later than the study
        words = ("--plant", plant, "--map", _file(document, "mappings", name, "map"))
        found.append(Option(name, words))
    return Axis("mapping", tuple(found)) if found else None


def _noise(document: tomlfile.Document) -> Axis | None:
    seeds = document.data.get("noise", {}).get("seeds", ())
    options = tuple(Option(s, tuple(setting("noise.seed", s))) for s in seeds)
    return Axis("noise seed", options) if seeds else None


AXES = (_scenarios, _presets, _methods, _mappings, _noise)


def _shown(document: tomlfile.Document) -> tuple[Shown, ...]:
    for k, given in enumerate(document.data.get("kpis", [])):
        if given["kpi"] not in BY_KEY:
            hint = did_you_mean(given["kpi"], BY_KEY)
            place = document.at("kpis", k, "kpi")
            raise ConfigError(f"{place}: kpis: no KPI '{given['kpi']}'.{hint}")
    listed = ({**k, "estimates": tuple(k.get("estimates", ()))}
              for k in document.data.get("kpis", []))  # fmt: skip
    return tuple(Shown(**given) for given in listed)


def _heat(document: tomlfile.Document) -> tuple[tuple[str, str], ...]:
    """Return pairs of numbers; a pair names two different factors."""
    factors = document.data.get("factors", {})
    numbers = [name for name, given in factors.items() if "values" not in given]
    found = []
    for k, (first, second) in enumerate(document.data.get("report", {}).get("heat", ())):
        for j, name in enumerate((first, second)):
            if name not in numbers or (j and first == second):
                place = document.at("report", "heat", k, j)
                raise ConfigError(f"{place}: report.heat: needs two factors that are numbers "
                                  f"({', '.join(numbers)}), not '{name}'."
                                  f"{did_you_mean(name, numbers)}")  # fmt: skip
        found.append((first, second))
    return tuple(found)
