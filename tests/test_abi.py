"""A C importer (`tests/abi`) against each FMU's library: one case per process.

A crash, a hang or a word on stdout or stderr is a failed case.
"""

from __future__ import annotations

import subprocess
import zipfile
from functools import cache
from pathlib import Path
from typing import NamedTuple

import fmpy
import pytest
from importer_cases import MODELS, fmu

ROOT = Path(__file__).resolve().parent.parent
ABI = ROOT / "tests" / "abi"
HEADERS = Path(fmpy.__file__).parent / "c-code"
BUILT = ROOT / "target" / "abi"
PROBE = "Probe"
TIMEOUT = 1200  # s, for cases that take at most some 10

# Lives that begin from nothing: 100,000 of the plant, whose propagators are made anew, take 20 s.
CYCLES = {PROBE: 1_000_000, "DctPlant": 10_000, "DctObserver": 10_000, "DctClutchControl": 100_000}
# Lives beside an instance that keeps what they share.
CYCLES_BESIDE = 1_000_000
LOADS = 5000
CASES = ("every_function", "without_logger", "threads", "untouched", "freed", "foreign",
         "called_back", "shared", "extremes", "corrupted", "importers", "wanders",
         "states_travel", "states_shared", "called_elsewhere")  # fmt: skip
# Stack of the calling thread [KiB].
STACK = 32
# Under valgrind: those that free, refuse and copy.
CHECKED = ("every_function", "freed", "foreign", "called_back", "corrupted", "importers")

every_library = pytest.mark.parametrize("model", [PROBE, *MODELS])


class Library(NamedTuple):
    """A library, its GUID, an input with a legal value, an output, a fixed parameter."""

    path: Path
    guid: str
    input: str
    references: tuple[int, int, int]
    value: float


# Input, output, fixed parameter, legal value of the input [its unit].
VARIABLES = {
    "DctPlant": ("engine.torque", "engine.speed", "engine.inertia", 60.0),
    "DctObserver": ("engine.torque", "innovation.x1", "engine.inertia", 60.0),
    "DctClutchControl": ("clutch1.torqueRequest", "clutch1.position", "clutch1.rateLimit", 40.0),
}


@cache
def library(model: str) -> Library:
    return _probe() if model == PROBE else _unpacked(model)


@cache
def small(model: str) -> Library:
    """Return it as `cargo fmu build --small` builds it."""
    folder = ROOT / "target" / "small"
    folder.mkdir(parents=True, exist_ok=True)
    ours = library(model)
    if model == PROBE:
        path = folder / "libabi_probe.so"
        _example("small", path)
        return ours._replace(path=path)
    build = ["cargo", "fmu", "build", "--small", model, "--out", folder]
    subprocess.run(build, cwd=ROOT, check=True)
    return ours._replace(path=_extracted(folder / f"{model}.fmu", folder))


def _extracted(path: Path, folder: Path) -> Path:
    with zipfile.ZipFile(path) as archive:
        return Path(archive.extract(f"binaries/linux64/{path.stem}.so", folder))


def _unpacked(model: str) -> Library:
    path = _extracted(fmu(model), BUILT)
    description = fmpy.read_model_description(str(fmu(model)))
    known = {v.name: v.valueReference for v in description.modelVariables}
    *names, value = VARIABLES[model]
    return Library(path, description.guid, names[0], tuple(known[name] for name in names), value)


def _probe() -> Library:
    build = ["cargo", "build", "--quiet", "--release", "-p", "abi-probe", "--lib"]
    subprocess.run(build, cwd=ROOT, check=True)
    folder = ROOT / "target" / "release"
    path = folder / "libabi_probe.so"
    return Library(path, _example("guid").strip(), "u", (0, 1, 2), 3.0)


def _example(name: str, *words: str | Path) -> str:
    run = ["cargo", "run", "--quiet", "-p", "abi-probe", "--example", name, "--", *words]
    return subprocess.run(run, cwd=ROOT, capture_output=True, check=True, text=True).stdout


