"""`--plant F.fmu` puts another plant into a system without touching its file."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from dct_harness import results
from harness_fixture.lag_fmu import LAG, harness, run, variable, write_fmu, write_system

RATE = 2.0  # 1/s, of the supplier's lag
ROUNDING = 1e-12  # a thousand exact steps, each rounded once


def test_a_suppliers_plant_takes_the_place_of_ours(
    tmp_path: Path, lag_dir: Path, lag_library: Path
) -> None:
    """The supplier's lag has one output more; nothing else of the system changes."""
    extra = variable("m", 1, "output", None, "Integer")
    supplier = write_fmu(tmp_path / "Supplier.fmu", lag_library, (*LAG, extra))
    options = ("--plant", supplier, "--set", f"plant.tau={1 / RATE}")
    done = run(write_system(tmp_path), lag_dir, *options)
    assert done.returncode == 0, done.stderr
    found = results.load(tmp_path / "out")
    assert found.run["fmus"]["plant"]["path"] == str(supplier)
    assert np.max(np.abs(found["plant.x"] - 2 * (1 - np.exp(-RATE * found.time)))) < ROUNDING
    assert "plant.m" in found


def test_the_driveline_from_elsewhere_gives_the_same_closed_loop(
    repo_root: Path, tmp_path: Path
) -> None:
    ours, theirs = repo_root / "target/fmu", tmp_path / "elsewhere"
    text = (repo_root / "examples/closed_loop/paper_case1.toml").read_text(encoding="utf-8")
    text = text.replace("stop = 30.0", "stop = 0.5").replace("DctPlant.fmu", "Missing.fmu")
    text = text.partition("[[kpis]]")[0]  # limits are for the whole scenario
    text = text.replace("scenarios/", f"{repo_root}/examples/closed_loop/scenarios/")
    (tmp_path / "s.toml").write_text(text, encoding="utf-8")
    theirs.mkdir()
    plant = shutil.copy(ours / "DctPlant.fmu", theirs / "Plant from a supplier.fmu")
    rows = []
    for fmu in (ours / "DctPlant.fmu", plant):
        done = run(tmp_path / "s.toml", ours, "--plant", fmu)
        assert done.returncode == 0, done.stderr
        rows.append((tmp_path / "out/results.csv").read_bytes())
    assert rows[0] == rows[1]


def test_a_plant_that_lacks_a_signal_is_refused_with_its_name(
    repo_root: Path, tmp_path: Path, lag_library: Path
) -> None:
    supplier = write_fmu(tmp_path / "Supplier.fmu", lag_library,
                         (variable("engine.torque", 0, "input", "0"),
                          variable("engine.sped", 1, "output")))  # fmt: skip
    system = tmp_path / "s.toml"
    text = (repo_root / "examples/closed_loop/paper_case1.toml").read_text(encoding="utf-8")
    text = text.replace("scenarios/", f"{repo_root}/examples/closed_loop/scenarios/")
    system.write_text(text.replace('parameters = { "engine.speed_start" = 90.0 }', ""))
    done = run(system, repo_root / "target/fmu", "--plant", supplier)
    assert done.returncode == 2
    assert "'observer.engine.speed' has no source" in done.stderr


def test_an_observer_in_the_place_of_the_plant_is_doubted(repo_root: Path, tmp_path: Path) -> None:
    words = [
        "run",
        str(repo_root / "examples/closed_loop/paper_case1.toml"),
        "--fmu-dir",
        str(repo_root / "target/fmu"),
        "--plant",
        str(repo_root / "target/fmu/DctObserver.fmu"),
    ]
    done = harness(*words, folder=tmp_path)
    assert done.returncode == 2
    assert "'plant.engine.speed' has no source" in done.stderr
    assert "`dct-harness check FMU --against plant` tells if this is one" in done.stderr


@pytest.mark.parametrize(("name", "said"), [
    ("plant", "none.fmu: cannot read the FMU: No such file or directory"),
    ("engine", "--plant: "),
])  # fmt: skip
def test_what_cannot_be_swapped_is_said(
    tmp_path: Path, lag_dir: Path, name: str, said: str
) -> None:
    system = write_system(tmp_path)
    system.write_text(system.read_text().replace("components.plant", f"components.{name}"))
    done = run(system, lag_dir, "--plant", "none.fmu")
    assert done.returncode == 2
    assert said in done.stderr
