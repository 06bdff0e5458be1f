"""`--interpolate`: inputs with slopes within a step, against closed forms and on the real plant."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from dct_harness import results
from harness_fixture.lag_fmu import LAG, VARIES, run, variable, write_fmu, write_system

STEP = 0.1  # s
CAN = f'{VARIES} canInterpolateInputs="true"'
TELLS = f'{CAN} maxOutputDerivativeOrder="1"'
RAMP = "time,u\n0,0\n10,20\n"  # u = 2 t
MORE = tuple(variable(name, k, "parameter", "1e9") for k, name in enumerate(("reach", "most"), 6))
LONG = ("--step", str(STEP), "--interpolate")
SHAFT = "plant.driveShaft.torque"


def ramp(t: np.ndarray | float) -> np.ndarray | float:
    """Return the lag's answer to u = 2 t: x' = u - x."""
    return 2 * (t - 1 + np.exp(-np.asarray(t)))


def gone(x: float, u: float, slope: float, h: float = STEP) -> float:
    """Return x after a step of a lag of 1 s whose input starts at u and has a slope."""
    late = u - slope
    return float(late + slope * h + (x - late) * np.exp(-h))


@pytest.mark.parametrize("isolate", ["none", "all"])
@pytest.mark.parametrize("option", [
    "plant.tau=1.0", "plant.reach=0.04", "plant.most=0.03",
])  # fmt: skip
def test_a_ramp_is_followed_exactly_whatever_the_step(
    tmp_path: Path, lag_library: Path, isolate: str, option: str
) -> None:
    """Also when the FMU discards the step and it is divided."""
    write_fmu(tmp_path / "Lag.fmu", lag_library, (*LAG, *MORE), can=CAN)
    system = write_system(tmp_path, scenario=RAMP)
    done = run(system, tmp_path, *LONG, "--isolate", isolate, "--set", option)
    assert done.returncode == 0, done.stderr
    found = results.load(tmp_path / "out")
    assert np.abs(found["plant.x"] - ramp(found.time)).max() < 1e-12


@pytest.mark.parametrize("option", ["plant.tau=1.0", "plant.reach=0.014", "plant.most=0.02"])
def test_substeps_go_along_the_slope(tmp_path: Path, lag_library: Path, option: str) -> None:
    """Also when the FMU discards them and they are divided."""
    write_fmu(tmp_path / "Lag.fmu", lag_library, (*LAG, *MORE), can=CAN)
    system = write_system(tmp_path, scenario=RAMP)
    system.write_text(system.read_text() + "substeps = 4\n")
    assert run(system, tmp_path, *LONG, "--set", option).returncode == 0
    found = results.load(tmp_path / "out")
    assert np.abs(found["plant.x"] - ramp(found.time)).max() < 1e-12


def test_integers_hold_within_a_step(tmp_path: Path, lag_library: Path) -> None:
    """The scenario's n falls from 2 to 1 at the end of the step: no substep before sees it."""
    n, m = variable("n", 0, "input", "0", "Integer"), variable("m", 1, "output", kind="Integer")
    write_fmu(tmp_path / "Lag.fmu", lag_library, (*LAG, n, m), can=CAN)
    system = write_system(tmp_path, scenario="time,u,n\n0,0,2\n0.1,0,1\n")
    system.write_text(system.read_text() + "substeps = 4\n")
    assert run(system, tmp_path, *LONG, "--stop", "0.3").returncode == 0
    assert results.load(tmp_path / "out")["plant.m"].tolist() == [0, 4, 2, 2]  # m = 2 n


@pytest.mark.parametrize(("can", "options"), [(VARIES, LONG), (CAN, LONG[:2])])
def test_inputs_hold_unless_both_sides_want_slopes(
    tmp_path: Path, lag_library: Path, can: str, options: tuple[str, ...]
) -> None:
    write_fmu(tmp_path / "Lag.fmu", lag_library, can=can)
    assert run(write_system(tmp_path, scenario=RAMP), tmp_path, *options).returncode == 0
    found = results.load(tmp_path / "out")
    x = [0.0]
    for k in range(len(found.time) - 1):
        x.append(gone(x[-1], 2 * float(found.time[k]), 0.0))
    assert np.abs(found["plant.x"] - x).max() < 1e-12


