"""How a shared library is loaded, and why it is not: what it needs, what the machine has."""

from __future__ import annotations

import platform
import re
import shutil
import struct
import subprocess
from pathlib import Path
from typing import Any

from fmpy import fmi2

from .host import Library

LDD_SECONDS = 10.0
GLIBC = re.compile(rb"\0GLIBC_(\d+(?:\.\d+)+)(?=\0)")
ELF64 = b"\x7fELF\x02\x01"  # little-endian, as all platforms of FMI are
ELF_HEADER = 64  # bytes
# What ldd prints ("libx.so.1 => not found") and what dlopen says ("libx.so.1: cannot open …").
MISSING = (re.compile(r"^\s*(\S+) => not found", re.MULTILINE),
           re.compile(r"(\S+): cannot open shared object file"))  # fmt: skip


class FMU2Part(fmi2.FMU2Slave):  # type: ignore[misc]
    """As FMU2Slave, which insists on all functions: here one that is missing matters when called.

    fmpy tells the version of FMI by the first letters of the class.
    """

    dll: Any

    def _loadFunctions(self) -> None:
        self.dll = Library(self.dll)
        super()._loadFunctions()


def _version(text: str) -> tuple[int, ...]:
    return tuple(int(part) for part in text.split("."))


def glibc_needed(library: Path) -> str | None:
    """Return the newest glibc version that a library asks for; None if it asks for none."""
    found = {match.decode() for match in GLIBC.findall(library.read_bytes())}
    return max(found, key=_version, default=None)


def glibc_present() -> str | None:
    """Return the glibc version of this machine; None where there is another C library."""
    name, version = platform.libc_ver()
    return version if name == "glibc" else None


def missing_libraries(library: Path, message: str) -> list[str]:
    """Return the shared libraries that are not found, by `ldd` and the loader's `message`."""
    text = message
    if shutil.which("ldd"):
        done = subprocess.run(
            ["ldd", library], capture_output=True, text=True, check=False, timeout=LDD_SECONDS
        )
        text += "\n" + done.stdout
    names = (Path(name).name for pattern in MISSING for name in pattern.findall(text))
    return sorted(set(names) - {library.name})


def missing_bytes(library: Path) -> int:
    """Return how many bytes an ELF library of 64 bits lacks at its end; 0 for all other files.

    The loader maps what is not there without a word, and the first look at it ends the process.
    """
    data = library.read_bytes()
    if not data.startswith(ELF64) or len(data) < ELF_HEADER:
        return 0
    (start,) = struct.unpack_from("<Q", data, 32)
    size, count = struct.unpack_from("<HH", data, 54)
    heads = [start + k * size for k in range(count)]
    if heads and heads[-1] + size > len(data):
        return heads[-1] + size - len(data)
    segments = [struct.unpack_from("<8xQ16xQ", data, head) for head in heads]
    return max([0, *(offset + length - len(data) for offset, length in segments)])


def explain(library: Path, message: str) -> str:
    """Return the cause of a failed load as a sentence; the loader's own message if unknown."""
    missing = missing_libraries(library, message)
    if missing:
        return f"{', '.join(missing)} not found on this machine"
    needed, present = glibc_needed(library), glibc_present()
    if needed and present and _version(needed) > _version(present):
        return f"it needs glibc {needed}, this machine has {present}"
    return message
