"""`run --engine native`: the compiled master `cosim_native` steps the loop, to the same bits.

Python still loads the FMUs, connects them and writes what `run.json` says of them; the compiled
master gets the finished plan, and gives all rows back at once. It makes instances of its own,
without a log. FMUs that this project did not build, and with them the loop, run in another process.
"""

from __future__ import annotations

import importlib
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from .errors import ConfigError, FmuInvalidError, FmuRuntimeError, HarnessError, RunTimeoutError
from .isolated import Isolated
from .mapped import Mapped
from .master import Run
from .values import start_value

REMEDY = "run it with --engine fmpy"
ERRORS = {"run": FmuRuntimeError, "fmu": FmuInvalidError, "configuration": ConfigError}
PLAN, INPUT, OUTPUT = "plan.json", "input.npz", "output.npz"  # what processes exchange
Made = tuple[np.ndarray, HarnessError | None]


class NativeRun(Run):
    """As `Run`; its loop is compiled."""

    def _loop(self, progress: Callable[[int, int], None] | None) -> None:
        """Make all rows; those before a failure are kept."""
        plan = json.dumps(self._plan())
        foreign = any(isinstance(fmu, Isolated) for fmu in self.fmus.values())
        rows, error = self._apart(plan) if foreign else made(plan, self.times, self.script)
        self._samples[: len(rows)] = rows
        self.rows = self._samples[: len(rows)]
        if self.abort is not None:
            raise self.abort
        if error is not None:
            raise error
        if progress is not None:
            progress(len(rows) - 1, len(rows) - 1)

    def _plan(self) -> dict[str, Any]:
        """Return the loop as `cosim_master::Plan` in JSON."""
        if self.system.interpolate:
            raise ConfigError(
                f"{self.system.path}: interpolate: the native engine has no input derivatives; "
                f"{REMEDY}"
            )
        return {
            "components": [self._component(name) for name in self.fmus],
            "coupling": self.system.coupling,
            "script": [n.removeprefix("scenario.") for n in self.names[: self.script.shape[1]]],
        }

    def _component(self, name: str) -> dict[str, Any]:
        fmu, component = self.fmus[name], self.system.components[name]
        if isinstance(fmu, Mapped):
            raise ConfigError(f"--map: the native engine takes no mapped FMU; {REMEDY}")
        start = [[n, start_value(name, fmu.variables[n], v)]
                 for n, v in component.parameters.items()]  # fmt: skip
        return {
            "name": name, "fmu": str(fmu.path), "start": start, "substeps": component.substeps,
            "inputs": [self._input(f"{name}.{v.name}", v.name) for v in fmu.inputs],
        }  # fmt: skip

    def _input(self, target: str, name: str) -> dict[str, Any]:
        change = self.transforms.get(target)
        line = {"line": [change.factor, change.offset]} if change else {}
        table = {"table": list(change.table.items())} if change and change.table else {}
        column = self.noise.reads(self.sources[target])
        noise = {"noise": column} if column else {}
        return {"name": name, "source": self.sources[target], **line, **table, **noise}

    def _apart(self, plan: str) -> Made:
        """Make the rows in another process, with the limits of foreign FMUs."""
        seconds = self.limits.seconds
        with TemporaryDirectory(prefix="dct-harness-") as name:
            folder = Path(name)
            (folder / PLAN).write_text(plan, encoding="utf-8")
            np.savez(folder / INPUT, times=self.times, script=self.script)
            command = [sys.executable, "-m", __name__, name, str(int(self.limits.memory))]
            inside = {**os.environ, "TMPDIR": name}  # what a crash leaves goes with the folder
            try:
                done = subprocess.run(
                    command, timeout=seconds, capture_output=True, check=False, env=inside
                )
            except subprocess.TimeoutExpired as error:
                raise RunTimeoutError(
                    f"the native loop took longer than {seconds:g} s (--call-timeout)"
                ) from error
            if done.returncode or not (folder / OUTPUT).is_file():
                raise FmuRuntimeError(
                    f"the process of the native loop ended with {_ending(done.returncode)}; "
                    f"{REMEDY} to see in which FMU and call"
                )
            return _read(folder / OUTPUT)


def _ending(code: int) -> str:
    return f"signal {-code}" if code < 0 else f"exit code {code}"


def _read(path: Path) -> Made:
    with np.load(path) as told:
        kind, text = (str(part) for part in told["error"])
        return told["rows"], ERRORS[kind](text) if kind else None


def made(plan: str, times: np.ndarray, script: np.ndarray) -> Made:
    """Return the rows of one loop, shape (samples, signals), and why they are not all there.

    Raises
    ------
    ConfigError
        The module `cosim_native` is not installed.
    """
    try:
        native = importlib.import_module("cosim_native")
    except ImportError as missing:
        raise ConfigError(
            "--engine native needs the module cosim_native: `cargo xtask native` builds it"
        ) from missing
    _, rows, error = native.run([plan], times, np.ascontiguousarray(script))[0]
    return rows, ERRORS[error[0]](error[1]) if error else None


def main(folder: Path, memory: int) -> None:
    """Make the rows of a plan in this process, after limiting its memory [MiB]."""
    from .host import limit

    limit(memory * (1 << 20))
    with np.load(folder / INPUT) as given:
        rows, error = made((folder / PLAN).read_text("utf-8"), given["times"], given["script"])
    kind = next((k for k, cls in ERRORS.items() if type(error) is cls), "")
    np.savez(folder / OUTPUT, rows=rows, error=np.array([kind, str(error or "")]))


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]))
