"""FMUs that stay open from one run of a process to the next, each for one component at a time.

Unpacking, reading and loading three FMUs takes longer than a run of 30 s by the compiled master.
Only FMUs that this project built stay open, and only without resources: their libraries need no
file once they are loaded, and an instance knows nothing of the one before.
"""

from __future__ import annotations

import hashlib
import shutil
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

Opened = tuple[Any, Any]  # the model description, the loaded library without an instance


class Kept:
    """Idle FMUs by the content of their files."""

    def __init__(self) -> None:
        self._idle: dict[str, list[Opened]] = {}
        self._digests: dict[Path, tuple[tuple[int, int, int], str]] = {}
        self._folder: TemporaryDirectory[str] | None = None
        self.compiled: tuple[Any, Any] = (None, None)  # what the compiled master has open, of which

    def digest(self, path: Path) -> str:
        """Return the SHA-256 of a file, read again when it has changed."""
        told = path.stat()
        stamp = (told.st_mtime_ns, told.st_size, told.st_ino)
        known = self._digests.get(path)
        if known is None or known[0] != stamp:
            known = stamp, hashlib.sha256(path.read_bytes()).hexdigest()
            self._digests[path] = known
        return known[1]

    def has(self, path: Path) -> bool:
        """Return whether an FMU of this file is idle."""
        return path.is_file() and bool(self._idle.get(self.digest(path)))

    def take(self, path: Path) -> tuple[str, Opened | None]:
        """Return the digest of a file, if there is one, and an idle FMU of it, if there is one."""
        digest = self.digest(path) if path.is_file() else ""
        idle = self._idle.get(digest)
        return digest, idle.pop() if idle else None

    def give(self, digest: str, path: Path, opened: Opened) -> bool:
        """Take back an FMU without an instance; returns whether its file is still the same."""
        same = digest != "" and path.is_file() and digest == self.digest(path)
        if same:
            self._idle.setdefault(digest, []).append(opened)
        return same

    @property
    def folder(self) -> Path:
        """A temporary folder for as long as the process lasts."""
        if self._folder is None or not Path(self._folder.name).is_dir():
            self._folder = TemporaryDirectory(prefix="dct-harness-")
        return Path(self._folder.name)

    def remove_folder(self) -> None:
        """Remove the folder, for a process that ends at once."""
        if self._folder is not None:
            shutil.rmtree(self._folder.name, ignore_errors=True)