TWO = """[system]
name = "two"
step = 0.1
stop = 1.0
interpolate = true
coupling = "{}"
scenario = "s.csv"
[components.first]
fmu = "Lag.fmu"
[components.second]
fmu = "Lag.fmu"
parameters = {{ x = 1.0 }}
[[connections]]
from = "second.x"
to = "first.u"
[[connections]]
from = "first.x"
to = "second.u"
"""


@pytest.mark.parametrize("isolate", ["none", "all"])
@pytest.mark.parametrize("tells", [False, True])
@pytest.mark.parametrize("coupling", ["gauss-seidel", "jacobi"])
def test_slopes_between_fmus(
    tmp_path: Path, lag_library: Path, coupling: str, tells: bool, isolate: str
) -> None:
    """Fresh outputs: from old to new. Late ones: the output derivative that the FMU tells, or 0."""
    write_fmu(tmp_path / "Lag.fmu", lag_library, can=TELLS if tells else CAN)
    (tmp_path / "s.toml").write_text(TWO.format(coupling))
    (tmp_path / "s.csv").write_text("time,none\n0,0\n")
    done = run(tmp_path / "s.toml", tmp_path, "--isolate", isolate)
    assert done.returncode == 0, done.stderr
    found = results.load(tmp_path / "out")
    x, end = [0.0, 1.0], [0.0, 0.0]  # outputs; inputs at the end of the last step
    for k in range(len(found.time)):
        assert [found["first.x"][k], found["second.x"][k]] == pytest.approx(x, abs=1e-12)
        slopes = [end[j] - x[j] if tells else 0.0 for j in (0, 1)]
        first = gone(x[0], x[1], slopes[1])
        if coupling == "gauss-seidel":
            slopes[0] = (first - x[0]) / STEP
        end = [x[1] + slopes[1] * STEP, x[0] + slopes[0] * STEP]
        x = [first, gone(x[1], x[0], slopes[0])]


def test_slopes_of_a_mapped_plant_are_in_its_units(tmp_path: Path, lag_library: Path) -> None:
    write_fmu(tmp_path / "S.fmu", lag_library, can=CAN)
    system = write_system(tmp_path, scenario="time,engine.torque\n0,0\n10,20000\n")
    (tmp_path / "m.toml").write_text(
        '[inputs]\n"engine.torque" = { variable = "u", unit = "kN.m" }\n'
        '[outputs]\n"vehicle.speed" = { variable = "x", unit = "m/s" }\n'
    )
    done = run(system, tmp_path, "--plant", tmp_path / "S.fmu", "--map", tmp_path / "m.toml", *LONG)
    assert done.returncode == 0, done.stderr
    found = results.load(tmp_path / "out")
    assert np.abs(found["plant.vehicle.speed"] - ramp(found.time)).max() < 1e-12


def test_the_plant_at_10_ms_is_as_good_as_held_at_1_ms(repo_root: Path, tmp_path: Path) -> None:
    """Error of the shaft's torque against 1 ms with slopes, % of RMS; measured 0.7, 0.06, 0.007."""
    system = repo_root / "examples/closed_loop/paper_case1.toml"
    found = {}
    for name, options in {"fine": ("0.001", "--interpolate"), "held": ("0.01",), "1 ms": ("0.001",),
                          "along": ("0.01", "--interpolate")}.items():  # fmt: skip
        folder = tmp_path / name
        folder.mkdir()
        copy = folder / system.name
        text = system.read_text().replace("scenarios/", f"{system.parent}/scenarios/")
        copy.write_text(text.partition("[[kpis]]")[0])
        done = run(copy, repo_root / "target/fmu", "--stop", "8", "-q", "--step", *options)
        assert done.returncode == 0, done.stderr
        found[name] = results.load(folder / "out")[SHAFT]
    reference = found["fine"][::10]
    size = np.linalg.norm(reference)
    errors = {name: np.linalg.norm(y[:: (len(y) - 1) // 800] - reference) / size
              for name, y in found.items()}  # fmt: skip
    assert errors["along"] < errors["1 ms"] < errors["held"] / 5
