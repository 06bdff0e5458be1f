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
REQUEST = """time,engine.torque,clutch1.torqueRequest,engine.speed_start
0,40,0,90
1,60,60,90
2,60,60,90
"""


def _replay(
    inputs: Path, out: Path, *options: str, models: tuple[str, ...] = ("DctPlant",)
) -> subprocess.CompletedProcess:
    fmus = [fmu(model) for model in models]
    command = ["cargo", "fmu", "replay", *fmus, "--inputs", inputs, "--step", str(STEP),
               "--out", out, *options]  # fmt: skip
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)


def _rows(out: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(out.read_text(encoding="utf-8").splitlines()))


def test_it_writes_what_fmpy_gets(tmp_path: Path) -> None:
    stimuli, out = tmp_path / "in.csv", tmp_path / "out.csv"
    stimuli.write_text(STIMULI, encoding="utf-8")
    done = _replay(stimuli, out)
    assert done.returncode == 0, done.stderr
    assert f"warning: {stimuli}: column 'unknown' is passed over: no input or" in done.stderr
    rows = _rows(out)
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


def test_several_fmus_are_a_closed_loop(tmp_path: Path) -> None:
    stimuli, out = tmp_path / "in.csv", tmp_path / "out.csv"
    stimuli.write_text(REQUEST, encoding="utf-8")
    models = ("DctPlant", "DctObserver", "DctClutchControl")
    done = _replay(stimuli, out, "--every", "10", models=models)
    assert done.returncode == 0, done.stderr
    rows = _rows(out)
    assert [float(row["time"]) for row in rows] == [index * 10 * STEP for index in range(21)]
    late = {name: float(value) for name, value in rows[15].items()}
    assert late["DctPlant.clutch1.state"] == 2  # it slips
    # The observer finds the friction 0.26 though it believed in 0.4: torque and request are equal.
    assert abs(late["DctObserver.clutch1.friction"] - 0.26) < 0.001
    assert abs(late["DctPlant.clutch1.torque"] - 60) < 0.1
    assert abs(late["DctObserver.clutch1.torque"] - late["DctPlant.clutch1.torque"]) < 0.1


def test_a_refusal_names_fmu_time_variable_and_value(tmp_path: Path) -> None:
    stimuli = tmp_path / "in.csv"
    stimuli.write_text("time,clutch1.position\n0,0\n0.5,0\n1,-1\n", encoding="utf-8")
    done = _replay(stimuli, tmp_path / "out.csv")
    assert done.returncode == 1
    said = "DctPlant at t = 0.51 s: fmi2SetReal returned fmi2Discard: fmi2SetReal: clutch1.position"
    assert said in done.stderr


def test_a_table_that_goes_back_in_time_is_refused(tmp_path: Path) -> None:
    stimuli = tmp_path / "in.csv"
    stimuli.write_text("time,engine.torque\n1,0\n0,0\n", encoding="utf-8")
    done = _replay(stimuli, tmp_path / "out.csv")
    assert done.returncode == 1
    assert "in.csv, line 3: the time 0 s does not increase" in done.stderr
