"""Runs of `examples/closed_loop` through the harness, each made once per test session."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from dct_harness import cli, results

ROOT = Path(__file__).resolve().parent.parent
FMUS = ROOT / "target" / "fmu"
SYSTEMS = ROOT / "examples" / "closed_loop"
GOLDEN = ROOT / "tests" / "golden"


def run(system: str, settings: tuple[str, ...], out: Path) -> results.Results:
    """Run a system file with `component.variable=value` settings; returns its signals (SI)."""
    command = ["run", str(SYSTEMS / f"{system}.toml"), "--fmu-dir", str(FMUS), "--out", str(out)]
    command += ["--quiet", *(word for text in settings for word in ("--set", text))]
    assert cli.main(command) == 0, f"{system} {settings}"
    return results.load(out)


class Runs:
    """Runs by system and settings; a run is made when it is first asked for."""

    def __init__(self, directory: Path) -> None:
        self._directory = directory
        self._made: dict[tuple[str, ...], results.Results] = {}

    def __call__(self, system: str, *settings: str) -> results.Results:
        """Return the signals of a run."""
        key = (system, *settings)
        if key not in self._made:
            self._made[key] = run(system, settings, self._directory / str(len(self._made)))
        return self._made[key]

    def folder(self, system: str, *settings: str) -> Path:
        """Return the results of a run that was made."""
        return self._directory / str(list(self._made).index((system, *settings)))


def golden_rows(case: str) -> dict[str, np.ndarray]:
    """Return the rows of a golden reference by FMI name, shape (rows,) each, SI units."""
    table = np.genfromtxt(GOLDEN / f"{case}.csv", delimiter=",", names=True, deletechars="")
    return {name: table[name] for name in table.dtype.names}


def golden_json(name: str) -> list | dict:
    """Return a JSON file of the golden references."""
    return json.loads((GOLDEN / f"{name}.json").read_text(encoding="utf-8"))


def rms(values: np.ndarray) -> float:
    """Return the root of the mean square of `values`, shape (n,)."""
    return float(np.sqrt(np.mean(np.square(values))))
