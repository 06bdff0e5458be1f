"""Start values and effective parameters, in run.json and in the report's Details."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from dct_harness import report, results
from dct_harness.report import cells, runs
from harness_fixture.lag_fmu import run, write_system


def record(system: Path, fmus: Path, *options: str) -> dict:
    """Run a system and return its run.json."""
    done = run(system, fmus, *options)
    assert done.returncode == 0, done.stderr
    return results.load(system.parent / "out").run


def one_step(repo_root: Path, tmp_path: Path) -> Path:
    """Write the paper's case 1 with a stop after one step."""
    text = (repo_root / "examples/closed_loop/paper_case1.toml").read_text(encoding="utf-8")
    scenarios = repo_root / "examples/closed_loop/scenarios"
    system = tmp_path / "system.toml"
    text = text.replace("stop = 30.0", "stop = 0.001").replace("scenarios/", f"{scenarios}/")
    system.write_text(text.partition("[[kpis]]")[0], encoding="utf-8")
    return system


def test_parameters_are_recorded_set_or_not(lag_dir: Path, tmp_path: Path) -> None:
    found = record(write_system(tmp_path), lag_dir, "--set", "plant.tau=2")["parameters"]
    values = {name: p["value"] for name, p in found["plant"].items()}
    assert values == {"tau": 2.0, "failAt": 1e9, "nanAt": 1e9, "delay": 0.0}


def test_every_parameter_of_the_xml_is_recorded_with_its_unit(
    repo_root: Path, tmp_path: Path
) -> None:
    system = one_step(repo_root, tmp_path)
    found = record(system, repo_root / "target/fmu", "--set", "observer.load.method=grade")
    for component, model in (("plant", "DctPlant"), ("observer", "DctObserver")):
        root = ElementTree.parse(repo_root / f"modelDescription/{model}.xml").getroot()
        units = {v.get("name"): v[0].get("unit", "") for v in root.iter("ScalarVariable")
                 if v.get("causality") == "parameter"}  # fmt: skip
        got = {name: p["unit"] for name, p in found["parameters"][component].items()}
        assert got == units
    assert found["parameters"]["observer"]["load.method"] == {
        "value": 1, "unit": "", "item": "grade",
    }  # fmt: skip
    assert found["parameters"]["observer"]["adaptation.enabled"]["value"] is True


@pytest.mark.parametrize(("option", "said"), [
    ("observer.load.method=grad", "has no item 'grad' (grade, engine, momentum). "
                                  "Did you mean 'grade'?"),
    ("observer.adaptation.enabled=1", "'adaptation.enabled' is Boolean, got 1"),
    ("observer.gain.L11=big", "'gain.L11' is Real [1/s], got 'big'"),
])  # fmt: skip
def test_value_of_the_wrong_type_is_refused(
    repo_root: Path, tmp_path: Path, option: str, said: str
) -> None:
    done = run(one_step(repo_root, tmp_path), repo_root / "target/fmu", "--set", option)
    assert done.returncode == 2
    assert said in done.stderr


def test_report_lists_all_parameters_once_where_runs_agree(lag_dir: Path, tmp_path: Path) -> None:
    made = []
    for name, tau in (("a", "1.0"), ("b", "2.5")):
        (tmp_path / name).mkdir()
        record(write_system(tmp_path / name), lag_dir, "--set", f"plant.tau={tau}")
        made.append(tmp_path / name / "out")
    found = {row["name"]: row["values"] for row in cells.effective(runs.load(made))}
    assert found["plant.tau"] == ["1.0", "2.5"]
    assert found["plant.delay"] == ["0.0"]
    page = report.write(made, tmp_path / "report", "T").read_text(encoding="utf-8")
    assert "Effective parameters (4)" in page
    assert '<td colspan="2">0.0</td>' in page
