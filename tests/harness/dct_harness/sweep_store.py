"""What a sweep has done so far: one Parquet file a run, so that a sweep that was cut can go on.

`study.json` says what the runs are of; a store of another study is refused. Each file is written
beside its name and renamed: it is there whole or not at all, whoever ends the process.
"""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any

from .errors import ConfigError
from .results import write_text

STUDY = "study.json"
FOLDER = "store"


def digest(*paths: Path) -> dict[str, str]:
    """Return name -> SHA-256 of files that a study depends on."""
    return {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in paths}


class Store:
    """Rows of finished runs by their number."""

    def __init__(self, out: Path, study: dict[str, Any], resume: bool) -> None:
        """Open or begin a store.

        Raises
        ------
        ConfigError
            `resume`: what is there is of another study.
        """
        self._folder = out / FOLDER
        self._arrow = _pyarrow(needed=resume)
        if resume and (out / STUDY).is_file():
            _check(out / STUDY, study)
        else:
            for old in self._folder.glob("*.parquet"):
                old.unlink()
        out.mkdir(parents=True, exist_ok=True)
        write_text(out / STUDY, json.dumps(study, indent=2) + "\n")

    def rows(self) -> dict[int, dict[str, Any]]:
        """Return the rows so far by run number."""
        if self._arrow is None:
            return {}
        arrow, parquet = self._arrow
        found: dict[int, dict[str, Any]] = {}
        for path in sorted(self._folder.glob("*.parquet")):
            try:
                (row,) = parquet.read_table(path).to_pylist()
            except (arrow.ArrowException, ValueError, OSError) as error:
                raise ConfigError(f"{path}: {error}; remove it, its run is repeated") from error
            found[int(row["run"])] = row
        return found

    def add(self, row: dict[str, Any]) -> None:
        """Keep the row of a finished run."""
        if self._arrow is None:
            return
        arrow, parquet = self._arrow
        self._folder.mkdir(parents=True, exist_ok=True)
        path = self._folder / f"run-{row['run']:06d}.parquet"
        part = path.with_suffix(".part")
        parquet.write_table(arrow.Table.from_pylist([row]), part)
        os.replace(part, path)


def _check(path: Path, study: dict[str, Any]) -> None:
    try:
        known = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise ConfigError(f"{path}: {error}; leave --resume out to begin anew") from None
    now = json.loads(json.dumps(study))
    changed = [key for key in {**known, **now} if known.get(key) != now.get(key)]
    if changed:
        raise ConfigError(
            f"{path}: is of another sweep: {', '.join(changed)} changed; "
            "choose another --out, or leave --resume out to begin anew"
        )


def _pyarrow(needed: bool) -> Any:
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError as error:
        if needed:
            raise ConfigError("--resume needs `pip install 'dct-harness[sweep]'`") from error
        return None
    return pyarrow, parquet
