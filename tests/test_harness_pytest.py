"""The pytest plugin in a pytest of its own, and the CI templates that use it."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
import yaml
from dct_harness.errors import ConfigError
from dct_harness.master.stepper import Stepper
from harness_fixture.lag_fmu import write_system

BIN = Path(sys.executable).parent
ACTIONLINT = ("actionlint", "-shellcheck=", "-pyflakes=")  # without what a machine may have
TESTS = """
import pytest

def test_loop(closed_loop):
    loop = closed_loop("s.toml", plant__tau=2.0)
    assert loop is closed_loop("s.toml", **{"plant.tau": 2.0})
    assert loop.verdict == "not judged"
    assert len(loop.time) == len(loop["plant.x"]) == 1001

def test_tube_holds(closed_loop, assert_tube):
    assert_tube(closed_loop("s.toml"), closed_loop("s.toml"))

def test_tube_breaks(closed_loop, assert_tube):
    assert_tube(closed_loop("s.toml", plant__tau=2.0), closed_loop("s.toml"), "plant.*", abs=0.01)

def test_run_breaks(closed_loop):
    closed_loop("s.toml", plant__failAt=0.5)

def test_plant(plant):
    plant["tau"] = 4.0
    plant["u"] = 2.0
    plant.step(0.001, count=4)
    assert plant["x"] == pytest.approx(0.002, rel=1e-3)

@pytest.mark.fmu_platform("linux64")
def test_here(): pass

@pytest.mark.fmu_platform("win64", "darwin64")
def test_elsewhere(): raise AssertionError("must not run")
"""


def run_pytest(*arguments: str | Path, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run pytest in a process of its own, with nothing of this session's options."""
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *arguments]
    kept = {k: v for k, v in os.environ.items() if not k.startswith(("PYTEST", "PYTHONPATH"))}
    return subprocess.run(
        command, cwd=folder, capture_output=True, text=True, check=False, env=kept
    )


@pytest.fixture(scope="module")
def session(
    tmp_path_factory: pytest.TempPathFactory, lag_dir: Path
) -> tuple[Path, subprocess.CompletedProcess[str]]:
    """Return the folder and the outcome of TESTS with the lag as plant."""
    folder = tmp_path_factory.mktemp("plugin")
    write_system(folder)
    (folder / "test_it.py").write_text(TESTS)
    (folder / "pytest.ini").write_text(f"[pytest]\ndct_fmu_dir = {lag_dir}\n")
    done = run_pytest("--dct-plant=Lag.fmu", "--dct-artefacts=kept", "-rA", "--strict-markers",
                      "--junitxml=x.xml", folder=folder)  # fmt: skip
    return folder, done


def test_fixtures_and_marker_do_what_they_say(session: tuple) -> None:
    folder, done = session
    root = ElementTree.parse(folder / "x.xml").getroot()
    outcomes = {case.get("name"): [kind.tag for kind in case if kind.tag != "system-out"]
                for case in root.iter("testcase")}  # fmt: skip
    assert outcomes == {
        "test_loop": [], "test_tube_holds": [], "test_tube_breaks": ["failure"],
        "test_run_breaks": ["failure"], "test_plant": [], "test_here": [],
    }, done.stdout  # fmt: skip
    assert "1 deselected" in done.stdout
    assert "plant: fmi2DoStep at t = 0.5 s" in done.stdout


def test_a_broken_tube_says_where_and_leaves_a_report(session: tuple) -> None:
    folder, done = session
    assert "plant.x" in done.stdout
    assert "verdict: fail, 1 of 2 agree" in done.stdout
    (kept,) = (folder / "kept").iterdir()
    assert kept.name == "test_it.py_test_tube_breaks"
    assert sorted(p.name for p in kept.iterdir()) == ["1-s", "2-s", "index.html"]
    assert "Compared with earlier runs" in (kept / "index.html").read_text(encoding="utf-8")
    assert f"results and report of this failure: {kept / 'index.html'}" in done.stdout


def test_wrong_names_are_sentences(lag_dir: Path) -> None:
    with Stepper(lag_dir / "Lag.fmu") as lag:
        with pytest.raises(ConfigError, match=r"has no output 'xx'\. Did you mean 'x'\?"):
            lag["xx"]
        with pytest.raises(ConfigError, match="'tau' is no input; parameters are set before"):
            lag["tau"] = 3.0


