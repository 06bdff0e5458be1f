"""`dct-harness identify` on odd files: what a test bench or a measurement tool may write."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from asammdf import MDF, Signal
from dct_harness import cli

RATIO, STIFFNESS, DAMPING = 11.52, 5000.0, 500.0  # 1, N·m/rad, N·m·s/rad
STEP, ROWS = 0.001, 1500  # s
FOUND = 1e-3  # relative: θ is a sum of trapezoids, c that of white noise which is none
RPM = 60 / (2 * math.pi)
NAMES = ("time", "clutch2.speed", "wheel.speed", "driveShaft.torque")
Row = list[float]


def _launch(time: float) -> Row:
    """Return a row of a launch whose twist is 0.05 sin² rad: T_o = k θ + c θ'."""
    twist, rate = 0.05 * math.sin(2 * time) ** 2, 0.1 * math.sin(4 * time)
    wheel = 5 * time
    return [time, RATIO * (wheel + rate), wheel, STIFFNESS * twist + DAMPING * rate]


def _file(
    folder: Path, change: Callable[[int, Row], Row] = lambda _, row: row,
    names: tuple[str, ...] = NAMES,
) -> Path:  # fmt: skip
    """Write a launch as CSV; `change` sees the number of each row and the row."""
    path = folder / "launch.csv"
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(names)
        writer.writerows(change(k, _launch(k * STEP)) for k in range(ROWS))
    return path


def _found(path: Path, *options: str, capsys: pytest.CaptureFixture[str]) -> tuple[float, float]:
    """Return k_o [N·m/rad] and c_o [N·m·s/rad] of instrumental variables, as people read them."""
    code = cli.main(["identify", str(path), *options])
    told = capsys.readouterr()
    assert (code, told.err) == (0, "")
    words = next(line for line in told.out.splitlines() if line.startswith("iv")).split()
    return float(words[1]), float(words[4])


