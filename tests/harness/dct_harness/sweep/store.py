"""What a sweep has done so far: one Parquet file a run, so that a sweep that was cut can go on.

Chosen courses of signals lie in a folder beside, one Parquet file a run as well. `study.json` says
what the runs are of; a store of another study is refused. Each file is written
beside its name and renamed: it is there whole or not at all, whoever ends the process.
"""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any

from ..errors import ConfigError
from ..results import write_text

STUDY, PLAN = "study.json", "plan.json"
FOLDER, COURSES = "store", "courses"
GOOD = ("pass", "fail", "not judged")  # verdicts of runs that reached their end


def digest(*paths: Path) -> dict[str, str]:
    """Return name -> SHA-256 of files that a study depends on."""
    return {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in paths}


def course_file(out: Path, number: int) -> Path:
    """Return where the courses of a run lie."""
    return out / COURSES / f"run-{number:06d}.parquet"


class Store:
    """Rows of finished runs by their number."""

    def __init__(self, out: Path, study: dict[str, Any], resume: bool) -> None:
        """Open or begin a store.

        Raises
        ------
        ConfigError
            `resume`: what is there is of another study.
        """
        self._out, self._folder = out, out / FOLDER
        self._arrow = _pyarrow(needed=resume)
        if resume and (out / STUDY).is_file():
            _check(out / STUDY, study)
        else:
            for old in (*self._folder.glob("*.parquet"), *(out / COURSES).glob("*.parquet")):
                old.unlink()
        out.mkdir(parents=True, exist_ok=True)
        write_text(out / STUDY, json.dumps(study, indent=2) + "\n")

    def describe(self, plan: dict[str, Any]) -> None:
        """Write what a report needs to know of the plan."""
        write_text(self._out / PLAN, json.dumps(plan, indent=2, ensure_ascii=False) + "\n")

    def rows(self) -> dict[int, dict[str, Any]]:
        """Return the rows so far by run number."""
        return {} if self._arrow is None else read_rows(self._out)

    def add(self, row: dict[str, Any]) -> None:
        """Keep the row of a finished run; its courses go to a file of their own."""
        courses = row.pop(COURSES, None)
        if self._arrow is None:
            return
        if courses:
            self._write(course_file(self._out, row["run"]), self._arrow[0].table(courses))
        path = self._folder / f"run-{row['run']:06d}.parquet"
        self._write(path, self._arrow[0].Table.from_pylist([row]))

    def _write(self, path: Path, table: Any) -> None:
        """Write a file whole, or not at all."""
        path.parent.mkdir(parents=True, exist_ok=True)
        part = path.with_suffix(".part")
        # What Parquet can find out of a column is worth nothing for so few values.
        self._arrow[1].write_table(table, part, use_dictionary=False, write_statistics=False)
        os.replace(part, path)


def read_rows(out: Path) -> dict[int, dict[str, Any]]:
    """Return the rows of a sweep's folder by run number.

    Raises
    ------
    ConfigError
        pyarrow is missing, or a file is damaged.
    """
    arrow, parquet = _pyarrow(needed=True)
    found: dict[int, dict[str, Any]] = {}
    for path in sorted((out / FOLDER).glob("*.parquet")):
        try:
            (row,) = parquet.ParquetFile(path).read().to_pylist()
        except (arrow.ArrowException, ValueError, OSError) as error:
            raise ConfigError(f"{path}: {error}; remove it, its run is repeated") from error
        found[int(row["run"])] = row
    return found


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
            raise ConfigError(
                "--resume and reports of studies need `pip install 'dct-harness[sweep]'`"
            ) from error
        return None
    return pyarrow, parquet
