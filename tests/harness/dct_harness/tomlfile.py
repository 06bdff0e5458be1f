"""TOML files checked against a JSON schema; errors name file, line, key and remedy."""

from __future__ import annotations

import json
import re
import sys
from importlib import resources
from pathlib import Path
from typing import Any

import jsonschema

from .errors import ConfigError, did_you_mean

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

TOMLDecodeError = tomllib.TOMLDecodeError
loads = tomllib.loads


def read(path: Path, what: str, schema: str) -> dict[str, Any]:
    """Return the content of `path`, which is called `what` in errors.

    Raises
    ------
    ConfigError
        The file cannot be read, is no TOML, or breaks the schema.
    """
    try:
        text = path.read_text(encoding="utf-8")
        data = loads(text)
    except OSError as error:
        raise ConfigError(f"{path}: cannot read the {what}: {error.strerror}") from error
    except (TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path}: is not valid TOML: {error}") from error
    _validate(path, text, data, schema)
    return data


def line_of(text: str, keys: list[Any]) -> int | None:
    """Return the line of a key in TOML text, as far as a look at headers and keys tells it.

    `keys` is the path from the top; a number is an index into an array of tables.
    """
    headers = re.compile(r"^\s*\[+\s*(.+?)\s*\]+\s*(?:#.*)?$")
    names = [str(k) for k in keys if not isinstance(k, int)]
    skip = next((k for k in keys if isinstance(k, int)), 0)
    prefix: list[str] = []
    best, depth, seen = None, 0, -1
    for number, line in enumerate(text.splitlines(), 1):
        header = headers.match(line)
        if header:
            prefix = _split(header.group(1))
            seen += line.lstrip().startswith("[[") and prefix == names[: len(prefix)]
            found = prefix
        else:
            key = line.partition("=")[0].strip()
            found = prefix + _split(key) if "=" in line and not key.startswith("#") else []
        counted = skip == 0 or seen == skip
        if found and counted and found == names[: len(found)] and len(found) > depth:
            best, depth = number, len(found)
    return best


def _split(key: str) -> list[str]:
    """Return the parts of a dotted key."""
    parts = re.findall(r'"([^"]*)"|\'([^\']*)\'|([\w-]+)', key)
    return [next((p for p in part if p), "") for part in parts]


def _validate(path: Path, text: str, data: dict[str, Any], schema: str) -> None:
    rules = json.loads(resources.files(__package__).joinpath(f"schema/{schema}").read_text("utf-8"))
    found = jsonschema.Draft202012Validator(rules).iter_errors(data)
    error = jsonschema.exceptions.best_match(found)
    if error is None:
        return
    keys, hint = list(error.absolute_path), ""
    if error.validator == "additionalProperties":
        known = error.schema.get("properties", {})
        extra = next((k for k in error.instance if k not in known), "")
        keys, hint = [*keys, extra], did_you_mean(extra, known)
    line = line_of(text, keys)
    where = f"{path}:{line}" if line else str(path)
    key = ".".join(str(part) for part in error.absolute_path) or "(top level)"
    raise ConfigError(f"{where}: {key}: {error.message}.{hint}")
