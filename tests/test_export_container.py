"""`dct-harness export-container`: one FMU that gives what the system gives, or the reason not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from closed_loop_runs import FMUS, SYSTEMS
from dct_harness import results
from harness_fixture.lag_fmu import harness, write_fmu, write_system

STOP = "1.3"  # s; at 1.32 s a rounding of the container's time moves a decision by one step
NEAR = 1e-9  # of a signal's largest value; measured 1e-12: the container adds up its time
ROUNDING = 1e-2  # J: the residual of the energy balance is the rounding of thousands of joules
ONE = """[system]
name = "one"
step = 0.001
stop = 1.3
scenario = "{}"
[components.all]
fmu = "{}"
"""


def packed(folder: Path, system: Path) -> results.Results:
    """Return the rows of a system packed as one FMU."""
    fmu = folder / "packed.fmu"
    done = harness("export-container", system, "--fmu-dir", FMUS, "--out", fmu, folder=folder)
    assert (done.returncode, done.stderr) == (0, "")
    scenario = next(line for line in system.read_text().splitlines() if line.startswith("scenario"))
    (folder / "one.toml").write_text(
        ONE.format(system.parent / scenario.split('"')[1], fmu.name), encoding="utf-8"
    )
    done = harness("run", folder / "one.toml", "--fmu-dir", folder, "-q", "--out", folder / "a",
                   folder=folder)  # fmt: skip
    assert done.returncode == 0, done.stderr
    return results.load(folder / "a")


@pytest.mark.parametrize("case", ["paper_case1", "torque_tracking_case1"])
def test_the_container_gives_the_rows_of_the_system(tmp_path: Path, case: str) -> None:
    one = packed(tmp_path, SYSTEMS / f"{case}.toml")
    done = harness("run", SYSTEMS / f"{case}.toml", "--fmu-dir", FMUS, "--stop", STOP, "-q",
                   "--out", tmp_path / "b", folder=tmp_path)  # fmt: skip
    assert done.returncode in (0, 1), done.stderr
    wanted = results.load(tmp_path / "b")
    names = [n for n in wanted.signals if n.startswith(("plant.", "observer.", "control."))]
    assert len(names) > 60
    for name in names:
        size = max(np.abs(wanted[name]).max(), ROUNDING)
        assert np.abs(one[f"all.{name}"] - wanted[name]).max() <= NEAR * size, name


@pytest.mark.parametrize(("verb", "name", "suffix"), [
    ("export-ssp", "loop.fmu", ".ssp"), ("export-ssp", "folder.ssp", ".ssp"),
    ("export-container", "loop.ssp", ".fmu"),
])  # fmt: skip
def test_a_name_that_run_would_not_take_is_refused(
    tmp_path: Path, lag_dir: Path, verb: str, name: str, suffix: str
) -> None:
    (tmp_path / "folder.ssp").mkdir()
    out = tmp_path / name
    done = harness(verb, write_system(tmp_path), "--fmu-dir", lag_dir, "--out", out,
                   folder=tmp_path)  # fmt: skip
    assert done.returncode == 2
    assert f"argument --out: '{out}' is not the name of an {suffix} file\n" in done.stderr


WIRE = '[components.b]\nfmu = "Lag.fmu"\n[[connections]]\nfrom = "plant.x"\nto = "b.u"\n'


@pytest.mark.parametrize(("more", "said"), [
    (WIRE + "factor = 2\n", "'plant.x' to 'b.u' converts a value; a container only connects"),
    ("substeps = 2\n", "'plant' has substeps; a container has one step"),
])  # fmt: skip
def test_what_a_container_cannot_do_is_refused(
    tmp_path: Path, lag_library: Path, more: str, said: str
) -> None:
    write_fmu(tmp_path / "Lag.fmu", lag_library)
    system = write_system(tmp_path)
    system.write_text(system.read_text() + more)
    done = harness("export-container", system, "--fmu-dir", tmp_path, "--out",
                   tmp_path / "out.fmu", folder=tmp_path)  # fmt: skip
    assert done.returncode == 2, done.stderr
    assert said in done.stderr
    assert not (tmp_path / "out.fmu").exists()


def test_a_parameter_that_changes_is_refused(tmp_path: Path) -> None:
    system = SYSTEMS / "friction_fade_case1.toml"
    done = harness("export-container", system, "--fmu-dir", FMUS, "--out", tmp_path / "out.fmu",
                   folder=tmp_path)  # fmt: skip
    assert done.returncode == 2
    assert "the scenario changes the parameter 'plant.clutch1.kineticFriction'" in done.stderr
