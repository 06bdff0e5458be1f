"""An FMU in a process of its own, with limits of time and memory: `Fmu` by another road.

Whatever it does (crash, hang, exit, fork, flood the log, change directory) ends in an error that
names component, call and time; the samples until then are kept.
"""

from __future__ import annotations

import contextlib
import mmap
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fmpy
import numpy as np

from ..errors import FmuInvalidError, FmuRuntimeError, HarnessError, RunTimeoutError, instant
from .archive import described
from .fmu import DISCARD, Fmu
from .host import CALLS, FORKED, HEAD, MORE
from .kept import Kept
from .loader import explain
from .ports import GROUPS, is_ours
from .remote import Remote
from .told import Failed, returned, word
from .values import group_of

EXCHANGE = ".dct-harness-exchange"


@dataclass(frozen=True)
class Limits:
    """What a foreign FMU may take: `seconds` per call, `memory` [MiB] beside the interpreter's.

    `isolate` is "foreign", "all" or "none": whose FMUs run in a process of their own. `log`: it is
    asked to log what it does.
    """

    seconds: float = 60.0
    memory: float = 4096.0
    isolate: str = "foreign"
    log: bool = False


def load(name: str, path: Path, limits: Limits | None = None, kept: Kept | None = None) -> Fmu:
    """Load an FMU, in a process of its own unless this project built it.

    `kept`: where one that this project built may be open already.
    """
    limits = limits or Limits()
    if kept is not None and limits.isolate != "all" and kept.has(path):
        return Fmu(name, path, kept)
    if limits.isolate == "none":
        fmu = Fmu(name, path)
        fmu.asked = limits.log
        return fmu
    description = described(path)  # kept until the FMU has it as well
    if is_ours(description) and limits.isolate != "all":
        return Fmu(name, path, kept)
    return Isolated(name, path, limits)


class Isolated(Fmu):
    """As `Fmu`; the library is loaded in another process."""

    def __init__(self, name: str, path: Path, limits: Limits) -> None:
        self.limits = limits
        self._process: Remote | None = None
        self._shared: Any = None
        self._dropped, self._moved = 0, False
        super().__init__(name, path)
        self.asked = limits.log

    @property
    def _remote(self) -> Remote:
        """The process of the FMU; an error after `close`."""
        if self._process is None:
            raise FmuRuntimeError(f"{self.name} is closed")
        return self._process

    def _load(self, identifier: str) -> Any:
        self._process = Remote(self.name, self.limits.seconds)
        tool = str(self.description.coSimulation.needsExecutionTool).lower() == "true"
        why = self._remote.ask(
            "load", "loading its library", library=str(self.library), proxy=_proxy(), tool=tool,
            memory=int(self.limits.memory * (1 << 20)),
        )  # fmt: skip
        if why:
            why = explain(self.library, why) if self.library.is_file() else why
            raise FmuInvalidError(f"{self.path}: the library does not load: {why}")
        return _Slave(self, self._remote)

    def callbacks(self) -> None:
        """Callbacks live in the other process."""

    def _call(self, function: str, action: Any, failed: Failed | None = None) -> None:
        failed = failed or self.failed
        try:
            action()
            self._collect()
        except HarnessError:
            raise
        except Exception as error:
            self._collect()
            raise failed(function, str(error)) from error

    def _collect(self) -> None:
        """Take the messages of the FMU over."""
        told = self._remote.ask("told", self.doing("the log"))
        for status, category, message in told["messages"]:
            self.note(word(status), category, message.replace("##", "#"))
        if told["dropped"] > self._dropped:
            if self._dropped == 0:
                self.note("Warning", "harness", "floods its log: further messages are dropped")
            self._dropped = told["dropped"]
        if Path(told["folder"]) != Path.cwd() and not self._moved:
            self._moved = True
            self.note("Warning", "harness", f"changed its working directory: {told['folder']}")

    def doing(self, function: str) -> str:
        """Return a call and its time, for errors."""
        return f"{function} at t = {instant(self.now)} s"

    def bind(self, inputs: np.ndarray, outputs: np.ndarray) -> None:
        """Attach the float buffers, as `Fmu.bind`; numbers pass through a mapped file."""
        path = self._directory / EXCHANGE
        count = HEAD + 2 * len(inputs) + len(outputs)
        path.write_bytes(bytes(8 * count))
        with path.open("r+b") as file:
            shared = mmap.mmap(file.fileno(), 0)
        numbers = np.frombuffer(shared, dtype=np.float64)
        self._shared = numbers
        self._buffers = inputs, outputs
        self._sent = numbers[HEAD : HEAD + len(inputs)]
        self._got = numbers[HEAD + len(inputs) : HEAD + len(inputs) + len(outputs)]
        self._turned = numbers[HEAD + len(inputs) + len(outputs) :]
        ends = {"inputs": _references(self.inputs), "outputs": _references(self.outputs)}
        self._remote.ask("bind", self.doing("bind"), path=str(path), **ends)

    def _attach_slopes(self, references: list[int]) -> None:
        self._steer = references or None
        self._remote.ask("attach_slopes", self.doing("bind"), references=references)

    def _output_slopes(self, references: list[int]) -> Any:
        doing = self.doing("fmi2GetRealOutputDerivatives")
        status, values = self._remote.ask("output_slopes", doing, references=references)
        if status > 1:
            self._fail("fmi2GetRealOutputDerivatives", status)
        return values

    def set_inputs(self) -> None:
        """Write the bound input buffer to the FMU."""
        self._sent[:] = self._buffers[0]
        self._do(b"I", "setting inputs")

    def get_outputs(self) -> None:
        """Read the FMU's outputs into the bound output buffer."""
        self._do(b"O", "reading outputs")
        self._buffers[1][:] = self._got

    def attempt(self, t: float, h: float) -> int:
        """As `Fmu.attempt`."""
        self._sent[:] = self._buffers[0]
        self._shared[0], self._shared[1] = t, h
        if self._steer is not None and self._slopes is not None:
            self._slopes.take(self._followed, out=self._turned[: len(self._followed)])
        if self._do(b"S", "fmi2DoStep") == DISCARD:
            return DISCARD
        self._buffers[1][:] = self._got
        return 0

    def _status(self, group: str, kind: int) -> float | None:
        doing = self.doing(f"fmi2Get{group}Status")
        status, value = self._remote.ask("status", doing, group=group, kind=kind)
        return float(value) if status <= 1 else None

    def _do(self, letter: bytes, what: str) -> int:
        """Send a request; returns 0, or fmi2Discard of fmi2DoStep."""
        status = self._remote.send(letter, self.doing(what))
        if status == 0:
            return 0
        if status % MORE == FORKED:
            raise self._remote.forked(self.doing(what))
        if status >= MORE:
            self._collect()
        call = CALLS[int(self._shared[2]) % len(CALLS)]
        if status % MORE == DISCARD and letter == b"S" and call == "fmi2DoStep":
            return DISCARD
        if status % MORE > 1:
            self._fail(call, status % MORE)
        return 0

    def close(self) -> None:
        """Terminate and free if the process still answers; end it, remove the directory."""
        self._slave = None
        try:
            if self._process is not None:
                self._part(self._process)
        finally:
            self._process = None
            self.remove_directory()

    def _part(self, remote: Remote) -> None:
        remote.seconds = min(remote.seconds, 5.0)
        with contextlib.suppress(FmuRuntimeError, RunTimeoutError, OSError, ValueError):
            if self._instantiated:
                self._collect()
            if self._stepping:
                remote.ask("call", "fmi2Terminate", function="fmi2Terminate")
            if self._instantiated:
                remote.ask("call", "fmi2FreeInstance", function="fmi2FreeInstance")
        remote.close()

    def remove_directory(self) -> None:
        """Remove the unpacked archive, and the process if it is still there."""
        if self._process is not None:
            self._process.kill()
        super().remove_directory()


