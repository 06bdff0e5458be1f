"""An FMU's 34 functions as C offers them, by ctypes: nothing is checked before a call is made."""

from __future__ import annotations

import ctypes
import shutil
import tempfile
import zipfile
from pathlib import Path
from typing import NamedTuple

from fmpy import read_model_description
from importer_cases import fmu

OK, WARNING, DISCARD, ERROR, FATAL, PENDING = range(6)
CO_SIMULATION = 1
LARGEST = 2**64 - 1

Uint, Int, Real, Size = ctypes.c_uint32, ctypes.c_int, ctypes.c_double, ctypes.c_size_t
Pointer, Text = ctypes.c_void_p, ctypes.c_char_p
Logger = ctypes.CFUNCTYPE(None, Pointer, Text, Int, Text, Text)


class Callbacks(ctypes.Structure):
    """`fmi2CallbackFunctions`."""

    _fields_ = (("logger", Logger), ("allocate", Pointer), ("free", Pointer),
                ("finished", Pointer), ("environment", Pointer))  # fmt: skip


class Message(NamedTuple):
    """One call of the logger."""

    instance: bytes
    status: int
    category: str
    text: str


class RawFmu:
    """A loaded library; every function by its name without `fmi2`."""

    def __init__(self, model: str, folder: Path, mode: int = ctypes.RTLD_LOCAL) -> None:
        self.description = read_model_description(str(fmu(model)))
        self.guid = self.description.guid.encode()
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.log: list[Message] = []
        self._logger = Logger(self._note)
        self._callbacks = Callbacks(self._logger, None, None, None, None)
        with zipfile.ZipFile(fmu(model)) as archive:
            path = archive.extract(f"binaries/linux64/{model}.so", folder / model)
        self._library = ctypes.CDLL(path, mode=mode)

    def _note(self, _environment: int, name: bytes, status: int, about: bytes, text: bytes) -> None:
        self.log.append(Message(name, status, about.decode(), text.decode()))

    def instantiate(
        self, name: bytes | None = b"one", kind: int = CO_SIMULATION, guid: bytes | None = b"",
        resources: bytes | None = None, logged: bool = True,
    ) -> Pointer:  # fmt: skip
        """Make an instance, of the right GUID if none is given; NULL where it refuses."""
        function = self._library.fmi2Instantiate
        function.restype = Pointer
        callbacks = ctypes.byref(self._callbacks) if logged else None
        own = self.guid if guid == b"" else guid
        return Pointer(function(name, kind, own, resources, callbacks, 0, 1))

    def __call__(self, name: str, *arguments: object) -> int:
        """Call `fmi2` + name; returns its status."""
        return getattr(self._library, f"fmi2{name}")(*arguments)

    def free(self, component: Pointer) -> None:
        """Free an instance."""
        self._library.fmi2FreeInstance(component)

    def begun(self) -> Pointer:
        """Return an instance at its first communication point."""
        component = self.instantiate()
        assert component
        assert self("EnterInitializationMode", component) == OK
        assert self("ExitInitializationMode", component) == OK
        return component

    def step(self, component: Pointer, time: float, size: float) -> int:
        """Make a step [s]; returns its status."""
        return self("DoStep", component, Real(time), Real(size), 1)

    def state(self, component: Pointer) -> Pointer:
        """Return a saved state."""
        found = Pointer()
        assert self("GetFMUstate", component, ctypes.byref(found)) == OK
        return found

    def serialised(self, component: Pointer) -> bytes:
        """Return the state of an instance as bytes."""
        state, size = self.state(component), Size()
        assert self("SerializedFMUstateSize", component, state, ctypes.byref(size)) == OK
        room = ctypes.create_string_buffer(size.value)
        assert self("SerializeFMUstate", component, state, room, size) == OK
        assert self("FreeFMUstate", component, ctypes.byref(state)) == OK
        return room.raw

    def deserialise(self, component: Pointer, data: bytes) -> int:
        """Offer bytes as a state, which is freed if it is one; returns the status."""
        state = Pointer()
        status = self("DeSerializeFMUstate", component, data, Size(len(data)), ctypes.byref(state))
        assert bool(state) == (status == OK)
        if state:
            assert self("FreeFMUstate", component, ctypes.byref(state)) == OK
        return status


def loaded(model: str, mode: int = ctypes.RTLD_LOCAL) -> RawFmu:
    """Load a copy of a library; it stays loaded, its file does not stay."""
    folder = Path(tempfile.mkdtemp())
    try:
        return RawFmu(model, folder, mode)
    finally:
        shutil.rmtree(folder)
