"""Study files of `dct-harness sweep`: what is planned, what is refused, what a run is told."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from dct_harness import cli
from dct_harness.errors import ConfigError
from dct_harness.sweep import cases as study_cases
from dct_harness.sweep import study_file
from dct_harness.sweep.sampling import parse, points
from dct_harness.sweep.study import Study
from dct_harness.verbs.sweep import plan
from harness_fixture.lag_fmu import harness, write_system
from pyarrow import parquet

FACTORS = 'set = "plant.tau"\nuniform = [1, 2]\n'
STUDY = f"""[study]
name = "lag"
system = "s.toml"
runs = 2
sampling = "grid"

[factors.lag]
{FACTORS}relative = true
"""
MANY = 20_000
FOUR_SIGMA = 4.0  # of the sampling error: one wrong alarm in 16 000, and the seed is fixed


def write(folder: Path, text: str = STUDY) -> Path:
    """Write a study of the lag, its system file beside it."""
    write_system(folder, "0.05")
    (folder / "study.toml").write_text(text)
    return folder / "study.toml"


def planned(file: Path, fmu_dir: Path, *options: str) -> Study:
    """Return the plan of a command line."""
    words = ["sweep", str(file), "--fmu-dir", str(fmu_dir), *options]
    return plan(cli.parser().parse_args(words))


@pytest.mark.parametrize(("old", "new", "said"), [
    ('name = "lag"', "", "study.toml:1:1: study: 'name' is a required property. Add name = …"),
    ("runs = 2", "rums = 2", "study.toml:4:1: study: Additional properties are not allowed "
     "('rums' was unexpected). Did you mean 'runs'?"),
    ('"grid"', '"gird"', "study.toml:5:1: study.sampling: 'gird' is not one of"),
    ('"grid"', '"gird"', "Did you mean 'grid'?"),
    ("runs = 2", "runs = 0", "study.toml:4:1: study.runs: 0 is less than the minimum of 1. It is: "
     "sets of numbers"),
    ("s.toml", "t.toml", "study.toml:3:1: study.system: no file"),
    ("[1, 2]", "[2, 1]", "study.toml:9:1: factors.lag.uniform: no such distribution; it is "
     "uniform(LOW,HIGH) with LOW below HIGH"),
    ("uniform = [1, 2]", "", "study.toml:7:1: factors.lag: needs exactly one of uniform, normal, "
     "lognormal, truncated, values"),
    ('set = "plant.tau"', "", "study.toml:7:1: factors.lag: sets no parameter; add set ="),
    ("plant.tau", "plan.tau", "study.toml:8:1: 'plan.tau'"),
    ("plant.tau", "plant.tua", "has no variable 'tua'. Did you mean 'tau'?"),
])  # fmt: skip
def test_what_is_wrong_is_told_with_its_place_and_remedy(
    lag_dir: Path, tmp_path: Path, old: str, new: str, said: str
) -> None:
    assert old in STUDY
    file = write(tmp_path, STUDY.replace(old, new, 1))
    with pytest.raises(ConfigError) as caught:
        study_cases.jobs(planned(file, lag_dir))
    assert said in str(caught.value)


@pytest.mark.parametrize(("more", "said"), [
    ('[report]\nheat = [["lag", "lga"]]\n', "not 'lga'. Did you mean 'lag'?"),
    ('[[kpis]]\nkpi = "shift.jerkPaek"\nsignal = "x"\n', "Did you mean 'shift.jerkPeak'?"),
    ('[scenarios.up]\nfile = "no.csv"\n', "study.toml:13:1: scenarios.up.file: no file"),
    ("[set]\ntau = 1\n", "It is: COMPONENT.VARIABLE in quotes"),
])  # fmt: skip
def test_sections_name_what_exists(tmp_path: Path, more: str, said: str) -> None:
    with pytest.raises(ConfigError) as caught:
        study_file.load(write(tmp_path, f"{STUDY}\n{more}"))
    assert said in str(caught.value)


def test_a_file_and_options_make_the_same_plan(lag_dir: Path, tmp_path: Path) -> None:
    plain = STUDY.replace("relative = true\n", "").replace("[factors.lag]", '[factors."plant.tau"]')
    told = planned(write(tmp_path, plain), lag_dir)
    options = ("--vary", "plant.tau=uniform(1,2)", "--runs", "2", "--sampling", "grid")
    given = planned(tmp_path / "s.toml", lag_dir, *options)
    assert study_cases.jobs(told) == study_cases.jobs(given)
    assert told.common == given.common


def test_options_stand_above_the_file(lag_dir: Path, tmp_path: Path) -> None:
    study = planned(write(tmp_path), lag_dir, "--runs", "3", "--vary", "plant.delay=choice(0)")
    assert (study.runs, study.sampling) == (3, "grid")
    assert [f.name for f in study.factors] == ["lag", "plant.delay"]


def test_axes_are_combined_and_a_relative_factor_starts_from_what_each_has(
    lag_dir: Path, tmp_path: Path
) -> None:
    """The preset sets tau to 3, the file of the system says nothing: the FMU's start value is 1."""
    axes = (
        '[scenarios.long]\nfile = "s.csv"\nstop = 0.08\n[scenarios.short]\nfile = "s.csv"\n'
        '[presets.own]\n[presets.slow]\nplant = "slow.ssv"\n'
        '[methods]\nnames = ["a", "b"]\nset = "plant.delay"\n'
    )
    file = write(tmp_path, f"{STUDY}{axes}")
    (tmp_path / "slow.ssv").write_text(
        '<s:ParameterSet xmlns:s="http://ssp-standard.org/SSP1/SystemStructureParameterValues" '
        'version="1.0" name="slow"><s:Parameters><s:Parameter name="tau"><s:Real value="3"/>'
        "</s:Parameter></s:Parameters></s:ParameterSet>"
    )
    jobs = study_cases.jobs(planned(file, lag_dir))
    assert len(jobs) == 2 * 2 * 2 * 2
    assert len({tuple(job.chosen.items()) for job in jobs}) == len(jobs)
    for job in jobs:
        base = 3 if job.chosen["preset"] == "slow" else 1
        assert job.words[-1] == f"plant.tau={json.dumps(base * job.chosen['lag'])}"
        assert ("--stop" in job.words) == (job.chosen["scenario"] == "long")