@cache
def host(*more: str) -> Path:
    """Return the C importer, compiled, perhaps with more flags."""
    BUILT.mkdir(parents=True, exist_ok=True)
    program = BUILT / "".join(["abi", *more])
    flags = ["-std=gnu11", "-D_GNU_SOURCE", "-Wall", "-Wextra", "-Werror", "-O1", "-g", "-pthread",
             *more]  # fmt: skip
    sources = sorted(ABI.glob("*.c"))
    command = ["cc", *flags, f"-I{HEADERS}", *sources, "-o", program, "-ldl", "-lm"]
    subprocess.run(command, check=True)
    return program


def arguments(library: Library, *words: str | Path) -> list[str]:
    """Return the importer's command line: the library, what it needs to know of it, the case."""
    known = (library.path, library.guid, *library.references, library.value)
    return [str(word) for word in (*known, *words)]


def _run(
    model: str, *words: str | Path, under: tuple[str, ...] = (), build: Library | None = None
) -> None:
    command = [*under, host(), *arguments(build or library(model), *words)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


@every_library
@pytest.mark.parametrize("case", CASES)
def test_c_importer(model: str, case: str) -> None:
    _run(model, case)


@pytest.mark.parametrize("model", ["DctPlant", "DctObserver"])
def test_a_step_that_is_too_long_may_be_tried_again_shorter(model: str) -> None:
    _run(model, "too_long")


@every_library
def test_log_messages_are_finished_sentences(model: str) -> None:
    _run(model, "messages", library(model).input)


@every_library
def test_little_stack_is_enough(model: str) -> None:
    _run(model, "small_stack", str(STACK))


def test_a_panic_is_fatal_and_silent() -> None:
    _run(PROBE, "panics")


def test_a_panic_in_a_small_library_is_fatal_and_silent() -> None:
    assert small(PROBE).path.read_bytes() != library(PROBE).path.read_bytes()
    _run(PROBE, "panics", build=small(PROBE))


@every_library
def test_lives_leave_nothing_behind(model: str) -> None:
    _run(model, "cycles", str(CYCLES[model]))


@every_library
def test_lives_beside_another_leave_nothing_behind(model: str) -> None:
    _run(model, "cycles_beside", str(CYCLES_BESIDE))


@every_library
def test_loading_and_unloading_leaves_nothing_behind(model: str) -> None:
    _run(model, "loads", str(LOADS))


@every_library
def test_a_saved_state_resumes_in_another_process_on_a_bare_instance(
    model: str, tmp_path: Path
) -> None:
    _run(model, "save", tmp_path / "state")
    _run(model, "resume", tmp_path / "state")


@cache
def rebuilt() -> Path:
    """Return the folder of the same libraries out of another build: other flags, other code."""
    packages = ("abi-probe", "dct-plant", "dct-observer", "dct-clutch-control")
    chosen = [word for package in packages for word in ("-p", package)]
    subprocess.run(["cargo", "build", "--quiet", *chosen, "--lib"], cwd=ROOT, check=True)
    return ROOT / "target" / "debug"


@every_library
def test_a_saved_state_resumes_in_another_build_with_the_same_bits(
    model: str, tmp_path: Path
) -> None:
    released = library(model)
    name = "abi_probe" if model == PROBE else model
    other = released._replace(path=rebuilt() / f"lib{name}.so")
    assert other.path.read_bytes() != released.path.read_bytes()
    _run(model, "save", tmp_path / "state")
    _run(model, "resume", tmp_path / "state", build=other)


@pytest.mark.parametrize("model", [PROBE, "DctPlant"])
def test_a_saved_state_resumes_in_a_small_library_with_the_same_bits(
    model: str, tmp_path: Path
) -> None:
    assert small(model).path.stat().st_size < 0.7 * library(model).path.stat().st_size
    _run(model, "save", tmp_path / "state")
    _run(model, "resume", tmp_path / "state", build=small(model))


@every_library
@pytest.mark.parametrize("case", CHECKED)
def test_valgrind_finds_nothing(model: str, case: str) -> None:
    memcheck = ("valgrind", "--quiet", "--error-exitcode=9", "--leak-check=full",
                "--errors-for-leak-kinds=definite,indirect")  # fmt: skip
    _run(model, case, under=memcheck)
