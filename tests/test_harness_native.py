"""`--engine native`: the compiled master gives the numbers of the fmpy loop, to the last bit."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import cosim_native
import numpy as np
import pytest
from dct_harness import results
from dct_harness.errors import instant
from harness_fixture.lag_fmu import HARNESS, LAG, run, run_out_of_time, write_fmu, write_system

NATIVE = ("--engine", "native")
CRASH, HANG = 1, 2  # modes of the hostile FMU, from t = 0.1 s on


@pytest.mark.parametrize(("system", "more"), [
    ("torque_tracking_case1", ("--stop", "5", "--set", "observer.observer.method=calibrating")),
    ("launch_wet6", ("--step", "0.01")),
])  # fmt: skip
def test_both_engines_give_the_same_bits(
    tmp_path: Path, repo_root: Path, system: str, more: tuple[str, ...]
) -> None:
    told = []
    for engine in ("fmpy", "native"):
        out = tmp_path / engine
        words = ("run", f"examples/closed_loop/{system}.toml", "--out", out, "--engine", engine)
        done = subprocess.run([*HARNESS, *map(str, words), "-q", *more], cwd=repo_root,
                              capture_output=True, text=True, check=False)  # fmt: skip
        assert done.returncode in (0, 1), done.stderr
        told.append((done.returncode, results.load(out)))
    (codes, loops) = zip(*told, strict=True)
    assert codes[0] == codes[1]
    assert list(loops[0].signals) == list(loops[1].signals)
    for name, signal in loops[0].signals.items():
        assert np.array_equal(signal, loops[1][name]), name
    assert loops[0]["plant.vehicle.speed"][-1] > 0.1
    for part in ("parameters", "events", "wiring", "fmus"):
        assert loops[0].run[part] == loops[1].run[part], part
    times = [loop.run["wall_time"] for loop in loops]
    assert set(times[0]) == set(loops[0].run["fmus"])
    assert not times[1]  # it is not measured there, and nothing takes 0 s


def test_a_foreign_fmu_runs_in_another_process(tmp_path: Path, hostile: Path) -> None:
    rows = []
    for engine in ("fmpy", "native"):
        done = run(write_system(tmp_path), hostile, "--engine", engine)
        assert done.returncode == 0, done.stderr
        rows.append(results.load(tmp_path / "out")["plant.x"])
    assert np.array_equal(*rows)
    assert len(rows[0]) == 1001


@pytest.mark.parametrize(("value", "code", "said"), [
    (f"plant.mode={CRASH}", 4, "the process of the native loop ended with signal 11; run it with"),
    (f"plant.mode={HANG}", 5, "a step of the native loop took longer than 1 s (--call-timeout)"),
])  # fmt: skip
def test_a_foreign_fmu_that_misbehaves_is_an_error(
    tmp_path: Path, hostile: Path, value: str, code: int, said: str
) -> None:
    options = ("--set", value, *(("--call-timeout", "1") if code == 5 else ()))
    done = run(write_system(tmp_path), hostile, *NATIVE, *options)
    assert done.returncode == code, done.stderr
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert len(results.load(tmp_path / "out").time) == 101  # from t = 0.1 s on it misbehaves


@pytest.mark.parametrize("isolate", ["none", "foreign"])
def test_rows_before_a_call_that_never_returns_are_kept(
    tmp_path: Path, hostile: Path, isolate: str
) -> None:
    options = ("--set", f"plant.mode={HANG}", "--isolate", isolate)
    done = run_out_of_time(write_system(tmp_path), hostile, *NATIVE, *options)
    assert done.returncode == 5, done.stderr
    assert "an FMU does not return" in done.stderr
    kept = results.load(tmp_path / "out")
    assert (len(kept.time), kept.run["status"]) == (101, "partial")


@pytest.mark.parametrize(("value", "said", "rows"), [
    ("plant.nanAt=0.5", "plant.x is NaN at t = 0.501 s: no finite number", 501),
    ("plant.failAt=0.25", "plant: fmi2DoStep at t = 0.25 s returned", 251),
])  # fmt: skip
@pytest.mark.parametrize("isolate", ["none", "foreign"])
def test_rows_before_a_failure_are_kept(
    tmp_path: Path, lag_dir: Path, value: str, said: str, rows: int, isolate: str
) -> None:
    done = run(write_system(tmp_path), lag_dir, *NATIVE, "--set", value, "--isolate", isolate)
    assert done.returncode == 4, done.stderr
    assert said in done.stderr
    kept = results.load(tmp_path / "out")
    assert len(kept.time) == rows
    assert kept.run["status"] == "partial"


@pytest.mark.parametrize("isolate", ["none", "foreign"])
@pytest.mark.parametrize("module", ["None", "__import__('types').ModuleType('of_before')"])
def test_a_module_that_is_missing_or_old_is_told_with_its_remedy(
    tmp_path: Path, lag_dir: Path, module: str, isolate: str
) -> None:
    system = write_system(tmp_path)
    script = (
        f"import sys; sys.modules['cosim_native'] = {module}; "
        "from dct_harness.cli import main; sys.exit(main())"
    )
    words = ("run", system, "--fmu-dir", lag_dir, "--isolate", isolate, "--out", tmp_path / "o")
    command = [HARNESS[0], "-c", script, *map(str, words), *NATIVE]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2, done.stderr
    assert "`cargo xtask native` builds it" in done.stderr
    assert not (tmp_path / "o").exists()


def lag_plan(fmus: Path, **start: float) -> str:
    """Return a loop of the lag alone as `cosim_native` takes it."""
    feeds = {"name": "u", "source": "scenario.u"}
    part = {"name": "plant", "fmu": str(fmus / "Lag.fmu"), "inputs": [feeds],
            "start": list(start.items())}  # fmt: skip
    return json.dumps({"components": [part], "script": ["u"]})


TIMES, SCRIPT = 1e-3 * np.arange(1001), np.full((1001, 1), 2.0)


def test_rows_lie_in_given_arrays_and_fmus_stay_open(lag_dir: Path, tmp_path: Path) -> None:
    fmus, unpacked = cosim_native.Fmus(tmp_path), []
    for _ in range(2):
        out = [np.full((1001, 2), np.nan) for _ in range(2)]
        made = cosim_native.run([lag_plan(lag_dir)] * 2, TIMES, SCRIPT, 2, out=out, fmus=fmus)
        pairs = zip((rows for _, rows, *_ in made), out, strict=True)
        assert all(np.shares_memory(*pair) for pair in pairs)
        ((_, alone, *_),) = cosim_native.run([lag_plan(lag_dir)], TIMES, SCRIPT)
        assert all(np.array_equal(alone, rows) for _, rows, *_ in made)
        unpacked.append(sorted(tmp_path.iterdir()))
    assert len(unpacked[0]) == 1
    assert unpacked[0] == unpacked[1]
    del fmus
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("shape", [(1000, 2), (1001, 1), (1001, 3)])
def test_arrays_of_another_shape_are_refused(lag_dir: Path, shape: tuple[int, int]) -> None:
    with pytest.raises(ValueError, match="a row for each time, a column for each name"):
        cosim_native.run([lag_plan(lag_dir)], TIMES, SCRIPT, out=[np.zeros(shape)])


def test_a_watch_ends_runs_or_raises(lag_dir: Path) -> None:
    slow, seen = lag_plan(lag_dir, delay=0.002), []

    def watch(steps: int) -> bool:
        seen.append(steps)
        return steps > 100

    ((_, rows, error, _),) = cosim_native.run([slow], TIMES, SCRIPT, watch=watch)
    assert error == ("ended", f"stopped at t = {instant(TIMES[len(rows) - 1])} s")
    assert 100 < seen[-1] < len(rows) < 1001
    assert seen == sorted(seen)
    with pytest.raises(ZeroDivisionError):
        cosim_native.run([slow], TIMES, SCRIPT, watch=lambda steps: 1 / 0)


@pytest.mark.parametrize("engine", ["fmpy", "native"])
def test_a_discrete_real_input_is_held_between_rows(
    tmp_path: Path, lag_library: Path, engine: str
) -> None:
    """FMI lets it change at events only: a ramp between two rows of the scenario would be many."""
    discrete = LAG[0].replace("><Real", ' variability="discrete"><Real')
    write_fmu(tmp_path / "Lag.fmu", lag_library, (discrete, *LAG[1:]))
    system = write_system(tmp_path, scenario="time,u\n0,1\n0.5,3\n1,5\n")
    done = run(system, tmp_path, "--engine", engine)
    assert done.returncode == 0, done.stderr
    found = results.load(tmp_path / "out")
    expected = [1.0 if t < 0.5 else 3.0 if t < 1 else 5.0 for t in found.time]
    assert found["scenario.u"].tolist() == expected