def test_units_of_the_header_count(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    units = ("time [ms]", "clutch2.speed [rpm]", "wheel.speed [1/min]", "driveShaft.torque [kN.m]")
    scale = (1e3, RPM, RPM, 1e-3)
    path = _file(tmp_path, lambda _, row: [v * s for v, s in zip(row, scale, strict=True)], units)
    assert _found(path, capsys=capsys) == pytest.approx((STIFFNESS, DAMPING), rel=FOUND)


def test_units_of_an_mf4_file_count(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = np.array([_launch(k * STEP) for k in range(ROWS)]).T
    units, scale = ("1/min", "rad/s", "Nm"), (RPM, 1.0, 1.0)
    signals = [Signal(samples=rows[k] * scale[k - 1], timestamps=rows[0], name=NAMES[k],
                      unit=units[k - 1]) for k in (1, 2, 3)]  # fmt: skip
    path = tmp_path / "launch.mf4"
    with MDF(version="4.10") as file:
        file.append(signals)
        file.save(path)
    assert _found(path, capsys=capsys) == pytest.approx((STIFFNESS, DAMPING), rel=FOUND)


def test_how_large_the_inputs_become_shows_a_unit_that_was_not_meant(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Speeds in rpm under a header without units: the fit is as good, stiffness a tenth of it."""
    rows = np.array([_launch(k * STEP) for k in range(ROWS)])
    clutch, wheel = RPM * rows[:, 1:3].max(axis=0)
    for factor in (1.0, RPM):
        scale = np.array([1.0, factor, factor, 1.0])
        path = _file(tmp_path, lambda _, row, by=scale: [*(np.array(row) * by)])
        assert cli.main(["identify", str(path)]) == 0
        first = capsys.readouterr().out.splitlines()[0]
        speeds = f"clutch speed up to {factor * clutch:.0f} rpm, wheel {factor * wheel:.0f} rpm,"
        assert first.startswith(speeds)
        assert first.endswith("where no unit is stated read as rad/s and N·m")


def test_signals_with_times_of_their_own_are_resampled(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A wheel speed every 10 ms, as a bus gives it, and a row that nothing was measured in."""

    def slow(k: int, row: Row) -> Row:
        row[2] = row[2] if k % 10 == 0 else math.nan
        return [row[0], *(math.nan,) * 3] if k == 700 else row

    path = _file(tmp_path, slow)
    assert cli.main(["identify", str(path)]) == 2
    said = capsys.readouterr().err
    assert "'wheel.speed' is sampled at other times than 'clutch2.speed'; give --step" in said
    assert "(t = 0.001 s is of one of them only)" in said
    found = _found(path, "--step", "0.001", capsys=capsys)
    assert found == pytest.approx((STIFFNESS, DAMPING), rel=FOUND)


def _with(column: int, value: Callable[[int, float], float]) -> Callable[[int, Row], Row]:
    def change(k: int, row: Row) -> Row:
        row[column] = value(k, row[column])
        return row

    return change


@pytest.mark.parametrize(("change", "names", "said"), [
    (_with(3, lambda *_: 50.0), NAMES, "the torque stays 50 N·m from t = 0 s to 1 s"),
    (lambda k, row: [row[0], 115.2, 10.0, row[3]], NAMES, "the speeds show no twist of the shaft"),
    (lambda k, row: [row[0], 0.0, 0.0, row[3]], NAMES, "check the speed signals"),
    (_with(3, lambda k, v: math.inf if k == 500 else v), NAMES,
     "'driveShaft.torque' is inf N.m at t = 0.5 s"),
    (_with(3, lambda _, v: v / 1000), NAMES,
     "|T_o| never reaches 20 N·m, but 0.2596 at most: take data of a launch, say the unit"),
    (_with(0, lambda _, v: v * 1000), NAMES,
     "only 2 rows of 20 from t = 74 s on, as they are 1 s apart; take a longer --length, or say "
     "the unit of the time where it is ms"),
    (_with(3, lambda _, v: -v), NAMES,
     "k_o = -5000 N·m/rad, c_o = -500 N·m·s/rad (iv), both below 0: torque and speeds differ in "
     "sign; a --map file can say factor = -1"),
    (_with(3, lambda k, _: 100.0 + 10 * math.sin(1e4 * k * k)), NAMES,
     "noise hides the twist of the shaft; take a launch whose torque changes more"),
    (_with(2, lambda k, v: 1e300 if k == 9 else v), NAMES,
     "'wheel.speed' is 1e+300 rad/s at t = 0.009 s"),
    (_with(0, lambda k, v: v + 2e-4 * (k == 3)), NAMES,
     "after t = 0.002 s comes a step of 0.0012 s, most are 0.001 s; give --step 0.001 to resample"),
    (_with(0, lambda k, v: v - 1 if k == 900 else v), NAMES, "it must increase"),
    (lambda k, row: [*row, row[3]], (*NAMES, NAMES[3]),
     "two signals are called 'driveShaft.torque'; rename one"),
    (lambda _, row: row, (*NAMES[:2], "wheel.speed [km/h]", NAMES[3]),
     "'wheel.speed' is in 'km/h', which is no unit of [rad/s]: a --map file can say unit"),
    (lambda _, row: row, (*NAMES[:3], "driveShaft.torque [lbf.ft]"), "is in 'lbf.ft'"),
    (lambda _, row: row, (*NAMES[:3], "M_Abtrieb"), "There are clutch2.speed, wheel.speed, "
     "M_Abtrieb. --torque names another."),
])  # fmt: skip
def test_what_is_no_launch_is_refused_by_name_value_and_time(
    change: Callable[[int, Row], Row], names: tuple[str, ...], said: str, tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    path = _file(tmp_path, change, names)
    assert cli.main(["identify", str(path)]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1  # a sentence: no warning of numpy, no traceback


@pytest.mark.parametrize(("option", "value", "said"), [
    ("--ratio", "-11", "'-11' is not a ratio above 0"),
    ("--ratio", "0", "'0' is not a ratio above 0"),
    ("--start", "nan", "'nan' is not a time"),
])  # fmt: skip
def test_options_that_are_no_numbers_are_refused(
    option: str, value: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as end:
        cli.main(["identify", str(_file(tmp_path)), option, value])
    assert end.value.code == 2
    assert said in capsys.readouterr().err