class _Slave:
    """What `Fmu` calls of fmpy's FMU2Slave."""

    def __init__(self, fmu: Isolated, remote: Remote) -> None:
        self._fmu, self._remote = fmu, remote

    def _checked(self, doing: str, do: str, **more: Any) -> None:
        status = self._remote.ask(do, self._fmu.doing(doing), **more)
        if status > 1:
            raise RuntimeError(returned(status))

    def instantiate(self, callbacks: None, loggingOn: bool) -> None:
        """Call fmi2Instantiate with callbacks of the other process."""
        resources = (self._fmu._directory / "resources").as_uri()
        self._checked("fmi2Instantiate", "instantiate", name=self._fmu.name,
                      guid=self._fmu.description.guid, resources=resources,
                      logging=loggingOn)  # fmt: skip

    def setupExperiment(self, stopTime: float) -> None:
        """Call fmi2SetupExperiment."""
        self._checked("fmi2SetupExperiment", "setup", stop=stopTime)

    def enterInitializationMode(self) -> None:
        """Call fmi2EnterInitializationMode."""
        self._checked("fmi2EnterInitializationMode", "call", function="fmi2EnterInitializationMode")

    def exitInitializationMode(self) -> None:
        """Call fmi2ExitInitializationMode."""
        self._checked("fmi2ExitInitializationMode", "call", function="fmi2ExitInitializationMode")

    def __getattr__(self, name: str) -> Any:
        """Return setReal, getReal and so on."""
        verb, group = name[:3], name[3:]
        if verb not in ("set", "get") or group not in (*GROUPS, "String"):
            raise AttributeError(name)
        if verb == "set":
            return lambda references, values: self._checked(
                f"fmi2Set{group}", "set", group=group, references=references, values=values
            )
        return lambda references: self._get(group, references)

    def _get(self, group: str, references: list[int]) -> list[Any]:
        doing = self._fmu.doing(f"fmi2Get{group}")
        status, values = self._remote.ask("get", doing, group=group, references=references)
        if status > 1:
            raise RuntimeError(f"fmi2Get{group} {returned(status)}")
        return [v.encode() for v in values] if group == "String" else values


def _references(variables: list[Any]) -> dict[str, list[int]]:
    """Return value references by type, in the order of the variables."""
    return {g: [v.valueReference for v in variables if group_of(v) == g] for g in GROUPS}


def _proxy() -> str:
    """Return the library of fmpy that formats log messages; empty if it has none."""
    name = f"logging{fmpy.sharedLibraryExtension}"
    path = Path(fmpy.__file__).parent / "logging" / fmpy.platform / name
    return str(path) if path.is_file() else ""
