"""Columns `plant.*` of a scenario: what was measured of a plant that does not run."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from dct_harness import results
from harness_fixture.lag_fmu import LAG, run, variable, write_fmu

RISE = "plant.driveShaft.torque"  # 5 t
ROWS = f"time,u,{RISE},plant.clutch1.state,plant.driveshaft.torque\n0,2,0,2,7\n2,2,10,3,7\n"
ROUNDING = 1e-12
EVERY_ENGINE = pytest.mark.parametrize("engine", ["fmpy", "native"])


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, lag_library: Path) -> Path:
    """Folder with a lag whose output is called driveShaft.torque."""
    path = tmp_path_factory.mktemp("beside")
    told = variable("driveShaft.torque", 1, "output")
    write_fmu(path / "Lag.fmu", lag_library, (LAG[0], told, *LAG[2:]))
    return path


def write(place: Path, component: str) -> Path:
    """Write a system with the lag as one component, and a limit on its error; returns its path."""
    (place / "s.csv").write_text(ROWS)
    system = place / "s.toml"
    system.write_text(
        '[system]\nname = "drive"\nstep = 0.5\nstop = 2.0\nscenario = "s.csv"\n'
        f'[components.{component}]\nfmu = "Lag.fmu"\n'
        '[[kpis]]\nkpi = "estimation.percentOfRms"\nsignal = "driveShaft.torque"\n'
        'estimate = "observer"\nmax = 1e3\n'
    )
    return system


@EVERY_ENGINE
def test_an_observer_is_judged_by_what_was_measured(
    tmp_path: Path, folder: Path, engine: str
) -> None:
    done = run(write(tmp_path, "observer"), folder, "--engine", engine)
    assert done.returncode == 0, done.stderr
    found = results.load(tmp_path / "out")
    truth, estimate = found[RISE], found["observer.driveShaft.torque"]
    assert np.array_equal(truth, 5 * found.time)
    assert found["plant.clutch1.state"].tolist() == [2, 2, 2, 2, 3]
    units = {name: found.run["signals"][name]["unit"] for name in (RISE, "plant.clutch1.state")}
    assert units == {RISE: "N.m", "plant.clutch1.state": ""}
    kpis = json.loads((tmp_path / "out/kpis.json").read_text())
    percent = 100 * np.sqrt(np.mean((estimate - truth) ** 2) / np.mean(truth**2))
    assert kpis["limits"][0]["value"] == pytest.approx(percent, rel=ROUNDING)
    said = "no plant shows 'plant.driveshaft.torque'. Did you mean 'plant.driveShaft.torque'?"
    assert [said in message["message"] for message in found.run["log"]] == [True]


@EVERY_ENGINE
def test_a_run_that_fails_keeps_them_up_to_then(tmp_path: Path, folder: Path, engine: str) -> None:
    system, failing = write(tmp_path, "observer"), ("--set", "observer.failAt=0.8")
    assert run(system, folder, *failing, "--engine", engine).returncode == 4
    found = results.load(tmp_path / "out")
    assert found[RISE].tolist() == [0, 2.5, 5]


def test_beside_a_plant_they_are_not_read(tmp_path: Path, folder: Path) -> None:
    assert run(write(tmp_path, "plant"), folder).returncode == 1  # the limit knows no observer
    found = results.load(tmp_path / "out")
    assert np.array_equal(found[RISE], found["plant.driveShaft.torque"])
    assert not np.allclose(found[RISE], 5 * found.time)
    assert "plant.clutch1.state" not in found
