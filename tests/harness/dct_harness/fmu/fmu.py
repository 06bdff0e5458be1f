"""One FMI 2.0 co-simulation FMU with preallocated buffers for set, step and get."""

from __future__ import annotations

import ctypes
import hashlib
import os
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, NoReturn

import fmpy
import numpy as np
from fmpy.fmi1 import FMICallException

from ..errors import (
    ConfigError,
    FmuInvalidError,
    PlatformError,
)
from . import values as single
from .archive import described, unpack
from .discard import finish
from .host import CTYPES, lacks
from .kept import Kept
from .loader import FMU2Part, explain, missing_bytes
from .ports import GROUPS
from .slopes import continuous, followed
from .told import Failed, Told, returned
from .values import group_of

DISCARD = 2  # fmi2Status
LAST_TIME, TERMINATED = 2, 3  # fmi2LastSuccessfulTime, fmi2Terminated


class Fmu(Told):
    """A loaded instance; `close` frees everything and may be called at any point."""

    def __init__(self, name: str, path: Path, kept: Kept | None = None) -> None:
        """`kept`: where it may be open already, and goes afterwards."""
        super().__init__(name, path)
        self._idle, self._stays = kept, ""
        self.wall_time = 0.0
        self._slave: Any = None
        self._slopes: np.ndarray | None = None
        self._steer: Any = None  # how to set input derivatives
        self._alive: list[np.ndarray] = []  # buffers whose addresses the calls hold
        self._instantiated = False
        self._stepping = False
        self._directory = Path()
        digest, opened = kept.take(path) if kept else ("", None)
        if opened is not None:
            self._reopen(digest, *opened)
            return
        self._directory = unpack(path)
        try:
            self._open()
            self._stays = digest if self.is_ours and not self._resources.exists() else ""
        except BaseException:
            self.close()
            raise

    def _open(self) -> None:
        self.describe(described(self.path))
        identifier = self.description.coSimulation.modelIdentifier
        there = fmpy.supported_platforms(self._directory)
        if fmpy.platform not in there:
            what = (
                f"it is for {', '.join(there)}"
                if there
                else "it has none: ask who built it for one"
            )
            raise PlatformError(f"{self.path}: has no binary for {fmpy.platform}; {what}")
        self._slave = self._load(identifier)

    def _reopen(self, digest: str, description: Any, slave: Any) -> None:
        """Take over an FMU that an earlier run has left open."""
        self._stays = digest
        self.describe(description)
        self._slave = slave
        slave.instanceName = self.name

    @property
    def library(self) -> Path:
        """Shared library of this platform, unpacked."""
        name = self.description.coSimulation.modelIdentifier + fmpy.sharedLibraryExtension
        return self._directory / "binaries" / fmpy.platform / name

    def _load(self, identifier: str) -> Any:
        """Load the library; fmpy changes the working directory meanwhile."""
        cut = missing_bytes(self.library) if self.library.is_file() else 0
        if cut:
            raise FmuInvalidError(f"{self.path}: the library is cut short by {cut} bytes")
        here = Path.cwd()
        try:
            slave = FMU2Part(
                guid=self.description.guid, unzipDirectory=str(self._directory),
                modelIdentifier=identifier, instanceName=self.name,
            )  # fmt: skip
        except Exception as error:
            why = explain(self.library, str(error)) if self.library.is_file() else str(error)
            raise FmuInvalidError(f"{self.path}: the library does not load: {why}") from error
        finally:
            os.chdir(here)
        if lack := lacks(slave.dll):
            fmpy.freeLibrary(slave.dll._handle)
            raise FmuInvalidError(f"{self.path}: the library does not load: {lack}")
        return slave

    def identity(self) -> dict[str, str]:
        """Return what `run.json` records of the FMU."""
        return {
            "path": str(self.path), "modelName": self.description.modelName,
            "guid": self.description.guid, "sha256": self._digest(),
            "generationTool": self.description.generationTool or "",
        }  # fmt: skip

    def _digest(self) -> str:
        if self._idle is not None:
            return self._idle.digest(self.path)
        return hashlib.sha256(self.path.read_bytes()).hexdigest()

    def initialize(self, stop: float, values: dict[str, Any]) -> None:
        """Instantiate, set parameters and start values, enter initialisation mode.

        Our FMUs tell why they refuse a call, what they warn of, and their events; of others, which
        may tell of every call, only what they say unasked is heard unless `asked`.
        """
        self._call("fmi2Instantiate", lambda: self._slave.instantiate(
            callbacks=self.callbacks(), loggingOn=self.is_ours or self.asked))  # fmt: skip
        self._instantiated = True
        for name, value in values.items():
            self._set_start(name, value)
        self._call("fmi2SetupExperiment", lambda: self._slave.setupExperiment(stopTime=stop))
        self._call("fmi2EnterInitializationMode", self._slave.enterInitializationMode)

    def exit_initialization(self) -> None:
        """Leave initialisation mode; from here on `step` is legal."""
        self._call("fmi2ExitInitializationMode", self._slave.exitInitializationMode)
        self._stepping = True

    def read_parameters(self) -> single.Read:
        """Return every parameter with its value, after initialisation."""
        found: single.Read = []
        variables = self.description.modelVariables
        self._call(
            "fmi2Get (parameters)",
            lambda: found.extend(single.read_parameters(self._slave, variables)),
        )
        return found

    def parameters(self, read: single.Read) -> dict[str, dict[str, Any]]:
        """Return value and unit of parameters that were read, by name."""
        return single.described(read, self.description.modelVariables)

    def _set_start(self, name: str, value: Any) -> None:
        value = self.check_start(name, value)
        variable = self.variables[name]
        setter = getattr(self._slave, f"set{group_of(variable)}")
        reference = [variable.valueReference]
        refused = partial(self._refused, variable, value)
        self._call(f"fmi2Set{group_of(variable)}", lambda: setter(reference, [value]), refused)

    def _refused(self, variable: Any, value: Any, function: str, what: str) -> ConfigError:
        shown = value if isinstance(value, str) else np.format_float_positional(value, trim="-")
        told = f"'{self.name}.{variable.name}' = {shown} is refused: {function} {what}"
        return ConfigError(told + self.said(), variable.name)

    def bind(self, inputs: np.ndarray, outputs: np.ndarray) -> None:
        """Attach the float buffers that `set_inputs` reads and `get_outputs` writes.

        `inputs` has shape (len(self.inputs),), `outputs` shape (len(self.outputs),); both
        must be contiguous and stay alive.
        """
        self._component = ctypes.c_void_p(self._slave.component)
        self._buffers = inputs, outputs
        self._setters = self._transfers("Set", self.inputs, inputs)
        self._getters = self._transfers("Get", self.outputs, outputs)
        self._t, self._h = ctypes.c_double(), ctypes.c_double()
        function = self._slave.dll["fmi2DoStep"]
        self._do_step = partial(function, self._component, self._t, self._h, ctypes.c_int(1))

    def bind_slopes(self, slopes: np.ndarray) -> None:
        """Attach the time derivatives of the inputs, shape (len(self.inputs),).

        Steps then set them with the inputs; those of integers and the like are left out.
        """
        self._slopes = slopes
        self._followed = [k for k, v in enumerate(self.inputs) if followed(v)]
        self._attach_slopes([self.inputs[k].valueReference for k in self._followed])

    def _attach_slopes(self, references: list[int]) -> None:
        vrs, ones = np.array(references, dtype=np.uint32), np.ones(len(references), np.int32)
        values = np.zeros(len(references))
        self._alive += [vrs, ones]
        call = partial(
            self._slave.dll["fmi2SetRealInputDerivatives"], self._component,
            ctypes.c_void_p(vrs.ctypes.data), ctypes.c_size_t(len(vrs)),
            ctypes.c_void_p(ones.ctypes.data), ctypes.c_void_p(values.ctypes.data),
        )  # fmt: skip
        self._steer = (call, values) if references else None

    def _set_slopes(self) -> None:
        """Set the input derivatives, if there are any."""
        if self._steer is None or self._slopes is None:
            return
        call, values = self._steer
        self._slopes.take(self._followed, out=values)
        status = call()
        if status > 1:
            self._fail("fmi2SetRealInputDerivatives", status)

    def advance_inputs(self, h: float) -> None:
        """Bring the input buffer `h` [s] on, along the slopes: for the next part of a step."""
        if self._slopes is not None:
            self._buffers[0][:] += self._slopes * h

    @contextmanager
    def inputs_kept(self) -> Iterator[None]:
        """Give the input buffer its values back at the end."""
        given = self._buffers[0].copy()
        try:
            yield
        finally:
            self._buffers[0][:] = given

    def get_slopes(self) -> np.ndarray:
        """Return the time derivatives of the outputs; 0 of those that have none."""
        chosen = [k for k, v in enumerate(self.outputs) if continuous(v)]
        references = [self.outputs[k].valueReference for k in chosen]
        found = np.zeros(len(self.outputs))
        if chosen:
            found[chosen] = self._output_slopes(references)
        return found

    def _output_slopes(self, references: list[int]) -> Any:
        count = len(references)
        values = (ctypes.c_double * count)()
        status = self._slave.dll["fmi2GetRealOutputDerivatives"](
            self._component, (ctypes.c_uint * count)(*references), ctypes.c_size_t(count),
            (ctypes.c_int * count)(*([1] * count)), values,
        )  # fmt: skip
        if status > 1:
            self._fail("fmi2GetRealOutputDerivatives", status)
        return values

    def _transfers(
        self, verb: str, variables: list[Any], values: np.ndarray
    ) -> list[tuple[Any, ...]]:
        """Return per type: the call, the narrow buffer it uses or None, the float view.

        Arguments are made once, as the C types they have; ctypes then converts nothing per call.
        """
        transfers, first = [], 0
        for group in GROUPS:
            members = [v for v in variables if group_of(v) == group]
            view = values[first : first + len(members)]
            first += len(members)
            if not members:
                continue
            narrow = None if group == "Real" else np.zeros(len(members), dtype=np.int32)
            target = view if narrow is None else narrow
            references = np.array([v.valueReference for v in members], dtype=np.uint32)
            self._alive.append(references)
            call = partial(
                self._slave.dll[f"fmi2{verb}{group}"], self._component,
                ctypes.c_void_p(references.ctypes.data), ctypes.c_size_t(len(members)),
                ctypes.c_void_p(target.ctypes.data),
            )  # fmt: skip
            transfers.append((call, narrow, view))
        return transfers

    def set_inputs(self) -> None:
        """Write the bound input buffer to the FMU."""
        for call, narrow, view in self._setters:
            if narrow is not None:
                narrow[:] = view
            status = call()
            if status > 1:
                self._fail(call.func.__name__, status)

    def get_outputs(self) -> None:
        """Read the FMU's outputs into the bound output buffer."""
        for call, narrow, view in self._getters:
            status = call()
            if status > 1:
                self._fail(call.func.__name__, status)
            if narrow is not None:
                view[:] = narrow

    def step(self, t: float, h: float) -> None:
        """Advance from `t` to `t + h` [s] with the bound buffers."""
        self.now = t
        started = time.perf_counter()
        self._step(t, h)
        self.wall_time += time.perf_counter() - started

    def _step(self, t: float, h: float) -> None:
        if self.attempt(t, h) == DISCARD:
            finish(self, t, h)

    def attempt(self, t: float, h: float) -> int:
        """Set inputs, step, get outputs; returns fmi2Discard of a step that did not succeed."""
        self.set_inputs()
        self._set_slopes()
        self._t.value, self._h.value = t, h
        status = self._do_step()
        if status == DISCARD:
            return status
        if status > 1:
            self._fail("fmi2DoStep", status)
        self.get_outputs()
        return 0

    def reached(self) -> float | None:
        """Return fmi2LastSuccessfulTime [s] after a discarded step; None if it is not told."""
        return self._status("Real", LAST_TIME)

    def terminated(self) -> bool:
        """Return fmi2Terminated after a discarded step: it wants the simulation to end."""
        return bool(self._status("Boolean", TERMINATED))

    def _status(self, group: str, kind: int) -> float | None:
        """Return what the FMU tells of a discarded step; None if it does not."""
        value = CTYPES[group]()
        function = self._slave.dll[f"fmi2Get{group}Status"]
        status = function(self._component, ctypes.c_int(kind), ctypes.byref(value))
        return float(value.value) if status <= 1 else None

    def _call(self, function: str, action: Any, failed: Failed | None = None) -> None:
        """Call a function of the FMU; `failed` makes the error of one that does not succeed."""
        failed = failed or self.failed
        try:
            action()
        except FMICallException as error:
            raise failed(function, returned(error.status)) from error
        except Exception as error:
            raise failed(function, str(error)) from error

    def _fail(self, function: str, status: int) -> None:
        self._stepping = False
        raise self.failed(function, returned(status))

    def give_up(self, why: str) -> NoReturn:
        """Raise the error of a discarded step."""
        self._stepping = False
        raise self.failed("fmi2DoStep", f"returned fmi2Discard: {why}")

    def close(self) -> None:
        """Terminate, free, unload, remove the temporary directory; never raises."""
        slave, self._slave = self._slave, None
        try:
            if slave is not None:
                _free(slave, self._instantiated, self._stepping)
                self._put_away(slave)
        finally:
            self.remove_directory()

    def _put_away(self, slave: Any) -> None:
        """Leave the library to the next run, after a healthy one; else unload it."""
        opened = self.description, slave
        kept = self._idle if self._stepping else None
        if kept is None or not kept.give(self._stays, self.path, opened):
            fmpy.freeLibrary(slave.dll._handle)

    @property
    def _resources(self) -> Path:
        return self._directory / "resources"

    def remove_directory(self) -> None:
        """Remove the unpacked archive only."""
        if self._directory != Path():
            shutil.rmtree(self._directory, ignore_errors=True)


def _free(slave: Any, instantiated: bool, stepping: bool) -> None:
    """Terminate (only after a healthy step) and free one instance."""
    if stepping:
        slave.dll["fmi2Terminate"](ctypes.c_void_p(slave.component))
    if instantiated:
        slave.dll["fmi2FreeInstance"](ctypes.c_void_p(slave.component))
