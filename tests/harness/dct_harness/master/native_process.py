"""The process that a native loop of foreign FMUs runs in: a plan in, rows out, through files.

It imports little, for it is started anew for every run.
"""

from __future__ import annotations

import importlib
import json
import os
import signal
import sys
from pathlib import Path

import numpy as np
from numpy.lib.format import open_memmap

from ..fmu.host import limit

PLAN, INPUT, OUTPUT = "plan.json", "input.npz", "output.npz"  # what the two processes exchange
ROWS = "rows.npy"  # what this process makes, while it does
STEPS, END = "steps", "end"  # files: how far this process is, and that it is to end
DONE = "done"  # file: no FMU will be called any more


def _told(folder: Path, steps: int) -> bool:
    """Tell the other process how far this one is; returns whether it is to end."""
    (folder / STEPS).write_text(str(steps), encoding="utf-8")
    return (folder / END).exists()


def main(folder: Path, memory: int) -> None:
    """Make the rows of a plan in this process, after limiting its memory [MiB]."""
    native = importlib.import_module("cosim_native")
    limit(memory * (1 << 20))
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a terminal sends it to both processes
    plan = (folder / PLAN).read_text("utf-8")
    rows = np.asarray(open_memmap(folder / ROWS, "r+"))
    with np.load(folder / INPUT) as given:
        work = ([plan], given["times"], np.ascontiguousarray(given["script"]))
    fmus = native.Fmus(folder)
    _told(folder, 0)
    ((_, _, error, log),) = native.run(
        *work, out=[rows], fmus=fmus, watch=lambda steps: _told(folder, steps)
    )
    (folder / DONE).touch()
    np.savez(folder / OUTPUT, error=np.array(error or ("", "")), log=np.array(json.dumps(log)))
    os._exit(0)  # nothing of an FMU runs again


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]))
