"""TOML files checked against a JSON schema; errors name file, line, column, key and remedy."""

from __future__ import annotations

import json
import re
import sys
import zipfile
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

import jsonschema

from ..errors import ConfigError, did_you_mean, unreadable
from .tomlplaces import Places, places

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

TOMLDecodeError = tomllib.TOMLDecodeError
loads = tomllib.loads
POSITION = re.compile(r"\s*\(at line (\d+), column (\d+)\)$")


@dataclass(frozen=True)
class Document:
    """The content of a file that follows its schema, and where its keys stand."""

    path: Path
    data: dict[str, Any]
    places: Places

    def at(self, *keys: str | int) -> str:
        """Return `file:line:column` of a key, or of the nearest one above it."""
        return where(self.path, self.places, *keys)


def where(path: Path, known: Places, *keys: str | int) -> str:
    """Return `file:line:column` of a key, or of the nearest one above it."""
    place = known.find(*keys)
    return f"{path}:{place[0]}:{place[1]}" if place else str(path)


def read(path: Path, what: str, schema: str) -> Document:
    """Return the content of `path`, which is called `what` in errors.

    Raises
    ------
    ConfigError
        The file cannot be read, is no TOML, or breaks the schema.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
        data = loads(text)
    except OSError as error:
        raise ConfigError(unreadable(path, what, error, ".toml")) from error
    except TOMLDecodeError as error:
        raise ConfigError(_no_toml(path, str(error))) from error
    except UnicodeDecodeError as error:
        told = f"{path}: is not valid TOML: the {what} is a text in UTF-8{_packed(path)}"
        raise ConfigError(told) from error
    except (RecursionError, ValueError) as error:  # too deep, a number too long
        raise ConfigError(f"{path}: is not valid TOML: {error}") from error
    document = Document(path, data, places(text))
    _validate(document, schema)
    return document


def _packed(path: Path) -> str:
    """Return what an archive that was given for a text is good for."""
    try:
        with zipfile.ZipFile(path) as archive:
            names = archive.namelist()
    except (zipfile.BadZipFile, NotImplementedError, ValueError):
        return ""
    if "modelDescription.xml" in names:
        return "; this is an FMU, which a system file names as components.NAME.fmu"
    return "; an .ssp must be called so" if "SystemStructure.ssd" in names else ""


def _no_toml(path: Path, message: str) -> str:
    """Return a parser's message with the position where editors look for it."""
    place = POSITION.search(message)
    where = f"{path}:{place[1]}:{place[2]}" if place else str(path)
    return f"{where}: is not valid TOML: {POSITION.sub('', message)}"


def _validate(document: Document, schema: str) -> None:
    file = resources.files("dct_harness").joinpath(f"schema/{schema}")
    rules = json.loads(file.read_text("utf-8"))
    found = jsonschema.Draft202012Validator(rules).iter_errors(document.data)
    error = jsonschema.exceptions.best_match(found)
    if error is None:
        return
    keys = list(error.absolute_path)
    name = ".".join(str(part) for part in keys) or "(top level)"
    extra, remedy = _remedy(error)
    place = document.at(*keys, *extra)
    raise ConfigError(f"{place}: {name}: {_message(error)}.{remedy}")


def _message(error: Any) -> str:
    """Return what is wrong; for `oneOf` what must be there, which the schema library leaves out."""
    if error.validator not in ("oneOf", "anyOf"):
        return str(error.message)
    choices = [", ".join(rule["required"]) for rule in error.validator_value if "required" in rule]
    exactly = "exactly " * (error.validator == "oneOf")
    return f"needs {exactly}one of {', '.join(choices)}" if choices else str(error.message)


def _remedy(error: Any) -> tuple[list[str], str]:
    """Return the key that is too much, if one is, and what to do."""
    if error.validator == "additionalProperties":
        known = error.schema.get("properties", {})
        extra = next((k for k in error.instance if k not in known), "")
        return [extra], did_you_mean(extra, known) or f" Known here: {', '.join(known)}."
    if error.validator == "required":
        missing = next((k for k in error.validator_value if k not in error.instance), "")
        told = error.schema.get("properties", {}).get(missing, {}).get("description", "")
        return [], f" Add {missing} = …{f' ({told})' if told else ''}."
    if error.validator == "enum":
        return [], did_you_mean(str(error.instance), map(str, error.validator_value))
    told = error.schema.get("description", "")
    name = [error.instance] if "propertyNames" in error.absolute_schema_path else []
    return name, f" It is: {told}." if told else ""
