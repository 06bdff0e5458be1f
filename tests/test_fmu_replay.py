"""`cargo fmu replay`: the outputs over a table of inputs are those that fmpy gets, bit for bit."""

from __future__ import annotations

import csv
import subprocess
from pathlib import Path

from fmu_instance import Instance
from importer_cases import ROOT, fmu

STEP, STEPS = 0.01, 200
STIMULI = """time,engine.torque,shaft1.gear,clutch1.position,engine.speed_start,unknown
0,60,1,0.004,90,1
2,60,1,0.004,90,1
"""


def _replay(stimuli: Path, out: Path) -> subprocess.CompletedProcess:
    command = [
        "cargo",
        "fmu",
        "replay",
        fmu("DctPlant"),
        stimuli,
        "--step",
        str(STEP),
        "--out",
        out,
    ]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)


def test_it_writes_what_fmpy_gets(tmp_path: Path) -> None:
    stimuli, out = tmp_path / "in.csv", tmp_path / "out.csv"
    stimuli.write_text(STIMULI, encoding="utf-8")
    done = _replay(stimuli, out)
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader(out.read_text(encoding="utf-8").splitlines()))
    assert len(rows) == STEPS + 1
    with Instance(fmu("DctPlant")) as plant:
        for name, value in (("engine.torque", 60.0), ("shaft1.gear", 1),
                            ("clutch1.position", 0.004), ("engine.speed_start", 90.0)):  # fmt: skip
            plant.set(name, value)
        plant.start()
        for index in range(STEPS):
            plant.step(index * STEP, STEP)
        wanted = plant.outputs()
    last = rows[-1]
    assert wanted["vehicle.speed"] > 0.5  # it moves
    assert {name: float(last[name]) for name in ("vehicle.speed", "clutch1.torque")} == {
        name: wanted[name] for name in ("vehicle.speed", "clutch1.torque")}  # fmt: skip


def test_a_table_that_goes_back_in_time_is_refused(tmp_path: Path) -> None:
    stimuli = tmp_path / "in.csv"
    stimuli.write_text("time,engine.torque\n1,0\n0,0\n", encoding="utf-8")
    done = _replay(stimuli, tmp_path / "out.csv")
    assert done.returncode == 1
    assert "in.csv, line 3: the time does not increase" in done.stderr
