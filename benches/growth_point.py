"""One point of `growth.py`, in a process of its own: its memory is this work's alone.

`python growth_point.py WORK`: WORK is JSON with `plans`, `times`, `script` (files of NumPy),
`threads` and `rounds`. Prints the least CPU time and time of a call [s] and how much memory [B]
the process needed at most, above what it had before.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

import cosim_native
import numpy as np


def _status(key: str) -> int:
    """Return a line of this process's status [B]."""
    text = Path("/proc/self/status").read_text(encoding="utf-8")
    (line,) = (line for line in text.splitlines() if line.startswith(f"{key}:"))
    return 1024 * int(line.split()[1])


def _call(work: dict[str, Any], plans: list[str], times: np.ndarray, script: np.ndarray) -> None:
    for _, rows, error, _ in cosim_native.run(plans, times, script, work["threads"]):
        if error or len(rows) != len(times):
            raise SystemExit(f"{len(rows)} rows: {error}")


def main(work: dict[str, Any]) -> None:
    """Call once or several times, and print."""
    times, script = np.load(work["times"]), np.load(work["script"])
    plan = json.dumps(work["plan"])
    plans = [plan] * work["runs"]
    Path("/proc/self/clear_refs").write_text("5", encoding="utf-8")  # forgets the peak so far
    before, spent = _status("VmRSS"), []
    for _ in range(work["rounds"]):
        begun = time.process_time(), time.perf_counter()
        _call(work, plans, times, script)
        ended = time.process_time(), time.perf_counter()
        spent.append([end - begin for begin, end in zip(begun, ended, strict=True)])
    most = _status("VmHWM")
    cpu, wall = np.min(spent, axis=0)
    print(json.dumps({"cpu": cpu, "wall": wall, "memory": most - before}))


if __name__ == "__main__":
    main(json.loads(Path(sys.argv[1]).read_text(encoding="utf-8")))
