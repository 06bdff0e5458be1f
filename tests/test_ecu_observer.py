"""The observer as a static C library: what examples/ecu_observer promises to a control unit."""

from __future__ import annotations

import io
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from closed_loop_runs import ROOT, SYSTEMS, Runs
from dct_harness.results import Results
from dct_harness.ssp import calibration
from dct_harness.system import parameters

EXAMPLE = ROOT / "examples" / "ecu_observer"
TARGET = ROOT / "target" / "ecu_observer"
STRICT = ("-O2", "-std=c11", "-Wall", "-Wextra", "-Werror", f"-I{EXAMPLE}")
BARE = ("-ffreestanding", "-nostdlib", "-static", "-Wl,--gc-sections")

METHODS = ("paper", "lyapunov", "energy", "kalman", "calibrating")
COMPONENTS = dict(zip(METHODS, ("observer", *METHODS[1:]), strict=True))  # of the system files
NOMINAL = {"clutch1.nominalFriction": 0.4, "clutch2.nominalFriction": 0.1}  # friction case 1
MEASURED = ("engine.speed", "clutch1.speed", "clutch2.speed", "wheel.speed")
SCRIPTED = ("engine.torque", "road.grade", "brake.torque")
MOVED = {"methods_case1": "position", "methods_wet6": "pressure"}
CORTEX_M4 = ROOT / "target/cross/thumbv7em-none-eabihf/release/libdct_observer.a"
MUSL = ("-target", "arm-linux-musleabihf", "-static")  # passes doubles as the library does
BEGIN = 2001  # rows of the launch that qemu repeats
LEAST = 0.6  # of what is stated: measured on x86-64, rounded up
OUTPUTS = 53  # of dct_estimate with a name of the FMU: all but `fault`
ROWS = {"paper": ("--no-default-features", "--features", "paper"), "all five": ()}  # of the README


def _done(*words: object, **options: object) -> subprocess.CompletedProcess:
    done = subprocess.run([str(w) for w in words], cwd=ROOT, capture_output=True, check=False,
                          text=True, **options)  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done


def _library(folder: Path, *features: str) -> Path:
    """Return the static library, compiled."""
    manifest = EXAMPLE / "Cargo.toml"
    _done("cargo", "build", "--release", "--locked", "--quiet", "--manifest-path", manifest,
          "--target-dir", TARGET, *features)  # fmt: skip
    return Path(shutil.copy(TARGET / "release" / "libdct_observer.a", folder))


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The static library with all methods."""
    return _library(tmp_path_factory.mktemp("library"))


@pytest.fixture(scope="module")
def replay(library: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The C program that replays measurements."""
    program = tmp_path_factory.mktemp("ecu") / "replay"
    _done("cc", *STRICT, EXAMPLE / "replay.c", library, "-o", program)
    return program


@pytest.fixture(scope="module")
def loops(tmp_path_factory: pytest.TempPathFactory) -> Runs:
    """Five FMUs of the observer beside one plant."""
    return Runs(tmp_path_factory.mktemp("loops"))


def _replayed(
    program: Path | str,
    values: dict[str, float],
    table: dict[str, np.ndarray],
    *more: object,
    before: tuple[object, ...] = (),
) -> dict[str, np.ndarray]:
    """Return the estimates of the C program for columns of measurements."""
    rows = np.column_stack(list(table.values())).tolist()
    text = "\n".join([",".join(table), *(",".join(map(repr, row)) for row in rows)])
    words = [f"{name}={float(value)!r}" for name, value in values.items()]
    done = _done(program, *before, *words, *more, input=text + "\n")
    said = np.genfromtxt(io.StringIO(done.stdout), delimiter=",", names=True, deletechars="")
    return {name: said[name] for name in said.dtype.names}


def _measured(loop: Results, moved: str) -> dict[str, np.ndarray]:
    """Return what the observer takes at the end of a step: what is scripted acted over it."""
    scripted = (*SCRIPTED, *(f"clutch{k}.{moved}" for k in (1, 2)), "shaft1.gear", "shaft2.gear")
    columns = {"time": loop.time, **{name: loop[f"plant.{name}"] for name in MEASURED}}
    for name in scripted:
        values = loop[f"scenario.{name}"]
        columns[name] = np.concatenate([values[:1], values[:-1]])
    return columns


