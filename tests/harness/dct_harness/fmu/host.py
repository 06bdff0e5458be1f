"""The process that a foreign FMU runs in; it answers requests on its pipes, one at a time.

It imports the standard library only, so that it starts in 30 ms. Requests and answers:

    letter  I set inputs, O get outputs, S set inputs, step, get outputs      answer: one byte, the
            status 0 to 6 of the first call that failed; 100 added when there are messages
    J + length (4 bytes) + JSON {"do": name, ...}                             answer: length + JSON

Numbers of the letters travel in a file mapped into both processes: t, h, which call failed, then
inputs, outputs, derivatives of inputs, all float64. What comes from the FMU is never unpickled or
evaluated. The byte READY comes before all answers.
"""

from __future__ import annotations

import ctypes
import json
import mmap
import os
import sys
from collections.abc import Callable
from typing import Any

HEAD = 3  # float64 before the inputs: t, h, failed call
MESSAGES = 1000  # kept of one instance; a flood is counted
SEVERE, ERRORS = 2, 100  # fmi2Discard; so many from there on are kept of a flood, too
LONGEST = 4000  # bytes of a message
MORE = 100  # added to a status when there are messages
FORKED = 50  # status: the FMU has started a process
READY = b"R"  # the process runs, and nothing of an FMU in it yet
MISSING = 6  # status: the FMU has no such function
NEEDED = (
    "fmi2Instantiate", "fmi2FreeInstance", "fmi2SetupExperiment", "fmi2EnterInitializationMode",
    "fmi2ExitInitializationMode", "fmi2Terminate", "fmi2DoStep",
)  # fmt: skip
GROUPS = ("Real", "Integer", "Boolean")
CALLS = ("fmi2SetReal", "fmi2SetInteger", "fmi2SetBoolean", "fmi2DoStep",
         "fmi2GetReal", "fmi2GetInteger", "fmi2GetBoolean", "fmi2SetRealInputDerivatives",
         )  # fmt: skip
CTYPES: dict[str, Any] = {
    "Real": ctypes.c_double, "Integer": ctypes.c_int, "Boolean": ctypes.c_int,
    "String": ctypes.c_char_p,
}  # fmt: skip
LOGGER = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p,
                          ctypes.c_char_p)  # fmt: skip
ALLOCATE = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_size_t, ctypes.c_size_t)
FREE = ctypes.CFUNCTYPE(None, ctypes.c_void_p)


class Callbacks(ctypes.Structure):
    """fmi2CallbackFunctions."""

    _fields_ = (
        ("logger", LOGGER), ("allocateMemory", ALLOCATE), ("freeMemory", FREE),
        ("stepFinished", ctypes.c_void_p), ("componentEnvironment", ctypes.c_void_p),
    )  # fmt: skip


class Library:
    """A shared library in which functions may be missing: they do nothing and return MISSING."""

    def __init__(self, dll: ctypes.CDLL) -> None:
        self._dll = dll

    def __getattr__(self, name: str) -> Any:
        """Return a function, the same one each time, or what else a CDLL has."""
        found = getattr(self._dll, name, None) or _absent(name)
        setattr(self, name, found)  # the next time it is at hand
        return found

    def __getitem__(self, name: str) -> Any:
        """Return a function of its own."""
        return self._dll[name] if hasattr(self._dll, name) else _absent(name)


def _absent(name: str) -> Callable[..., int]:
    def absent(*_: Any) -> int:
        return MISSING

    absent.__name__ = name
    return absent


def lacks(library: Library) -> str:
    """Return which function that every run calls a library lacks, as a sentence; "" if none."""
    dll = library._dll
    return next((f"its library has no {name}" for name in NEEDED if not hasattr(dll, name)), "")


