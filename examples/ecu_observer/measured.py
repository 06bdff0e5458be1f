"""Write what a control unit would measure in a run of the harness as CSV, for `replay`.

    python examples/ecu_observer/measured.py target/paper_case1 > target/measured.csv

Speeds are those of the plant at the end of a step; what is scripted acted over the step before it.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

SPEEDS = ("engine.speed", "clutch1.speed", "clutch2.speed", "wheel.speed")
SCRIPTED = ("engine.torque", "road.grade", "brake.torque", "shaft1.gear", "shaft2.gear")
MOVED = tuple(f"clutch{k}.{how}" for k in (1, 2) for how in ("position", "pressure"))


def main(folder: Path) -> None:
    """Write the measurements of `folder/results.csv` to standard output, SI units."""
    with (folder / "results.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    scripted = [n for n in (*SCRIPTED, *MOVED) if f"scenario.{n}" in rows[0]]
    out = csv.writer(sys.stdout, lineterminator="\n")
    out.writerow(["time", *SPEEDS, *scripted])
    for before, row in zip([rows[0], *rows], rows, strict=False):
        speeds = [row[f"plant.{name}"] for name in SPEEDS]
        out.writerow([row["time"], *speeds, *(before[f"scenario.{n}"] for n in scripted)])


if __name__ == "__main__":
    main(Path(sys.argv[1]))
