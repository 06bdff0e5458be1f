"""`run --engine native`: the compiled master `cosim_native` steps the loop, to the same bits.

Python still loads the FMUs, connects them and writes what `run.json` says of them; the compiled
master gets the finished plan, and fills all rows at once. It makes instances of its own,
and their messages stand for those of Python's. FMUs that this project did not build, and with them
the loop, run in another process. Ctrl-C and a time limit end either at a communication point.
"""

from __future__ import annotations

import importlib
import json
import math
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.lib.format import open_memmap

from ..errors import (
    ConfigError,
    FmuInvalidError,
    FmuRuntimeError,
    HarnessError,
    InterruptedRunError,
    RunTimeoutError,
)
from ..fmu.isolated import Isolated
from ..fmu.slopes import continuous, followed
from ..fmu.told import word
from ..fmu.values import start_value
from ..supplier.links import Link
from ..supplier.mapped import Mapped, their_value
from . import native_process
from .master import Run
from .native_process import DONE, END, INPUT, OUTPUT, PLAN, ROWS, STEPS

REMEDY = "run it with --engine fmpy"
ERRORS = {"run": FmuRuntimeError, "fmu": FmuInvalidError, "configuration": ConfigError,
          "ended": InterruptedRunError}  # fmt: skip
NEWEST = "Fmus"  # what cosim_native has had only since its interface is the present one
NOT_YET = -1  # steps of a process in which no FMU is at work
BEAT = 0.05  # s between two looks at the other process
GRACE = 1.0  # s; a call into an FMU that takes longer than this past the end hangs
Said = Sequence[tuple[str, list[tuple[float, int, str, str]]]]  # time [s], status, category, text
Ended = Callable[[int], bool]  # of the steps so far, whether the loop is to end
Made = tuple[np.ndarray, HarnessError | None, Said]