class Host:
    """One instance of one FMU."""

    def __init__(self) -> None:
        self.messages: list[list[Any]] = []
        self._heard = self._errors = self.dropped = 0
        self._pid = os.getpid()
        self._component = ctypes.c_void_p()
        self._steered: list[Any] = []

    def load(self, library: str, proxy: str, tool: bool, memory: int) -> str:
        """Load the library; returns "" or why it does not load. `tool`: it may start processes."""
        self._tool = tool
        limit(memory)
        try:
            self._dll = Library(ctypes.CDLL(library))
        except OSError as error:
            return str(error)
        self._proxy = proxy
        return lacks(self._dll)

    def instantiate(self, name: str, guid: str, resources: str, logging: bool) -> int:
        """Make the instance; returns 0, or 3 when there is none."""
        libc = ctypes.CDLL(None)
        allocate, free = ALLOCATE(("calloc", libc)), FREE(("free", libc))
        self._kept = Callbacks(LOGGER(self._log), allocate, free, None, None)
        if self._proxy:
            ctypes.CDLL(self._proxy).addLoggerProxy(ctypes.byref(self._kept))
        make = self._dll.fmi2Instantiate
        make.restype = ctypes.c_void_p
        found = make(name.encode(), 1, guid.encode(), resources.encode(),
                     ctypes.byref(self._kept), 0, int(logging))  # fmt: skip
        self._component = ctypes.c_void_p(found)
        return 0 if found else 3

    def _log(self, _env: Any, _who: Any, status: int, category: bytes, message: bytes) -> None:
        self._heard += 1
        self._errors += self._heard > MESSAGES and status >= SEVERE
        if self._heard > MESSAGES and not (status >= SEVERE and self._errors <= ERRORS):
            self.dropped += 1
            return
        texts = [(t or b"")[:LONGEST].decode("utf-8", "replace") for t in (category, message)]
        self.messages.append([status, *texts])

    def setup(self, stop: float) -> int:
        """Call fmi2SetupExperiment."""
        real = ctypes.c_double
        return self._dll.fmi2SetupExperiment(
            self._component, 0, real(0.0), real(0.0), 1, real(stop)
        )

    def call(self, function: str) -> int:
        """Call a function that takes the instance only."""
        return self._dll[function](self._component)

    def set(self, group: str, references: list[int], values: list[Any]) -> int:
        """Set values of one type."""
        if group == "String":
            values = [v.encode() for v in values]
        return self._access("Set", group, references, (CTYPES[group] * len(values))(*values))

    def get(self, group: str, references: list[int]) -> list[Any]:
        """Return status and values of one type."""
        found = (CTYPES[group] * len(references))()
        status = self._access("Get", group, references, found)
        texts = group == "String"
        return [status, [(v or b"").decode("utf-8", "replace") if texts else v for v in found]]

    def _access(self, verb: str, group: str, references: list[int], values: Any) -> int:
        vrs = (ctypes.c_uint * len(references))(*references)
        count = ctypes.c_size_t(len(references))
        return self._dll[f"fmi2{verb}{group}"](self._component, vrs, count, values)

    def bind(self, path: str, inputs: dict[str, list[int]], outputs: dict[str, list[int]]) -> int:
        """Map the file of numbers; references by type, in the order of the vectors."""
        with open(path, "r+b") as file:
            shared = mmap.mmap(file.fileno(), 0)
        self._numbers = (ctypes.c_double * (len(shared) // 8)).from_buffer(shared)
        count = sum(map(len, inputs.values()))
        self._set = self._transfers("Set", inputs, HEAD)
        self._get = self._transfers("Get", outputs, HEAD + count)
        self._after = HEAD + count + sum(map(len, outputs.values()))
        return 0

    def attach_slopes(self, references: list[int]) -> int:
        """Set derivatives of these inputs at every step from now on."""
        count = len(references)
        self._steered = [
            ((ctypes.c_uint * count)(*references), ctypes.c_size_t(count),
             (ctypes.c_int * count)(*([1] * count)),
             ctypes.byref(self._numbers, 8 * self._after)),
        ] if references else []  # fmt: skip
        return 0

    def output_slopes(self, references: list[int]) -> list[Any]:
        """Return status and first derivatives of outputs."""
        count = len(references)
        found = (ctypes.c_double * count)()
        status = self._dll.fmi2GetRealOutputDerivatives(
            self._component, (ctypes.c_uint * count)(*references), ctypes.c_size_t(count),
            (ctypes.c_int * count)(*([1] * count)), found,
        )  # fmt: skip
        return [status, list(found)]

    def _transfers(self, verb: str, references: dict[str, list[int]], first: int) -> list[Any]:
        """Return per type: index of the call, call, integers that it uses or None, place."""
        found = []
        for group in GROUPS:
            vrs = references.get(group, [])
            if not vrs:
                continue
            narrow = None if group == "Real" else (ctypes.c_int * len(vrs))()
            values = ctypes.byref(self._numbers, 8 * first) if narrow is None else narrow
            known = ((ctypes.c_uint * len(vrs))(*vrs), ctypes.c_size_t(len(vrs)), values)
            function = self._dll[f"fmi2{verb}{group}"]
            found.append((CALLS.index(f"fmi2{verb}{group}"), function, known, narrow, first))
            first += len(vrs)
        return found

    def set_inputs(self) -> int:
        """Send the inputs; returns the first bad status."""
        for k, function, known, narrow, first in self._set:
            if narrow is not None:
                for j in range(len(narrow)):
                    narrow[j] = int(self._numbers[first + j])
            status = function(self._component, *known)
            if status > 1:
                return self._failed(k, status)
        return 0

    def get_outputs(self) -> int:
        """Fetch the outputs; returns the first bad status."""
        for k, function, known, narrow, first in self._get:
            status = function(self._component, *known)
            if status > 1:
                return self._failed(k, status)
            if narrow is not None:
                self._numbers[first : first + len(narrow)] = [float(v) for v in narrow]
        return 0

    def step(self) -> int:
        """Set inputs, step, get outputs; returns the first bad status."""
        status = self.set_inputs()
        if status:
            return status
        for known in self._steered:
            status = self._dll.fmi2SetRealInputDerivatives(self._component, *known)
            if status > 1:
                return self._failed(CALLS.index("fmi2SetRealInputDerivatives"), status)
        t, h = (ctypes.c_double(self._numbers[k]) for k in (0, 1))
        status = self._dll.fmi2DoStep(self._component, t, h, 1)
        if status > 1:
            return self._failed(CALLS.index("fmi2DoStep"), status)
        return self.get_outputs()

    def _failed(self, k: int, status: int) -> int:
        self._numbers[2] = float(k)
        return status if 0 <= status <= MISSING else 3

    def status(self, group: str, kind: int) -> list[float]:
        """Return status and value of an fmi2StatusKind."""
        value, function = CTYPES[group](), self._dll[f"fmi2Get{group}Status"]
        return [function(self._component, ctypes.c_int(kind), ctypes.byref(value)), value.value]

    def told(self) -> dict[str, Any]:
        """Return and forget the messages; how many were dropped; the working directory."""
        found, self.messages = self.messages, []
        return {"messages": found, "dropped": self.dropped, "folder": os.getcwd()}

    def alone(self) -> bool:
        """Return whether this is still the one process that was started."""
        if os.getpid() != self._pid:
            os._exit(0)  # the copy of a fork must not answer
        if self._tool or not hasattr(os, "WNOHANG"):
            return True
        try:
            os.waitpid(-1, os.WNOHANG)
        except ChildProcessError:
            return True
        return False


def limit(memory: int) -> None:
    """Bound the address space [bytes], die with the parent, adopt the FMU's grandchildren."""
    if sys.platform != "linux":
        return
    import resource

    prctl = ctypes.CDLL(None).prctl
    prctl(1, 9, 0, 0, 0)  # PR_SET_PDEATHSIG, SIGKILL
    prctl(36, 1, 0, 0, 0)  # PR_SET_CHILD_SUBREAPER
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with open("/proc/self/statm") as file:
        used = int(file.read().split()[0]) * mmap.PAGESIZE
    resource.setrlimit(resource.RLIMIT_AS, (used + memory, used + memory))


def _answer(host: Host, actions: dict[str, Callable[[], int]], read: int, write: int) -> None:
    """Answer requests until the parent closes the pipe."""
    while letter := os.read(read, 1):
        if letter == b"J":
            request = json.loads(_exactly(read, int.from_bytes(_exactly(read, 4), "little")))
            answer = getattr(host, request.pop("do"))(**request)
            alone = host.alone()
            text = json.dumps({"answer": answer, "alone": alone}).encode()
            _all(write, len(text).to_bytes(4, "little") + text)
        else:
            status = actions[letter.decode()]()
            if not host.alone():
                status = FORKED
            _all(write, bytes([status + MORE * bool(host.messages)]))


def _exactly(pipe: int, count: int) -> bytes:
    found = b""
    while len(found) < count:
        part = os.read(pipe, count - len(found))
        if not part:
            os._exit(0)
        found += part
    return found


def _all(pipe: int, text: bytes) -> None:
    while text:
        text = text[os.write(pipe, text) :]


def main() -> None:
    """Keep the pipes for the parent; what the FMU prints goes to standard error."""
    read, write = os.dup(0), os.dup(1)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.dup2(2, 1)
    host = Host()
    _all(write, READY)
    _answer(host, {"I": host.set_inputs, "O": host.get_outputs, "S": host.step}, read, write)
    os._exit(0)


if __name__ == "__main__":
    main()