def test_a_study_keeps_rows_and_chosen_courses(lag_dir: Path, tmp_path: Path) -> None:
    file = write(tmp_path, f'{STUDY}[keep]\nsignals = ["plant.*"]\nevery = 0.01\n')
    words = ("sweep", file, "--fmu-dir", lag_dir, "--out", tmp_path / "out", "--jobs", "2")
    done = harness(*words, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    with (tmp_path / "out/sweep.csv").open() as table:
        rows = list(csv.DictReader(table))
    assert [(r["run"], r["lag"], r["verdict"]) for r in rows] == [
        ("1", "1.0", "not judged"), ("2", "2.0", "not judged")]  # fmt: skip
    for row in rows:
        kept = parquet.read_table(tmp_path / f"out/courses/run-{int(row['run']):06d}.parquet")
        x = kept["plant.x"].to_numpy()
        assert kept["time"].to_pylist() == pytest.approx([0, 0.01, 0.02, 0.03, 0.04, 0.05])
        assert x[-1] == pytest.approx(2 * (1 - np.exp(-0.05 / float(row["lag"]))), rel=1e-3)


def test_a_run_that_fails_is_tried_again_and_told_with_its_cause(
    lag_dir: Path, tmp_path: Path
) -> None:
    text = STUDY.replace("plant.tau", "plant.failAt").replace("relative = true", "")
    file = write(tmp_path, text.replace("[1, 2]", "[0.02, 9.0]"))
    words = ("sweep", file, "--fmu-dir", lag_dir, "--out", tmp_path / "out")
    assert harness(*words, folder=tmp_path).returncode == 1
    row = parquet.read_table(tmp_path / "out/store/run-000001.parquet").to_pylist()[0]
    assert (row["verdict"], row["lag"]) == ("exit 4", 0.02)
    assert "fmi2DoStep at t = 0.02 s" in row["error"]
    again = harness(*words, "--resume", "--retry", "-v", folder=tmp_path)
    assert again.stdout.splitlines()[0].split() == ["1", "exit", "4", "lag", "=", "0.02"]
    assert [w[0] for w in map(str.split, again.stdout.splitlines()) if w and w[0] in "12"] == ["1"]


def test_what_varies_nothing_is_no_study(lag_dir: Path, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="nothing is varied; give --vary COMPONENT"):
        planned(write_system(tmp_path), lag_dir)


@pytest.mark.parametrize(("text", "mean", "deviation"), [
    ("lognormal(2,0.5)", 2 * np.exp(0.125), 2 * np.exp(0.125) * np.sqrt(np.exp(0.25) - 1)),
    ("truncated(1,2,0,2)", 1.0, 0.5659),  # 2 sqrt(1 - 2 a phi(a) / (2 Phi(a) - 1)), a = 1/2
])  # fmt: skip
def test_other_distributions_have_their_moments(text: str, mean: float, deviation: float) -> None:
    found = np.array([p["a.x"] for p in points([parse(f"a.x={text}")], MANY, 1, "random")])
    assert found.mean() == pytest.approx(mean, abs=FOUR_SIGMA * deviation / MANY**0.5)
    assert found.std() == pytest.approx(deviation, rel=0.03)
    if text.startswith("truncated"):
        assert (found.min() >= 0, found.max() <= 2) == (True, True)


def test_saltelli_changes_one_factor_at_a_time() -> None:
    """Blocks of d + 2 rows: A, then A with one column of B each, then B."""
    rows = points([parse("a.x=uniform(0,1)"), parse("a.y=uniform(0,1)")], 4, 3, "saltelli")
    assert len(rows) == 4 * (2 + 2)
    for k in range(0, len(rows), 4):
        a, ab_x, ab_y, b = ((r["a.x"], r["a.y"]) for r in rows[k : k + 4])
        assert (ab_x, ab_y) == ((b[0], a[1]), (a[0], b[1]))


def test_a_grid_has_both_ends_and_its_own_levels() -> None:
    rows = points([parse("a.x=uniform(0,1)"), parse("a.y=normal(0,1)")], 3, 0, "grid")
    assert [r["a.x"] for r in rows] == [0, 0, 0, 0.5, 0.5, 0.5, 1, 1, 1]
    assert [r["a.y"] for r in rows[:3]] == pytest.approx([-0.9674, 0, 0.9674], abs=1e-4)