class NativeRun(Run):
    """As `Run`; its loop is compiled."""

    _said: Said = ()
    _unpacked = ""  # the folder of the instances' files

    def execute(self, progress: Callable[[int, int], None] | None = None) -> None:
        """As `Run.execute`; the log is that of the instances that ran."""
        compiled()
        try:
            super().execute(progress)
        finally:
            for name, messages in self._said:
                self.fmus[name].log[:] = [_message(name, *said) for said in messages]

    def _loop(self, progress: Callable[[int, int], None] | None) -> None:
        """Make all rows; those before a failure are kept."""
        inner = (f.inner if isinstance(f, Mapped) else f for f in self.fmus.values())
        foreign = any(isinstance(fmu, Isolated) for fmu in inner)
        self._make_all_room()
        plan = json.dumps(self._plan())
        last = len(self.times) - 1

        def ended(steps: int) -> bool:
            if progress is not None:
                progress(steps, last)
            if self.abort is not None and not foreign:  # it may be that no call returns any more
                self.rows = _good(self._samples)
            return self.abort is not None

        if foreign:
            rows, error, self._said = self._apart(plan, ended)
        else:
            with self._fmus() as fmus:
                work = (plan, self.times, self.script, fmus)
                rows, error, self._said = made(*work, ended, out=[self._samples])
        self.rows = rows
        if isinstance(error, InterruptedRunError) and self.abort is not None:
            raise self._stopped(self.abort, float(self.times[len(rows) - 1]))
        if error is not None:
            raise error
        if progress is not None:
            progress(last, last)

    @contextmanager
    def _fmus(self) -> Iterator[Any]:
        """Give FMUs of the compiled master: of earlier runs, or new ones that go afterwards."""
        kept = self.kept_open
        if kept is None:
            with TemporaryDirectory(prefix="dct-harness-") as self._unpacked:
                yield compiled().Fmus(self._unpacked)
            return
        self._unpacked = str(kept.folder)
        files = sorted((str(path), kept.digest(path)) for path in self.paths.values())
        if kept.compiled[0] != files:
            kept.compiled = files, compiled().Fmus(kept.folder)
        yield kept.compiled[1]

    def _make_room(self) -> None:
        """Find memory for the first sample."""
        self._samples = np.zeros((1, len(self.names)))

    def _make_all_room(self) -> None:
        """Find memory for all samples, of the wanted signals in the order of all."""
        first = self._samples[0]
        if self.wanted is not None:
            wanted = self.wanted(tuple(self.names))
            places = [k for k, name in enumerate(self.names) if name in wanted]
            self.kept, first = [self.names[k] for k in places], first[places]
        self._samples = np.full((len(self.times), len(first)), np.nan)
        self._samples[0] = first
        self.rows = self._samples[:1]

    def remove_directories(self) -> None:
        """As `Run.remove_directories`."""
        super().remove_directories()
        if self._unpacked:
            shutil.rmtree(self._unpacked, ignore_errors=True)

    def _plan(self) -> dict[str, Any]:
        """Return the loop as `cosim_master::Plan` in JSON."""
        return {
            "components": [self._component(name) for name in self.fmus],
            "coupling": self.system.coupling,
            "interpolate": self.system.interpolate,
            "log": self.limits.log,
            "script": [n.removeprefix("scenario.") for n in self.names[: self.script.shape[1]]],
            **({} if self.kept is self.names else {"record": self.kept}),
        }

    def _component(self, name: str) -> dict[str, Any]:
        fmu, component = self.fmus[name], self.system.components[name]
        given = dict(their_value(fmu, n, v) for n, v in component.parameters.items())
        own = fmu.inner.variables if isinstance(fmu, Mapped) else fmu.variables
        start = [[n, start_value(name, own[n], v)] for n, v in given.items()]
        mapped = {"mapped": _mapped(fmu)} if isinstance(fmu, Mapped) else {}
        return {
            "name": name, "fmu": str(fmu.path), "start": start, "substeps": component.substeps,
            "inputs": self._inputs(name, [v.name for v in fmu.inputs]), **mapped,
        }  # fmt: skip

    def _inputs(self, name: str, inputs: list[str]) -> list[dict[str, Any]]:
        """Return the inputs of a component, with the initial values that Python has settled."""
        settled = self._members[list(self.fmus).index(name)].values
        told = [self._input(f"{name}.{n}", n) for n in inputs]
        if np.all(np.isfinite(settled)):
            told = [{**t, "initial": float(x)} for t, x in zip(told, settled, strict=True)]
        return told

    def _input(self, target: str, name: str) -> dict[str, Any]:
        change = self.transforms.get(target)
        line = {"line": [change.factor, change.offset]} if change else {}
        table = {"table": list(change.table.items())} if change and change.table else {}
        column = self.noise.reads(self.sources[target])
        noise = {"noise": column} if column else {}
        return {"name": name, "source": self.sources[target], **line, **table, **noise}

    def _apart(self, plan: str, ended: Ended) -> Made:
        """Make the rows in another process, with the limits of foreign FMUs."""
        with TemporaryDirectory(prefix="dct-harness-") as name:
            folder = Path(name)
            (folder / PLAN).write_text(plan, encoding="utf-8")
            np.savez(folder / INPUT, times=self.times, script=self.script)
            rows = open_memmap(folder / ROWS, "w+", shape=self._samples.shape)
            rows[:] = self._samples
            command = [
                sys.executable,
                "-m",
                native_process.__name__,
                name,
                str(int(self.limits.memory)),
            ]
            inside = {**os.environ, "TMPDIR": name}  # what a crash leaves goes with the folder
            null = subprocess.DEVNULL
            with subprocess.Popen(command, env=inside, stdout=null, stderr=null) as process:
                try:
                    code = self._awaited(process, folder, ended)
                finally:
                    process.kill()
                    self.rows = np.array(_good(rows))
            if code or not (folder / OUTPUT).is_file():
                raise FmuRuntimeError(
                    f"the process of the native loop ended with {_ending(code)}; "
                    f"{REMEDY} to see in which FMU and call"
                )
            return self.rows, *_read(folder / OUTPUT)

    def _awaited(self, process: subprocess.Popen[bytes], folder: Path, ended: Ended) -> int:
        """Return the exit code of the other process, which ends early when it is told to.

        From when FMUs are at work there, each step has the time that a call may take.
        """
        seconds, made = self.limits.seconds, NOT_YET
        limit = end = math.inf
        while True:
            try:
                return process.wait(BEAT)
            except subprocess.TimeoutExpired:
                now = time.monotonic()
            if (folder / DONE).exists():
                self.at_work = False
                return process.wait()
            steps = _steps(folder)
            if steps > made:
                made, limit = steps, now + seconds
            if ended(max(made, 0)) and not (folder / END).exists():
                (folder / END).touch()
                end = now + GRACE
            if now > min(limit, end):
                if self.abort is not None:
                    raise type(self.abort)(f"an FMU does not return: {self.abort}")
                raise RunTimeoutError(
                    f"a step of the native loop took longer than {seconds:g} s (--call-timeout)"
                )


