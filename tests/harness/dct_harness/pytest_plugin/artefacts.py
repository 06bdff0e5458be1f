"""What a failing test leaves behind: result directories and a report about them."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .loops import Loop


class Artefacts:
    """Runs of one test, copied to a folder of the test's name when it fails."""

    def __init__(self, root: Path, nodeid: str) -> None:
        self.folder = root / re.sub(r"[^\w.-]+", "_", nodeid).strip("_")
        self._loops: list[Loop] = []
        self._references: list[Path] = []
        shutil.rmtree(self.folder, ignore_errors=True)

    def add(self, loop: Loop) -> None:
        """Take note of a run."""
        if all(loop.path != known.path for known in self._loops):
            self._loops.append(loop)

    def compared(self, run: Any, reference: Any) -> None:
        """Take note of a comparison that failed, to overlay both in the report."""
        from .loops import Loop

        if isinstance(run, Loop):
            self.add(run)
        path = reference.path if isinstance(reference, Loop) else reference
        if isinstance(path, (str, Path)) and Path(path).is_dir():
            self._references.append(Path(path))

    def save(self) -> None:
        """Copy the runs and write the report; says where."""
        if not self._loops:
            return
        from .. import report
        from ..report import earlier, runs

        copies = []
        for loop in self._loops:
            copies.append(self.folder / loop.path.name)
            shutil.copytree(loop.path, copies[-1])
        views = runs.load(copies)
        named = [p for p in self._references if runs.load([p])[0].name in {v.name for v in views}]
        if named:
            views = earlier.beside(views, named)
        page = report.write_views(views, self.folder, self.folder.name)
        print(f"results and report of this failure: {page}")
