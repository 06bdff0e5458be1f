"""FMUs of `target/fmu` that are older than the sources of their checkout: told, with the remedy."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from dct_harness import results
from dct_harness.fmu import sources
from harness_fixture.lag_fmu import HARNESS, write_fmu
from importer_cases import MODELS, fmu
from test_harness_pytest import run_pytest

SAID = "not built from the sources as they are now"
REMEDY = "`cargo fmu build`"


@pytest.fixture(scope="module")
def copy(repo_root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Copy of the checkout, as far as FMUs are made of it, with the FMUs that were built."""
    root = tmp_path_factory.mktemp("checkout")
    built = repo_root / sources.FOLDER
    shutil.copytree(built, root / sources.FOLDER)
    record = json.loads((built / sources.RECORD).read_text())
    for name in record["sources"]:
        (root / name).parent.mkdir(exist_ok=True)
        copied = shutil.copytree if (repo_root / name).is_dir() else shutil.copy
        copied(repo_root / name, root / name)
    return root


@pytest.fixture
def checkout(copy: Path, tmp_path: Path) -> Path:
    """Copy that a test may change."""
    return shutil.copytree(copy, tmp_path / "checkout")


def remark(checkout: Path) -> str:
    """Return what is said of the FMUs of a checkout."""
    return sources.remark(sorted((checkout / sources.FOLDER).glob("*.fmu")))


def test_fmus_that_were_just_built_are_what_the_sources_give() -> None:
    assert sources.remark(map(fmu, MODELS)) == ""


def append(checkout: Path, name: str) -> None:
    """Change a file."""
    with (checkout / name).open("a") as file:
        file.write("// changed\n")


@pytest.mark.parametrize(("name", "named"), [
    ("src/models/plant.rs", ["DctClutchControl", "DctObserver", "DctPlant"]),
    ("target/fmu/DctPlant.fmu", ["DctPlant"]),
    ("fmu-build/tests/lag.c", []),
])  # fmt: skip
def test_what_was_changed_since_makes_fmus_old(checkout: Path, name: str, named: list[str]) -> None:
    assert remark(checkout) == ""
    append(checkout, name)
    said = remark(checkout)
    assert (SAID in said, REMEDY in said) == (bool(named), bool(named))
    assert [Path(path).stem for path in said.partition(":")[0].split(", ")] == named or not named


@pytest.mark.parametrize("change", [
    lambda root: (root / sources.FOLDER / sources.RECORD).unlink(),
    lambda root: (root / sources.FOLDER / sources.RECORD).write_text("[]"),
    lambda root: (root / "src/models/more.rs").write_text(""),
    lambda root: (root / "src/models/plant.rs").unlink(),
])  # fmt: skip
def test_fmus_of_unknown_sources_are_old(checkout: Path, change: Callable[[Path], None]) -> None:
    change(checkout)
    assert remark(checkout).count(".fmu") == 3


def test_elsewhere_and_of_others_nothing_is_said(checkout: Path, lag_library: Path) -> None:
    append(checkout, "src/models/plant.rs")
    shutil.move(checkout / "target", checkout / "there")
    assert sources.remark((checkout / "there/fmu").glob("*.fmu")) == ""
    foreign = checkout / "target/fmu/Lag.fmu"
    foreign.parent.mkdir(parents=True)
    assert sources.remark([write_fmu(foreign, lag_library), foreign.with_name("None.fmu")]) == ""
    shutil.move(checkout / "there/fmu/DctPlant.fmu", foreign.parent)
    assert remark(checkout) != ""
    shutil.rmtree(checkout / "fmu-build")
    assert remark(checkout) == ""


def told(checkout: Path, *words: str | Path) -> str:
    """Return what a command prints in a checkout."""
    done = subprocess.run([*HARNESS, *map(str, words)], cwd=checkout, capture_output=True,
                          text=True, check=False)  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout + done.stderr


def test_whoever_looks_at_such_fmus_or_packs_them_says_it_once(
    checkout: Path, repo_root: Path
) -> None:
    append(checkout, "src/models/plant.rs")
    plant = sources.FOLDER / "DctPlant.fmu"
    system = repo_root / "examples/closed_loop/paper_case1.toml"
    for words in (
        ("check", plant), ("check", plant, "--against", "plant"), ("doctor", plant),
        ("export-ssp", system, "--out", "x.ssp"), ("export-container", system, "--out", "x.fmu"),
    ):  # fmt: skip
        assert told(checkout, *words).count(SAID) == 1, words
    assert told(checkout, "check", plant, "-q") == ""


PLUGIN = """
def test_loop(closed_loop):
    assert len(closed_loop("s.toml").time) == 11

def test_plant(plant):
    plant.step(0.01)
"""


@pytest.mark.parametrize("old", [True, False])
def test_the_pytest_plugin_warns_of_them(checkout: Path, repo_root: Path, old: bool) -> None:
    loop = repo_root / "examples/closed_loop"
    text = (loop / "paper_case1.toml").read_text().replace('"scenarios/', f'"{loop}/scenarios/')
    (checkout / "s.toml").write_text(text.replace("stop = 30.0", "stop = 0.01"))
    (checkout / "test_it.py").write_text(PLUGIN)
    (checkout / "pytest.ini").write_text("[pytest]\n")
    if old:
        append(checkout, "src/models/plant.rs")
    done = run_pytest("-q", "test_it.py", folder=checkout)
    assert f"2 passed{', 2 warnings' if old else ''} in" in done.stdout, done.stdout
    assert (SAID in done.stdout) == old


@pytest.mark.parametrize(("verb", "quiet", "count"), [
    (("run", "--stop", "0.1"), (), 1), (("run", "--stop", "0.1"), ("-q",), 0),
    (("sweep", "--vary", "plant.vehicle.mass=uniform(1400,1600)", "--runs", "2", "--stop", "0.1"),
     (), 1),
])  # fmt: skip
def test_a_run_and_a_sweep_say_it_once(
    checkout: Path, repo_root: Path, verb: tuple[str, ...], quiet: tuple[str, ...], count: int
) -> None:
    append(checkout, "src/models/plant.rs")
    name, *options = verb
    system, out = repo_root / "examples/closed_loop/paper_case1.toml", checkout / "out"
    words = (name, system, "--fmu-dir", checkout / sources.FOLDER, "--out", out, *options, *quiet)
    done = subprocess.run([*HARNESS, *map(str, words)], cwd=checkout, capture_output=True,
                          text=True, check=False)  # fmt: skip
    assert done.returncode in (0, 1), done.stderr
    assert done.stderr.count(SAID) == count
    if name == "run":
        told = [m for m in results.load(out).run["log"] if SAID in m["message"]]
        assert len(told) == 1
