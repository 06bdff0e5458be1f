"""The golden files of the plant are what their generator writes."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

GOLDEN = Path(__file__).parent / "golden"
# Round-off of the linear algebra of another machine: in the last of 14 digits.
SPEEDS, TORQUES, TIMES = 1e-8, 1e-7, 1e-10  # [rad/s], [N·m], [s]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a case of every kind that takes seconds, made anew."""
    folder = tmp_path_factory.mktemp("golden")
    command = [
        sys.executable,
        GOLDEN / "make_golden.py",
        "--out",
        folder,
        "last_step",
        "tie_up_rigid",
    ]
    subprocess.run(command, check=True, capture_output=True)
    return folder


@pytest.mark.parametrize("case", ["last_step", "tie_up_rigid"])
def test_a_case_made_anew_is_the_one_that_is_kept(made: Path, case: str) -> None:
    new, kept = (np.loadtxt(f / f"{case}.csv", delimiter=",", skiprows=1) for f in (made, GOLDEN))
    assert new.shape == kept.shape
    apart = np.abs(new - kept)
    assert apart[:, 0].max() == 0.0
    assert apart[:, 1:7].max() < SPEEDS
    assert apart[:, 7:12].max() < TORQUES
    assert apart[:, 12:].max() == 0.0
    new, kept = (json.loads((f / f"{case}.events.json").read_text()) for f in (made, GOLDEN))
    assert [{**e, "time": 0} for e in new] == [{**e, "time": 0} for e in kept]
    times = zip(new, kept, strict=True)
    assert max((abs(a["time"] - b["time"]) for a, b in times), default=0.0) < TIMES


def test_what_a_run_needs_is_written_as_it_is_kept(made: Path) -> None:
    for name in ("last_step.json", "tie_up_rigid.json", "tie_up_rigid.scenario.csv"):
        assert (made / name).read_bytes() == (GOLDEN / name).read_bytes(), name


def test_every_case_has_its_files() -> None:
    command = [sys.executable, GOLDEN / "make_golden.py", "--list"]
    listed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    cases = {line.split()[0] for line in listed.splitlines()}
    assert cases == {path.name.split(".")[0] for path in GOLDEN.glob("*.events.json")}


# What each shows: gears that shift and lose power, jammed ones (to just after they give way), rigid
# shafts with losses, pulling and driven. The stop [s] ends a run where nothing new comes.
SECOND = {
    "upshift_losses": (1.5, 750),
    "hill_losses": (1.5, 300),
    "hill_rigid_losses": (1.5, 300),
    "losses_rigid": (2.0, 400),
}


@pytest.mark.parametrize("case", SECOND)
def test_a_second_solution_agrees_where_gears_lose_power(case: str) -> None:
    stop, rows = SECOND[case]
    command = [sys.executable, GOLDEN / "check_golden.py", "--radau", "--stop", str(stop), case]
    said = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    number = r"([\d.e+-]+)"
    pattern = rf"(\d+) rows, speeds {number} rad/s, torques {number} N·m.*event times {number} s"
    compared, speeds, torques, times = map(float, re.search(pattern, said).groups())
    assert compared == rows
    assert speeds < SPEEDS
    assert torques < TORQUES
    assert 0.0 < times < TIMES