def _mapped(fmu: Mapped) -> dict[str, Any]:
    """Return what stands between our names and the supplier's as `cosim_master::plan::Mapped`."""
    return {
        "file": str(fmu.file),
        "inputs": [_link(k, followed(k.ours)) for k in fmu.into],
        "outputs": [_link(k, continuous(k.ours)) for k in fmu.out],
        "sums": [{"ours": e.name, "terms": e.terms, "moves": continuous(v)}
                 for e, v in fmu.sums],
    }  # fmt: skip


def _link(link: Link, moves: bool) -> dict[str, Any]:
    return {"ours": link.ours.name, "theirs": link.theirs.name, "gain": link.gain,
            "shift": link.shift, "table": link.table, "moves": moves}  # fmt: skip


def _message(component: str, time: float, status: int, category: str, text: str) -> dict[str, Any]:
    """Return a message as `Fmu.log` has it."""
    return {"component": component, "time": time, "status": word(status), "category": category,
            "message": text}  # fmt: skip


def _ending(code: int) -> str:
    return f"signal {-code}" if code < 0 else f"exit code {code}"


def _good(rows: np.ndarray) -> np.ndarray:
    """Return the rows before the first one that is not all numbers: those that are made."""
    good = np.isfinite(rows).all(axis=1)
    return rows if good.all() else rows[: int(np.argmin(good))]


def _read(path: Path) -> tuple[HarnessError | None, Said]:
    with np.load(path) as told:
        kind, text = (str(part) for part in told["error"])
        return ERRORS[kind](text) if kind else None, json.loads(str(told["log"]))


def made(
    plan: str, times: np.ndarray, script: np.ndarray, fmus: Any, ended: Ended,
    out: list[np.ndarray],
) -> Made:  # fmt: skip
    """Return the rows of one loop, shape (samples, signals), why they are not all there, the log.

    `fmus` of the compiled master are used and added to. `ended` is asked from time to time, with
    the number of steps so far; the rows lie in `out`.
    """
    work = ([plan], times, np.ascontiguousarray(script))
    _, rows, error, log = compiled().run(*work, out=out, fmus=fmus, watch=ended)[0]
    return rows, ERRORS[error[0]](error[1]) if error else None, log


def compiled() -> Any:
    """Return the compiled master.

    Raises
    ------
    ConfigError
        The module `cosim_native` is not installed, or was built for another version.
    """
    try:
        native = importlib.import_module("cosim_native")
    except ImportError as missing:
        raise ConfigError(
            "--engine native needs the module cosim_native: `cargo xtask native` builds it"
        ) from missing
    if not hasattr(native, NEWEST):
        raise ConfigError(
            "the module cosim_native is of another version: `cargo xtask native` builds it anew"
        )
    return native


def _steps(folder: Path) -> int:
    """Return how far the other process is; NOT_YET, too, while that is just being written."""
    try:
        return int((folder / STEPS).read_text(encoding="utf-8"))
    except (FileNotFoundError, ValueError):
        return NOT_YET
