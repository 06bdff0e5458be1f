"""Both engines over everything a loop can ask for: same bits, same log, same words of a failure."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dct_harness import results
from dct_harness.errors import instant
from dct_harness.results import Results
from harness_fixture.lag_fmu import LAG, VARIES, run, variable, write_fmu, write_system

ENGINES = ("fmpy", "native")
CAN = f'{VARIES} canInterpolateInputs="true"'
TELLS = f'{CAN} maxOutputDerivativeOrder="1"'
STARTS = (("reach", 6, "1e9"), ("most", 7, "1e9"), ("mute", 8, "0"), ("ends", 13, "1e9"))
MORE = tuple(variable(name, k, "parameter", start) for name, k, start in STARTS)
STEPS = "time,u\n0,0\n0.25,1.3\n0.4,-0.7\n10,20\n"
TWO = """[system]
name = "two"
step = 0.03
stop = 1.0
interpolate = true
coupling = "{}"
scenario = "s.csv"
[components.first]
fmu = "Lag.fmu"
[components.second]
fmu = "Lag.fmu"
substeps = 3
parameters = {{ x = 1.0, reach = 0.004 }}
[[connections]]
from = "second.x"
to = "first.u"
factor = 0.7
offset = 0.1
[[connections]]
from = "first.x"
to = "second.u"
"""


def same(system: Path, fmus: Path, *options: str | Path) -> tuple[int, str, Results]:
    """Run with both engines; return exit code, what was told and results that they agree on."""
    found = []
    for engine in ENGINES:
        done = run(system, fmus, "-q", "--engine", engine, *options)
        out = system.parent / "out"
        assert done.returncode in (0, 4), done.stderr
        found.append((done.returncode, done.stderr, results.load(out)))
        out.rename(system.parent / engine)
    (code, told, ours), (their_code, their_told, theirs) = found
    assert (their_code, their_told) == (code, told)
    assert list(theirs.signals) == list(ours.signals)
    for name, signal in ours.signals.items():
        assert np.array_equal(signal.view(np.int64), theirs[name].view(np.int64)), name
    kept = ("status", "error", "log", "events", "wiring", "parameters", "signals", "coupling")
    assert {k: theirs.run[k] for k in kept} == {k: ours.run[k] for k in kept}
    return code, told, ours


@pytest.fixture(scope="module")
def lags(tmp_path_factory: pytest.TempPathFactory, lag_library: Path) -> dict[str, Path]:
    """Folders with a lag that discards steps, by what it can."""
    found = {}
    for can in ("", VARIES, CAN, TELLS):
        found[can] = tmp_path_factory.mktemp("lag")
        write_fmu(found[can] / "Lag.fmu", lag_library, (*LAG, *MORE), can=can)
    return found


@pytest.mark.parametrize("isolate", ["none", "all"])
@pytest.mark.parametrize("options", [
    (), ("plant.reach=0.04",), ("plant.most=0.03",), ("plant.most=0.011", "plant.reach=0.007"),
])  # fmt: skip
def test_slopes_and_divided_steps(
    tmp_path: Path, lags: dict[str, Path], isolate: str, options: tuple[str, ...]
) -> None:
    system = write_system(tmp_path, scenario=STEPS)
    system.write_text(system.read_text() + "substeps = 2\n")
    given = [word for option in options for word in ("--set", option)]
    code, _, loop = same(system, lags[CAN], "--step", "0.1", "--interpolate", "--isolate", isolate,
                         *given)  # fmt: skip
    assert code == 0
    assert len(loop.run["log"]) == bool(options)
    assert np.ptp(loop["plant.x"]) > 0.1


@pytest.mark.parametrize("can", [VARIES, CAN, TELLS])
@pytest.mark.parametrize("coupling", ["gauss-seidel", "jacobi"])
def test_slopes_between_fmus(
    tmp_path: Path, lags: dict[str, Path], coupling: str, can: str
) -> None:
    (tmp_path / "s.toml").write_text(TWO.format(coupling))
    (tmp_path / "s.csv").write_text("time,none\n0,0\n")
    code, _, loop = same(tmp_path / "s.toml", lags[can], "--isolate", "none")
    assert code == 0
    assert min(np.ptp(loop[f"{name}.x"]) for name in ("first", "second")) > 0.1


@pytest.mark.parametrize("coupling", ["gauss-seidel", "jacobi"])
@pytest.mark.parametrize("can", [VARIES, TELLS])
@pytest.mark.parametrize("ends", [("first",), ("second",), ("first", "second")])
def test_where_an_fmu_ends_the_run_the_others_finish_the_step(
    tmp_path: Path, lags: dict[str, Path], coupling: str, can: str, ends: tuple[str, ...]
) -> None:
    (tmp_path / "s.toml").write_text(TWO.format(coupling))
    (tmp_path / "s.csv").write_text("time,none\n0,0\n")
    run(tmp_path / "s.toml", lags[can], "-q", "--isolate", "none")
    endless = results.load(tmp_path / "out")
    given = [word for name in ends for word in ("--set", f"{name}.ends=0.3")]
    code, told, loop = same(tmp_path / "s.toml", lags[can], "--isolate", "none", *given)
    said = "asked to end the simulation at 0.3 s (fmi2Terminated), before the run's stop"
    assert (code, told) == (4, f"dct-harness: {ends[0]} {said}\n")
    count = len(loop.time)
    assert (loop.time[-1], len(endless.time)) == (0.3, 35)
    for name, signal in loop.signals.items():  # an ending FMU's last step differs by rounding
        assert np.abs(signal - endless[name][:count]).max() < 1e-12


@pytest.mark.parametrize(("can", "options", "said"), [
    (VARIES, ("plant.most=0.0",), "it does not get past t = 0 s, whatever the step"),
    (VARIES, ("plant.most=3e-4", "plant.mute=1.0"), "it does not tell how far it got"),
    ("", ("plant.most=0.0005",), "it cannot take this step and takes no other one"),
    (VARIES, ("plant.failAt=0.2505",), "returned fmi2Error\n  logStatusError: told to\n"),
])  # fmt: skip
def test_a_failure_is_told_in_the_same_words(
    tmp_path: Path, lags: dict[str, Path], can: str, options: tuple[str, ...], said: str
) -> None:
    given = [word for option in options for word in ("--set", option)]
    code, told, loop = same(write_system(tmp_path), lags[can], "--isolate", "none", *given)
    assert code == 4
    assert f"plant: fmi2DoStep at t = {instant(loop.run['reached'])} s " in told
    assert said in told
    assert loop.run["status"] == "partial"


@pytest.fixture(scope="module")
def suppliers(tmp_path_factory: pytest.TempPathFactory, repo_root: Path) -> Path:
    """Folder with the plants of `examples/supplier_plant`."""
    folder = tmp_path_factory.mktemp("supplier")
    command = [sys.executable, repo_root / "examples/supplier_plant/build.py", folder]
    subprocess.run(command, check=True, capture_output=True)
    return folder


@pytest.mark.parametrize(("plant", "name", "options"), [
    ("antrieb", "Antrieb", ("--stop", "4", "--isolate", "none")),
    ("antrieb", "Antrieb", ("--stop", "2", "--step", "0.007", "--interpolate")),
    ("powertrain", "Powertrain", ("--stop", "1.5", "--step", "0.005")),
])  # fmt: skip
def test_a_mapped_plant(
    repo_root: Path, tmp_path: Path, suppliers: Path, plant: str, name: str,
    options: tuple[str, ...],
) -> None:  # fmt: skip
    system = paper_loop(repo_root, tmp_path)
    mapping = repo_root / f"examples/supplier_plant/{plant}.toml"
    given: tuple[Any, ...] = ("--plant", suppliers / f"{name}.fmu", "--map", mapping, *options)
    code, _, loop = same(system, repo_root / "target/fmu", *given)
    assert code == 0
    assert np.ptp(loop["plant.engine.speed"]) > 1
    assert set(loop["plant.clutch1.state"]) <= {1, 2, 3}


def paper_loop(repo_root: Path, folder: Path) -> Path:
    """Write the paper's first case without its limits; returns the file."""
    loop = repo_root / "examples/closed_loop/paper_case1.toml"
    text = loop.read_text().partition("[[kpis]]")[0]
    for word in ("scenarios/", "parameters/"):
        text = text.replace(f'"{word}', f'"{loop.parent}/{word}')
    (folder / "s.toml").write_text(text)
    return folder / "s.toml"


def test_a_code_that_the_mapping_lacks(repo_root: Path, tmp_path: Path, suppliers: Path) -> None:
    mapping = tmp_path / "m.toml"
    text = (repo_root / "examples/supplier_plant/antrieb.toml").read_text()
    mapping.write_text(text.replace(', slipping = "schleift"', "", 1))
    system = paper_loop(repo_root, tmp_path)
    code, told, _ = same(system, repo_root / "target/fmu", "--plant", suppliers / "Antrieb.fmu",
                         "--map", mapping, "--stop", "3", "--isolate", "none")  # fmt: skip
    assert code == 4
    assert "is in no row of the table for 'clutch1.state' at t = " in told
    assert f"add it to {mapping}" in told