def test_examples_of_the_templates_pass(repo_root: Path) -> None:
    done = run_pytest("examples/ci", "-q", folder=repo_root)
    assert done.returncode == 0, done.stdout
    assert "5 passed" in done.stdout


@pytest.mark.parametrize("command", [
    ("check-jsonschema", "--builtin-schema", "vendor.github-workflows", "github-actions.yml"),
    ("check-jsonschema", "--builtin-schema", "vendor.gitlab-ci", "--data-transform", "gitlab-ci",
     "gitlab-ci.yml"),
    ("zizmor", "--offline", "--persona", "pedantic", "--no-progress", "github-actions.yml"),
    (*ACTIONLINT, "github-actions.yml"),
], ids=["GitHub schema", "GitLab schema", "zizmor", "actionlint"])  # fmt: skip
def test_templates_are_linted(repo_root: Path, command: tuple[str, ...]) -> None:
    done = subprocess.run(
        [BIN / command[0], *command[1:]], cwd=repo_root / "examples/ci", capture_output=True,
        text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize(("right", "wrong", "said"), [
    ("github.ref", "github.reff", 'property "reff" is not defined'),
    ("ubuntu-24.04", "ubuntu-24.40", 'label "ubuntu-24.40" is unknown'),
    ("if: always()", "if: allways()", 'undefined function "allways"'),
])  # fmt: skip
def test_actionlint_finds_what_a_schema_cannot(
    repo_root: Path, tmp_path: Path, right: str, wrong: str, said: str
) -> None:
    text = (repo_root / "examples/ci/github-actions.yml").read_text(encoding="utf-8")
    assert right in text
    (tmp_path / "spoilt.yml").write_text(text.replace(right, wrong))
    done = subprocess.run(
        [BIN / ACTIONLINT[0], *ACTIONLINT[1:], "spoilt.yml"], cwd=tmp_path, capture_output=True,
        text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 1
    assert said in done.stdout


def steps(repo_root: Path, template: str) -> list[str]:
    """Return the commands of a template that are the harness's."""
    text = (repo_root / "examples/ci" / template).read_text(encoding="utf-8")
    content = yaml.safe_load(text)
    (job,) = content.get("jobs", content).values()
    lines = job["script"] if "script" in job else [step.get("run", "") for step in job["steps"]]
    return [line for line in lines if line.startswith("dct-harness")]


@pytest.mark.parametrize("template", ["github-actions.yml", "gitlab-ci.yml"])
def test_commands_of_the_templates_work(repo_root: Path, template: str) -> None:
    commands = steps(repo_root, template)
    assert len(commands) == 2
    path = f"{BIN}{os.pathsep}{os.environ['PATH']}"
    for command in commands:
        done = subprocess.run(["bash", "-ec", command], cwd=repo_root, capture_output=True,
                              text=True, check=False, env={**os.environ, "PATH": path})  # fmt: skip
        assert done.returncode == 0, shlex.quote(command) + done.stdout + done.stderr
    junit = ElementTree.parse(repo_root / "target/ci/limits.xml").getroot()
    assert junit.get("failures") == "0"
    assert (repo_root / "target/ci/paper_case1/report/index.html").is_file()


def test_templates_run_on_a_suppliers_plant_named_from_the_shells_folder(
    repo_root: Path, tmp_path: Path
) -> None:
    example = repo_root / "examples/supplier_plant"
    build = [sys.executable, example / "build.py", tmp_path, "antrieb"]
    subprocess.run(build, check=True, capture_output=True)
    shutil.copy(example / "antrieb.toml", tmp_path)
    kept = f"--dct-artefacts={tmp_path / 'kept'}"
    words = (repo_root / "examples/ci", "-q", "-k", "limits or rest", kept)
    plant = "--dct-plant=Antrieb.fmu"
    done = run_pytest(*words, plant, "--dct-map=antrieb.toml", folder=tmp_path)
    assert "2 passed" in done.stdout, done.stdout
    done = run_pytest(*words, plant, folder=tmp_path)  # without its names neither can run
    assert "2 failed" in done.stdout, done.stdout
    assert "A plant with names of its own needs --map" in done.stdout
