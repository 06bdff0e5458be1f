"""FMUs of this project that are older than the sources beside them: their figures are of before.

`cargo fmu build` leaves in `target/fmu` a record of what its FMUs were built from. Elsewhere an FMU
is what it is: nothing is said of it.
"""

from __future__ import annotations

import json
import os
import zlib
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path

from ..errors import HarnessError
from .archive import described
from .ports import is_ours

RECORD = "sources.json"
FOLDER = Path("target/fmu")  # of a checkout
Names = tuple[str, ...]
CHECKOUT = "fmu-build/dct/sources.rs"  # who has it can build FMUs, and writes the record


def remark(paths: Iterable[Path]) -> str:
    """Return a sentence on FMUs of a checkout that are not what it would build now; "" if none."""
    now = cache(checksum)  # until this returns
    names = [f"{path}" for path in dict.fromkeys(paths) if _is_outdated(path, now)]
    if not names:
        return ""
    return (f"{', '.join(names)}: not built from the sources as they are now, the figures may be "
            "of before; `cargo fmu build` builds anew")  # fmt: skip


def _is_outdated(path: Path, now: Callable[[Path, Names, Names], int]) -> bool:
    folder = Path(os.path.abspath(path)).parent
    root = folder.parent.parent
    if not (folder == root / FOLDER and (root / CHECKOUT).is_file() and _is_ours(path)):
        return False
    try:
        told = json.loads((folder / RECORD).read_text(encoding="utf-8"))
        sources = now(root, tuple(told["sources"]), tuple(told["apart"]))
        built = told["fmus"][path.name]
    except (OSError, ValueError, KeyError, TypeError):
        return True
    return bool(built != {"fmu": zlib.crc32(path.read_bytes()), "sources": sources})


def _is_ours(path: Path) -> bool:
    try:
        return is_ours(described(path))
    except (HarnessError, OSError):
        return False  # who loads it says what is wrong


def checksum(root: Path, sources: Names, apart: Names) -> int:
    """Return CRC-32 of names and contents of files, as `fmu_build::sources::checksum`."""
    names = sorted(name for source in sources for name in _files(root, source, apart))
    crc = 0
    for name in names:
        crc = zlib.crc32(name.encode() + b"\0", crc)
        crc = zlib.crc32((root / name).read_bytes(), crc)
    return crc


def _files(root: Path, source: str, apart: Names) -> Iterator[str]:
    """Yield the files of a source, by their names from the root on."""
    if not (root / source).is_dir():
        yield source
        return
    for folder, below, files in os.walk(root / source, followlinks=True):
        below[:] = [name for name in below if name not in apart and not name.startswith(".")]
        inside = Path(folder).relative_to(root).as_posix()
        yield from (f"{inside}/{name}" for name in files if not name.startswith("."))
