"""`dct-harness compare`: tolerances against closed forms and a naive envelope; exit codes."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
from dct_harness import cli, formats, results
from dct_harness.compare import Outcome, Tolerance, Tolerances, compare, tolerances
from dct_harness.compare.envelope import bounds
from dct_harness.errors import ConfigError
from dct_harness.results import Results
from dct_harness.verbs.compare import sentence, table

STEP = 0.001  # s
TIME = np.arange(2001) * STEP
EXACT = Tolerance(abs=0.0, rel=0.0)


def one(a: np.ndarray, b: np.ndarray, allowed: Tolerance, kind: str = "Real") -> Outcome:
    """Return the outcome of a single signal."""
    run = {"signals": {"x": {"unit": "N.m", "type": kind}}}
    first, second = (Results({"time": TIME[: len(v)], "x": v}, run) for v in (a, b))
    return compare(first, second, Tolerances(allowed))[1]


def step(at: float) -> np.ndarray:
    """Return 0 before and 1 from a time [s] on."""
    return (at - STEP / 2 <= TIME).astype(float)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("held", [False, True])
def test_envelope_is_that_of_a_fine_search(seed: int, held: bool) -> None:
    noise = np.random.default_rng(seed)
    time = np.cumsum(noise.uniform(0.5, 1.5, 60))
    values = noise.normal(size=60)
    at = np.sort(noise.uniform(time[0], time[-1], 40))
    tube = float(noise.uniform(0.1, 6.0))
    low, high = bounds(time, values, at, tube, held)
    for k, t in enumerate(at):
        near = np.unique(np.clip([t - tube, t + tube, *time[np.abs(time - t) <= tube]],
                                 time[0], time[-1]))  # fmt: skip
        if held:
            found = values[np.searchsorted(time, near, side="right") - 1]
        else:
            found = np.interp(near, time, values)
        assert (low[k], high[k]) == pytest.approx((found.min(), found.max()), abs=1e-12)


@pytest.mark.parametrize("kind", ["Real", "Integer"])
@pytest.mark.parametrize(("late", "tube", "passes"), [
    (0.0, 0.0, True), (0.003, 0.0, False), (0.003, 0.002, False), (0.003, 0.003, True),
    (-0.003, 0.003, True), (-0.004, 0.003, False),
])  # fmt: skip
def test_tube_forgives_an_event_that_moves(
    kind: str, late: float, tube: float, passes: bool
) -> None:
    allowed = Tolerance(abs=1e-12, rel=0.0, tube=tube)
    assert one(step(1.0), step(1.0 + late), allowed, kind).passed is passes


def test_tube_does_not_hide_a_wrong_height() -> None:
    found = one(step(1.0), 1.1 * step(1.0), Tolerance(abs=0.05, rel=0.0, tube=0.5))
    assert not found.passed
    assert found.reason.startswith("differs by 0.1, allowed 0.05 within ±0.5 s")


@pytest.mark.parametrize(("allowed", "passes"), [
    (Tolerance(abs=0.31, rel=0.0), True), (Tolerance(abs=0.29, rel=0.0), False),
    (Tolerance(abs=0.0, rel=0.0301), True), (Tolerance(abs=0.0, rel=0.0299), False),
    (Tolerance(abs=0.15, rel=0.0151), True), (Tolerance(abs=1.0, nrmse=0.0299), False),
    (Tolerance(abs=1.0, nrmse=0.0301), True),
])  # fmt: skip
def test_absolute_relative_and_rms_bounds_of_a_scaled_sine(
    allowed: Tolerance, passes: bool
) -> None:
    sine = 10 * np.sin(2 * np.pi * TIME)
    found = one(sine, 1.03 * sine, allowed)  # differs by 0.3 at most, by 3 % of RMS
    assert found.passed is passes
    assert (found.worst <= 1) is passes
    assert found.nrmse == pytest.approx(0.03, rel=1e-9)


def test_equal_runs_agree_without_any_allowance() -> None:
    noise = np.random.default_rng(3).normal(size=len(TIME))
    assert one(noise, noise.copy(), EXACT).worst == 0


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("kind", ["Real", "Integer"])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_no_number_is_never_near(bad: float, kind: str) -> None:
    """Nor is it to itself; the sentence says where it stands, and what to do of a reference."""
    good, values = np.ones(len(TIME)), np.ones(len(TIME))
    values[[700, 900]] = bad
    for reference, run, said in (
        (good, values, f"x is {bad:g} in the run at t = 0.7 s: no tolerance allows that"),
        (values, good, f"x is {bad:g} in the reference at t = 0.7 s: make the reference again, or "
                       "leave the signal out: `ignore = true` in a file for --tolerances"),
        (values, values, f"x is {bad:g} in the reference at t = 0.7 s: make"),
    ):  # fmt: skip
        found = one(reference, run, Tolerance(abs=1e300, tube=0.01, nrmse=1e300), kind)
        assert (found.passed, found.worst) == (False, np.inf)
        assert found.time == pytest.approx(0.7)
        assert sentence(found).startswith(said)
        assert said.removeprefix("x ") in table([found], everything=True)


def test_shorter_run_and_missing_signal_fail_and_a_new_one_does_not() -> None:
    reference = Results({"time": TIME, "a": TIME, "b": TIME}, {})
    short = TIME[:1500]
    run = Results({"time": short, "a": short, "c": short}, {})
    found = {o.name: o for o in compare(reference, run, Tolerances(EXACT))}
    assert {n: o.passed for n, o in found.items()} == {"time": False, "a": True, "b": False}
    assert found["time"].reason == "runs from 0 s to 1.499 s, reference 0 s to 2 s"
    assert found["b"].reason == "is missing in the run"


def test_a_coarser_run_is_judged_where_it_has_samples() -> None:
    sine = np.sin(TIME)
    reference = Results({"time": TIME, "x": sine}, {})
    coarse = Results({"time": TIME[::10], "x": sine[::10]}, {})
    assert all(o.passed for o in compare(reference, coarse, Tolerances(EXACT)))


RULES = """[default]
abs = 0.1
[[signals]]
name = "observer.*"
abs = 2
tube = 0.01
[[signals]]
name = "*.innovation.*"
ignore = true
[[signals]]
name = "observer.clutch1.torque"
tube = 0.0
"""


def test_the_last_rule_that_matches_wins_key_by_key(tmp_path: Path) -> None:
    (tmp_path / "t.toml").write_text(RULES)
    read = tolerances.load(tmp_path / "t.toml", Tolerance(rel=0.5))
    assert read.of("plant.x") == Tolerance(0.1, 0.5)
    assert read.of("observer.x") == Tolerance(2, 0.5, 0.01)
    assert read.of("observer.clutch1.torque") == Tolerance(2, 0.5, 0.0)
    assert read.of("observer.innovation.x1").ignore
    assert read.unused(["observer.x"]) == ["*.innovation.*", "observer.clutch1.torque"]


@pytest.mark.parametrize(("text", "said"), [
    ("[default]\nabss = 1\n", "no key 'abss'. Did you mean 'abs'?"),
    ("[default]\nabs = -1\n", "abs = -1 is not a number of at least 0"),
    ("[default]\nabs = nan\n", "is not a number"), ("[default]\nabs = true\n", "wrong type"),
    ("[[signals]]\nabs = 1\n", "entry 1: needs a name"), ("[signal]\n", "Did you mean 'signals'?"),
    ("[signals]\nname = 'x'\nignore = 1\n", "wrong type"), ("signals = [1]\n", "tables"),
    ("default = 3\n", "tables"), ("[", "not valid TOML"),
])  # fmt: skip
def test_bad_tolerances_are_refused(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "t.toml").write_text(text)
    with pytest.raises(ConfigError, match=r"t\.toml") as caught:
        tolerances.load(tmp_path / "t.toml", Tolerance())
    assert said in str(caught.value)


@pytest.fixture
def pair(tmp_path: Path) -> tuple[str, str]:
    """Write a run as a directory, and one that differs by 1 in one of two signals as a file."""
    rows = np.column_stack([TIME, step(1.0), TIME])
    signals = {n: {"unit": "N.m", "type": "Real"} for n in ("plant.a", "plant.b")}
    names = ["time", *signals]
    results.write(tmp_path / "ref", names, rows, {"signals": signals})
    rows[300, 1] += 1.0
    formats.write(tmp_path / "new.parquet", formats.Table(names, rows))
    return str(tmp_path / "ref"), str(tmp_path / "new.parquet")


def test_exit_code_table_json_and_junit_tell_the_regression(
    pair: tuple[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "x.xml"
    assert cli.main(["compare", *pair, "--junit", str(file)]) == 1
    said = capsys.readouterr().out
    assert "plant.a" in said
    assert "plant.b" not in said
    assert said.endswith("verdict: fail, 2 of 3 agree\n")
    failures = ElementTree.parse(file).findall(".//testcase[@name='a']/failure")
    assert failures[0].get("message") == (
        "plant.a differs by 1, allowed 1.001e-06 (worst at t = 0.3 s: 1 for 0 N.m)"
    )
    assert cli.main(["compare", *pair, "--json"]) == 1
    told = json.loads(capsys.readouterr().out)
    assert {o["unit"] for o in told} == {"s", "N.m"}
    assert {o["name"]: o["passed"] for o in told} == {
        "time": True, "plant.a": False, "plant.b": True,
    }  # fmt: skip


def test_a_terminal_shows_digits_that_tell_and_json_all_of_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    names, files = ["time", "plant.a"], [str(tmp_path / "ref"), str(tmp_path / "new")]
    told = {"signals": {"plant.a": {"unit": "N.m", "type": "Real"}}}
    for file, change in zip(files, (0.0, -1 / 300), strict=True):
        rows = np.column_stack([TIME, 100 * step(1.0) - 1 / 7])
        rows[500, 1] += change
        results.write(Path(file), names, rows, told)
    assert cli.main(["compare", *files]) == 1
    row = capsys.readouterr().out.splitlines()[2].split()
    assert row[2:6] == ["0.5", "−0.1429", "−0.1462", "N·m"]
    assert " ".join(row[7:]) == "differs by 0.00333, allowed 9.99·10⁻⁵"
    assert cli.main(["compare", *files, "--json"]) == 1
    exact = json.loads(capsys.readouterr().out)[1]
    assert (exact["reference"], exact["unit"]) == (-1 / 7, "N.m")
    assert exact["value"] == -1 / 7 - 1 / 300


def test_allowance_of_the_command_line_passes(
    pair: tuple[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["compare", *pair, "--abs", "1.0", "--quiet"]) == 0
    assert capsys.readouterr().out == ""
    assert cli.main(["compare", *pair, "--abs", "1.0", "--nrmse", "0.01"]) == 1
    assert "NRMSE" in capsys.readouterr().out


def test_a_rule_that_matches_nothing_is_noted(
    pair: tuple[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "t.toml").write_text(RULES)
    assert cli.main(["compare", *pair, "--tolerances", str(tmp_path / "t.toml")]) == 1
    assert "note: no signal matches 'observer.*'" in capsys.readouterr().out


def test_usage_errors_exit_2(pair: tuple[str, str], capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["compare", pair[0], "nowhere"]) == 2
    assert "make it with `dct-harness run`" in capsys.readouterr().err
    with pytest.raises(SystemExit) as caught:
        cli.main(["compare", *pair, "--tube=-1"])
    assert caught.value.code == 2
