"""The files of a sweep by their content, and the folder tree that a worker makes of them.

The tree has the files as they lie to each other here, so that a system file finds its scenario.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from .study import Words

BLOBS = "content"


@dataclass(frozen=True)
class Bundle:
    """`top`: folder above all files; `digests`: path below it -> SHA-256 of the content."""

    top: Path
    digests: dict[str, str]

    @classmethod
    def of(cls, files: Iterable[Path]) -> Bundle:
        """Return the bundle of files that are there."""
        listed = [path.resolve() for path in files]
        top = Path(os.path.commonpath([path.parent for path in listed]))
        digests = ((p, hashlib.sha256(p.read_bytes()).hexdigest()) for p in listed)
        return cls(top, {path.relative_to(top).as_posix(): digest for path, digest in digests})

    @property
    def digest(self) -> str:
        """SHA-256 of names and contents."""
        lines = "".join(f"{d} {name}\n" for name, d in sorted(self.digests.items()))
        return hashlib.sha256(lines.encode()).hexdigest()

    def blobs(self) -> dict[str, bytes]:
        """Return content by its SHA-256, each once."""
        return {d: (self.top / name).read_bytes() for name, d in self.digests.items()}

    def unpack(self, folder: Path, blobs: dict[str, bytes]) -> Path:
        """Return the tree in a folder, made when it is not there; equal contents lie there once."""
        root = folder / self.digest[:16]
        if root.is_dir():
            return root
        part = Path(tempfile.mkdtemp(prefix=root.name, dir=folder))
        for name, digest in self.digests.items():
            (part / name).parent.mkdir(parents=True, exist_ok=True)
            os.link(_content(folder / BLOBS / digest, blobs[digest]), part / name)
        try:
            part.rename(root)
        except OSError:  # another thread was faster
            shutil.rmtree(part)
        return root

    def moved(self, words: Words, root: Path) -> Words:
        """Return words whose files and folders are those below `root`."""
        return tuple(self._moved(word, root) for word in words)

    def _moved(self, word: str | Path, root: Path) -> str | Path:
        if not isinstance(word, Path):
            return word
        place = word.resolve()
        return root / place.relative_to(self.top) if place.is_relative_to(self.top) else word


def _content(path: Path, content: bytes) -> Path:
    """Return a file of this content, written when it is not there."""
    if not path.is_file():
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as part:
            part.write(content)
        os.replace(part.name, path)
    return path