@pytest.mark.parametrize("system", MOVED)
def test_the_readmes_measurements_are_what_the_observer_takes(loops: Runs, system: str) -> None:
    loop = loops(system)
    done = _done(sys.executable, EXAMPLE / "measured.py", loops.folder(system))
    said = np.genfromtxt(io.StringIO(done.stdout), delimiter=",", names=True, deletechars="")
    for name, column in _measured(loop, MOVED[system]).items():
        assert np.array_equal(said[name], column), name


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("system", MOVED)
def test_c_and_fmu_give_the_same_bits(replay: Path, loops: Runs, system: str, method: str) -> None:
    """The paper's drive, and another box through three gears; every output of the header."""
    loop = loops(system)
    own = parameters.read(SYSTEMS / "parameters" / "wet6_observer.ssv") if "wet" in system else {}
    wanted = {**own, **NOMINAL, "observer.method": METHODS.index(method) + 1}
    estimates = _replayed(replay, wanted, _measured(loop, MOVED[system]))
    assert len(estimates) == OUTPUTS
    assert np.ptp(estimates["clutch2.torque"]) > 50
    for name, column in estimates.items():
        assert np.array_equal(column, loop[f"{COMPONENTS[method]}.{name}"]), name


@pytest.fixture(scope="module")
def replay_on_arm(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same C program with the library for a Cortex-M4."""
    assert CORTEX_M4.exists(), "cargo xtask platforms builds it"
    program = tmp_path_factory.mktemp("arm") / "replay"
    zig = (sys.executable, "-m", "ziglang", "cc", *MUSL)
    _done(*zig, *STRICT, EXAMPLE / "replay.c", CORTEX_M4, "-o", program)
    return program


@pytest.mark.parametrize("method", METHODS)
def test_code_for_a_cortex_m4_gives_the_same_bits(
    replay: Path, replay_on_arm: Path, loops: Runs, method: str
) -> None:
    """Doubles in software, numbers of 32 bits as sizes: the launch under qemu, every output."""
    table = _measured(loops("methods_case1"), "position")
    begin = {name: column[:BEGIN] for name, column in table.items()}
    wanted = {**NOMINAL, "observer.method": METHODS.index(method) + 1}
    here = _replayed(replay, wanted, begin)
    there = _replayed("qemu-arm", wanted, begin, before=("-cpu", "max", replay_on_arm))
    assert len(there) == OUTPUTS
    assert np.ptp(there["clutch1.torque"]) > 20
    for name, column in there.items():
        assert np.array_equal(column, here[name]), name


def test_counted_speeds_are_followed_where_the_ticks_are_known(replay: Path, loops: Runs) -> None:
    """1024 ticks over 1 ms are steps of 6 rad/s: clutch 1 is missed by less than 6 %.

    Told or recognised; where they cannot be, as no whole ticks are left, by five times as much.
    """
    loop = loops("methods_case1")
    table, tick = _measured(loop, "position"), 2 * np.pi / 1024
    for name in MEASURED:
        counted = np.floor(np.cumsum(table[name][1:] * np.diff(table["time"])) / tick)
        table[name] = np.append(table[name][0], np.diff(counted, prepend=0) * tick / 1e-3)
    ticks = {name.replace("speed", "encoderTicks"): 1024 for name in MEASURED}
    blurred = {**table, **{name: table[name] * (1 + 1e-5 * np.sin(np.arange(len(table[name]))))
                           for name in MEASURED}}  # fmt: skip
    truth = loop["plant.clutch1.torque"]
    known, recognised, blind = (
        np.std(
            _replayed(replay, {**NOMINAL, "observer.method": 4, **told}, seen)["clutch1.torque"]
            - truth
        )
        for told, seen in ((ticks, table), ({}, table), ({}, blurred))
    )
    missed = max(known, recognised)
    assert missed < min(0.2 * blind, 0.06 * np.std(truth)), f"{blind:.2f} -> {missed:.2f} N·m"


def test_what_was_learnt_starts_the_next_drive(replay: Path, loops: Runs, tmp_path: Path) -> None:
    """As `calibration.ssv` has it; a torque that reads 5 % too high is then known at once."""
    loop = loops("methods_case1")
    table, kept = _measured(loop, "position"), tmp_path / "next.txt"
    first = {**NOMINAL, "observer.method": 5}
    _replayed(replay, first, table, "--next", kept)
    assert _kept(kept).items() >= first.items() - NOMINAL.items()
    for name, value in calibration.learnt(loop, "calibrating").items():
        assert _kept(kept)[name] == pytest.approx(value, rel=1e-12), name
    table["engine.torque"] = 1.05 * table["engine.torque"]
    _replayed(replay, first, table, "--next", kept)
    again = _replayed(replay, _kept(kept), table)
    assert again["calibration.torqueScale"][0] == pytest.approx(1 / 1.05 - 1, abs=0.01)


def _kept(path: Path) -> dict[str, float]:
    """Return the parameters that the C program wrote."""
    rows = (line.partition("=") for line in path.read_text().splitlines())
    return {name: float(value) for name, _, value in rows}


def test_a_method_that_does_not_learn_has_nothing_to_keep(replay: Path, tmp_path: Path) -> None:
    words = [replay, "observer.method=4", "--next", tmp_path / "next.txt"]
    done = subprocess.run(words, input="time,engine.speed\n0,90\n0.001,90\n", check=False,
                          capture_output=True, text=True)  # fmt: skip
    assert done.returncode == 1
    assert "nothing was learnt" in done.stderr
    assert not (tmp_path / "next.txt").exists()


def _stated() -> dict[str, list[float]]:
    """Return the footprints in KiB that the README states, by row."""
    rows = (line.strip("| \n").split(" | ") for line in (EXAMPLE / "README.md").open())
    return {cells[0]: [float(cell) for cell in cells[1:]] for cells in rows
            if cells[0] in {*METHODS, "all five"}}  # fmt: skip


@pytest.mark.parametrize("row", ROWS)
def test_the_readme_states_the_code(tmp_path: Path, row: str) -> None:
    """Code with constants of a program that links with nothing else."""
    library, program = _library(tmp_path, *ROWS[row]), tmp_path / "bare_metal"
    _done("cc", *STRICT, *BARE, EXAMPLE / "bare_metal.c", library, "-o", program)
    code, data = (int(n) for n in _done("size", program).stdout.splitlines()[1].split()[:2])
    stated = _stated()[row][0]
    assert LEAST * stated < (code + data) / 1024 <= stated


def test_the_readme_states_the_stack(library: Path, tmp_path: Path) -> None:
    program = tmp_path / "footprint"
    _done("cc", *STRICT, EXAMPLE / "footprint.c", library, "-o", program)
    room, *methods = (line.split(",") for line in _done(program).stdout.split())
    assert room == ["dct_observer", "5616"]
    assert len(methods) == len(METHODS)
    for method, *measured in methods:
        stated = _stated()[METHODS[int(method) - 1]][1:]
        for bytes_used, limit in zip(measured, stated, strict=True):
            assert LEAST * limit < int(bytes_used) / 1024 <= limit, method


def test_a_method_that_was_left_out_is_refused(tmp_path: Path) -> None:
    program = tmp_path / "replay"
    library = _library(tmp_path, *ROWS["paper"])
    _done("cc", *STRICT, EXAMPLE / "replay.c", library, "-o", program)
    done = subprocess.run([program, "observer.method=4"], input="time,engine.speed\n0,90\n",
                          capture_output=True, text=True, check=False)  # fmt: skip
    assert done.returncode == 1
    assert "the observer says 4" in done.stderr


def test_it_links_and_runs_without_system_and_c_library(library: Path, tmp_path: Path) -> None:
    """A symbol of std, of an allocator or of libc would be undefined here: the link would fail."""
    program = tmp_path / "bare_metal"
    _done("cc", *STRICT, *BARE, EXAMPLE / "bare_metal.c", library, "-o", program)
    _done(program)
    symbols = _done("nm", "--demangle", program).stdout
    assert "dct_observer_step" in symbols
    assert [line for line in symbols.splitlines() if "alloc" in line or " std::" in line] == []


def test_every_refusal_is_told_and_changes_nothing(library: Path, tmp_path: Path) -> None:
    program = tmp_path / "refusals"
    source = Path(__file__).parent / "ecu_refusals.c"
    _done("cc", *STRICT, source, library, "-o", program)
    assert _done(program).stdout == "as promised\n"
