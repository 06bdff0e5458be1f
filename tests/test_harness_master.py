"""The master's options: Jacobi, substeps, named delays and loops, step check, range guard."""

from __future__ import annotations

import json
import re
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from dct_harness import results
from dct_harness.fmu.ports import feedthrough
from dct_harness.master.coupling import algebraic_loops, delayed
from fmpy.model_description import ModelDescription, ScalarVariable, Unknown
from harness_fixture.lag_fmu import LAG, run, variable, write_fmu

STEP = 0.01  # s
MANY = 2000  # inputs, and outputs
SYSTEM = """[system]
name = "two"
step = 0.01
stop = 1.0
scenario = "s.csv"
coupling = "{coupling}"
[components.first]
fmu = "Lag.fmu"
[components.second]
fmu = "Lag.fmu"
{more}
[[connections]]
from = "second.x"
to = "first.u"
[[connections]]
from = "first.x"
to = "second.u"
"""


def two(folder: Path, coupling: str, more: str = "") -> Path:
    """Write a system of two lags, each fed by the other; the second one starts at 1."""
    (folder / "s.csv").write_text("time,none\n0,0\n")
    (folder / "s.toml").write_text(SYSTEM.format(coupling=coupling, more=more))
    return folder / "s.toml"


def expected(coupling: str, count: int, step: float = STEP) -> np.ndarray:
    """Return x of both lags, shape (count, 2): exact answers to a held input, coupled by hand."""
    decay, x = np.exp(-step), np.array([0.0, 1.0])
    found = [x.copy()]
    for _ in range(count - 1):
        old = x.copy()
        x[0] = old[1] + (old[0] - old[1]) * decay
        feed = old[0] if coupling == "jacobi" else x[0]
        x[1] = feed + (old[1] - feed) * decay
        found.append(x.copy())
    return np.array(found)


@pytest.mark.parametrize("coupling", ["gauss-seidel", "jacobi"])
def test_the_order_of_coupling_is_what_it_is_called(
    tmp_path: Path, lag_dir: Path, coupling: str
) -> None:
    done = run(two(tmp_path, coupling), lag_dir, "-v", "--set", "second.x=1.0")
    assert done.returncode == 0, done.stderr
    found = results.load(tmp_path / "out")
    x = np.column_stack([found["first.x"], found["second.x"]])
    assert np.max(np.abs(x - expected(coupling, len(x)))) < 1e-12
    assert f"coupling: {coupling}\n" in done.stderr
    late = re.findall(r"one step late: (\S+) -> (\S+)", done.stderr)
    first = [("second.x", "first.u")]
    assert late == (first if coupling == "gauss-seidel" else [*first, ("first.x", "second.u")])


def test_substeps_divide_the_step_of_one_component(tmp_path: Path, lag_library: Path) -> None:
    """`doStep` of the fixture doubles n into m at each call: a step of its own is exact anyway."""
    write_fmu(tmp_path / "Lag.fmu", lag_library)
    done = run(two(tmp_path, "jacobi", "substeps = 4"), tmp_path, "--set", "second.failAt=0.5049")
    assert done.returncode == 4
    assert "second: fmi2DoStep at t = 0.505 s" in done.stderr  # a multiple of 2.5 ms, not of 10 ms
    assert results.load(tmp_path / "out").run["reached"] == 0.5


def test_half_the_step_tells_what_the_coupling_costs(tmp_path: Path, lag_dir: Path) -> None:
    verdicts = []
    for limit in ("0.0001", "5"):
        done = run(two(tmp_path, "jacobi"), lag_dir, "--set", "second.x=1.0", "--check-step", limit)
        verdicts.append((done.returncode, done.stdout.splitlines()[-1]))
    assert verdicts == [(1, "verdict: the step is too long"),
                        (0, "verdict: the step is small enough")]  # fmt: skip
    told = json.loads((tmp_path / "out/check_step.json").read_text())
    (first, second) = sorted(told["changes"], key=lambda c: c["signal"])
    coarse, fine = expected("jacobi", 101), expected("jacobi", 201, STEP / 2)[::2]
    for k, change in enumerate((first, second)):
        wanted = 100 * np.linalg.norm(coarse[:, k] - fine[:, k]) / np.linalg.norm(coarse[:, k])
        assert change["percent"] == pytest.approx(wanted, rel=1e-6)


class _Fmu:
    def __init__(self, feedthrough: dict[str, set[str]]) -> None:
        self._known = feedthrough

    def feedthrough(self) -> dict[str, set[str]]:
        return self._known


@pytest.mark.parametrize(("second", "loops"), [
    ({"y": {"u"}}, [["a.u", "a.y", "b.u", "b.y"]]),
    ({"y": set()}, []),
])  # fmt: skip
def test_only_a_loop_without_a_state_is_algebraic(
    second: dict[str, set[str]], loops: list[list[str]]
) -> None:
    fmus = {"a": _Fmu({"y": {"u"}}), "b": _Fmu(second)}
    assert algebraic_loops(fmus, {"a.u": "b.y", "b.u": "a.y"}) == loops


def test_who_depends_on_whom_takes_no_more_than_the_description_says() -> None:
    inputs = [ScalarVariable(f"u{k}", k, causality="input") for k in range(MANY)]
    outputs = [ScalarVariable(f"y{k}", k, causality="output") for k in range(MANY)]
    told = ModelDescription(modelVariables=[*inputs, *outputs])
    told.outputs = [Unknown(variable=v) for v in outputs]
    tracemalloc.start()
    known = feedthrough(told)
    loops = algebraic_loops({"a": _Fmu(known)}, {"a.u0": "a.y1", "a.u1": "b.y"})
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert known["y7"] == {v.name for v in inputs}
    assert loops == [["a.u0", "a.y1"]]
    assert peak < MANY * 1000  # bytes; a set of its own for every output takes MANY² · 32


def test_a_component_that_feeds_itself_is_late_in_any_order() -> None:
    wires = {"a.u": "a.y", "b.u": "a.y", "a.v": "scenario.v"}
    assert delayed(["a", "b"], wires, "gauss-seidel") == [{"from": "a.y", "to": "a.u"}]


def test_an_output_out_of_its_range_is_told(tmp_path: Path, lag_library: Path) -> None:
    bounded = variable("x", 1, "output").replace("<Real/>", '<Real max="0.5"/>')
    write_fmu(tmp_path / "Lag.fmu", lag_library, (LAG[0], bounded, *LAG[2:]))
    done = run(two(tmp_path, "jacobi"), tmp_path, "-v", "--set", "second.x=1.0")
    assert done.returncode == 0, done.stderr
    assert "second [range] x = 1.0 is out of its range [-inf, 0.5], " in done.stderr
