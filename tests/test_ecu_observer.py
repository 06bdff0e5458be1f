"""The observer as a static C library: what examples/ecu_observer promises to a control unit."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest
from closed_loop_runs import ROOT, run
from dct_harness.results import Results

EXAMPLE = ROOT / "examples" / "ecu_observer"
TARGET = ROOT / "target" / "ecu_observer"
LIBRARY = TARGET / "release" / "libdct_observer.a"
STRICT = ("-O2", "-std=c11", "-Wall", "-Wextra", "-Werror", f"-I{EXAMPLE}")

STEP = 1e-3  # s, of the system file
VEHICLE = {"vehicle.wheelInertia": 140.0, "clutch2.effectiveRadius": 0.1}  # not those of Table 1
NOMINAL = (0.4, 0.1)  # friction case 1
FLASH = 64 * 1024  # bytes of code and constants that a small control unit has to spare
MEASURED = (
    "time", "engine.torque", "engine.speed", "clutch1.speed", "clutch2.speed",
    "wheel.speed", "clutch1.position", "clutch2.position", "road.grade",
)  # fmt: skip
ESTIMATED = (
    "clutch1.torque", "clutch2.torque", "driveShaft.torque", "clutch1.friction",
    "clutch2.friction", "clutch1.engaged", "clutch2.engaged", "status.valid",
)  # fmt: skip


def _done(*words: object, **options: object) -> subprocess.CompletedProcess:
    done = subprocess.run([str(w) for w in words], cwd=ROOT, capture_output=True, check=False,
                          text=True, **options)  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done


@pytest.fixture(scope="module")
def library() -> Path:
    """The static library, compiled."""
    manifest = EXAMPLE / "Cargo.toml"
    _done("cargo", "build", "--release", "--locked", "--quiet", "--manifest-path", manifest,
          "--target-dir", TARGET)  # fmt: skip
    return LIBRARY


@pytest.fixture(scope="module")
def replay(library: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The C program that replays measurements."""
    program = tmp_path_factory.mktemp("ecu") / "replay"
    _done("cc", *STRICT, EXAMPLE / "replay.c", library, "-o", program)
    return program


def _replayed(program: Path, rows: np.ndarray) -> np.ndarray:
    """Return the estimates for rows of `MEASURED`, shape (rows, len(ESTIMATED))."""
    text = "\n".join(",".join(map(repr, row)) for row in rows.tolist())
    settings = (*NOMINAL, *VEHICLE.values())
    done = _done(program, *settings, input=text + "\n")
    return np.array([line.split(",") for line in done.stdout.split()], dtype=float)


def _measured(loop: Results, name: str) -> np.ndarray:
    """Return a signal as the observer takes it at the end of a step."""
    if f"scenario.{name}" not in loop:
        return loop.time if name == "time" else loop[f"plant.{name}"]
    scripted = loop[f"scenario.{name}"]
    return np.concatenate([scripted[:1], scripted[:-1]])


def test_c_and_fmu_give_the_same_bits(replay: Path, tmp_path: Path) -> None:
    """30 s of the paper's scenario; torque, positions and grade act over the step that ends."""
    settings = tuple(f"observer.{name}={value}" for name, value in VEHICLE.items())
    loop = run("paper_case1", settings, tmp_path)
    estimates = _replayed(replay, np.column_stack([_measured(loop, name) for name in MEASURED]))
    assert len(estimates) == 30 / STEP + 1
    for name, column in zip(ESTIMATED, estimates.T, strict=True):
        assert np.array_equal(column, loop[f"observer.{name}"]), name


def test_it_links_and_runs_without_system_and_c_library(library: Path, tmp_path: Path) -> None:
    """A symbol of std, of an allocator or of libc would be undefined here: the link would fail."""
    program = tmp_path / "bare_metal"
    bare = ("-ffreestanding", "-nostdlib", "-static", "-Wl,--gc-sections")
    _done("cc", *STRICT, *bare, EXAMPLE / "bare_metal.c", library, "-o", program)
    _done(program)
    symbols = _done("nm", "--demangle", program).stdout
    assert "dct_observer_step" in symbols
    assert [line for line in symbols.splitlines() if "alloc" in line or " std::" in line] == []
    code, data = (int(n) for n in _done("size", program).stdout.splitlines()[1].split()[:2])
    assert code + data < FLASH


def test_every_refusal_is_told_and_changes_nothing(library: Path, tmp_path: Path) -> None:
    program = tmp_path / "refusals"
    source = Path(__file__).parent / "ecu_refusals.c"
    _done("cc", *STRICT, source, library, "-o", program)
    assert _done(program).stdout == "as promised\n"
