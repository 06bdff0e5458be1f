"""`dct-harness sweep`: draws that a seed repeats, and failing runs that do not end it."""

from __future__ import annotations

import csv
import json
import signal
import subprocess
from pathlib import Path

import numpy as np
import pytest
from dct_harness.errors import ConfigError
from dct_harness.sweep_verb import draws
from harness_fixture.lag_fmu import HARNESS, environment, harness, write_system

MANY = 20_000
FOUR_SIGMA = 4.0  # of the sampling error: one wrong alarm in 16 000, and the seed is fixed


def test_draws_have_the_moments_of_their_distribution() -> None:
    found = draws(["a.x=uniform(2, 5)", "b.y=normal(10,0.5)"], MANY, 1)
    sigma = {"a.x": 3 / 12**0.5, "b.y": 0.5}
    for name, mean in (("a.x", 3.5), ("b.y", 10.0)):
        near = FOUR_SIGMA * sigma[name] / MANY**0.5
        assert found[name].mean() == pytest.approx(mean, abs=near)
        assert found[name].std() == pytest.approx(sigma[name], rel=0.03)
    assert (found["a.x"].min() >= 2, found["a.x"].max() <= 5) == (True, True)
    assert abs(np.corrcoef(found["a.x"], found["b.y"])[0, 1]) < FOUR_SIGMA / MANY**0.5


def test_a_seed_repeats_its_draws_and_another_does_not() -> None:
    first, again, other = (draws(["a.x=uniform(0,1)"], 5, seed)["a.x"] for seed in (3, 3, 4))
    assert (first == again).all()
    assert (first != other).all()


@pytest.mark.parametrize("text", [
    "a.x", "a.x=uniform(1)", "a.x=gauss(1,2)", "a.x=uniform(2,1)", "a.x=normal(1,-1)",
    "a.x=normal(one,2)", "a.x=normal(nan,2)",
])  # fmt: skip
def test_what_is_no_draw_is_refused(text: str) -> None:
    with pytest.raises(ConfigError, match="write COMPONENT"):
        draws([text], 3, 0)


def test_sweep_judges_every_run_and_goes_on_after_a_failure(lag_dir: Path, tmp_path: Path) -> None:
    system = write_system(tmp_path)
    words = ["sweep", system, "--fmu-dir", lag_dir, "--out", tmp_path / "out", "--runs", "6",
             "--vary", "plant.failAt=uniform(0.5,1.5)"]  # fmt: skip
    done = harness(*words, folder=tmp_path)
    assert done.returncode == 1, done.stderr
    with (tmp_path / "out/sweep.csv").open() as file:
        rows = list(csv.DictReader(file))
    verdicts = [row["verdict"] for row in rows]
    assert verdicts == ["exit 4" if float(r["plant.failAt"]) < 1 else "not judged" for r in rows]
    failed = verdicts.count("exit 4")
    assert 0 < failed < 6
    assert f"verdict: fail, {failed} of 6 runs miss a limit" in done.stdout
    kept = [p for p in (tmp_path / "out").iterdir() if p.is_dir()]
    assert len(kept) == failed  # those that failed, to look at


def test_unknown_parameter_ends_the_sweep_with_2(lag_dir: Path, tmp_path: Path) -> None:
    done = harness("sweep", write_system(tmp_path), "--fmu-dir", lag_dir, "--vary",
                   "plant.tua=uniform(1,2)", folder=tmp_path)  # fmt: skip
    assert done.returncode == 2
    assert "Did you mean 'tau'?" in done.stderr


def test_ctrl_c_keeps_the_runs_so_far(lag_dir: Path, tmp_path: Path) -> None:
    system = write_system(tmp_path)
    command = [*HARNESS, "sweep", system, "--fmu-dir", lag_dir, "--out", tmp_path / "out",
               "--runs", "100000", "-v", "--vary", "plant.tau=uniform(1,2)"]  # fmt: skip
    with subprocess.Popen(command, env=environment(tmp_path), stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True) as process:  # fmt: skip
        process.stdout.readline()
        process.send_signal(signal.SIGINT)
        process.communicate()
    assert process.returncode == 130
    with (tmp_path / "out/sweep.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert 1 <= len(rows) < 1000
    assert list((tmp_path / "tmp").iterdir()) == []


def test_sweep_as_json_is_the_spread_of_its_csv(lag_dir: Path, tmp_path: Path) -> None:
    limit = '[[kpis]]\nkpi = "shift.jerkPeak"\nsignal = "vehicle.acceleration"\nmax = 1\n'
    system = write_system(tmp_path)
    system.write_text(system.read_text() + limit)
    done = harness("sweep", system, "--fmu-dir", lag_dir, "--out", tmp_path / "out", "--runs", "3",
                   "--vary", "plant.tau=uniform(1,2)", "--json", folder=tmp_path)  # fmt: skip
    told = json.loads(done.stdout)
    assert (told["runs"], told["missed"], told["verdict"]) == (3, 3, "fail")
    assert done.returncode == 1
    assert done.stderr == ""
