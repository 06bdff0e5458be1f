"""Initial values: passed on by dependency, loops solved, what does not settle is named."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from dct_harness import graph, results
from dct_harness.master.initial import Initialization, Member, edges
from dct_harness.system.transforms import Conversion
from harness_fixture.lag_fmu import run, variable, write_fmu

DIRECT = (
    variable("u", 0, "input", "0"), variable("y", 9, "output"),
    variable("gain", 10, "parameter", "0"), variable("bias", 11, "parameter", "0"),
)  # fmt: skip
SYSTEM = """[system]
name = "loop"
step = 0.01
stop = 0.01
scenario = "s.csv"
[components.a]
fmu = "Direct.fmu"
parameters = {{gain = {0}, bias = 1.0}}
[components.b]
fmu = "Direct.fmu"
parameters = {{gain = {1}, bias = 2.0}}
[[connections]]
from = "b.y"
to = "a.u"
[[connections]]
from = "a.y"
to = "b.u"
"""


def loop(folder: Path, library: Path, gains: tuple[float, float]) -> Path:
    """Write a system of y = gain u + bias twice, each fed by the other."""
    write_fmu(folder / "Direct.fmu", library, DIRECT)
    (folder / "s.csv").write_text("time,none\n0,0\n")
    (folder / "s.toml").write_text(SYSTEM.format(*gains))
    return folder / "s.toml"


@pytest.mark.parametrize("engine", ["fmpy", "native"])
@pytest.mark.parametrize("gains", [(0.5, 0.25), (0.5, -3.0), (-2.0, 4.0)])
def test_an_algebraic_loop_starts_at_its_solution(
    tmp_path: Path, lag_library: Path, gains: tuple[float, float], engine: str
) -> None:
    """Also where passing the values around would run away: |product of the gains| > 1."""
    done = run(loop(tmp_path, lag_library, gains), tmp_path, "--engine", engine)
    assert done.returncode == 0, done.stderr
    found = results.load(tmp_path / "out")
    a, b = gains
    wanted = np.array([(1 + 2 * a) / (1 - a * b), (2 + b) / (1 - a * b)])
    assert np.array([found["a.y"][0], found["b.y"][0]]) == pytest.approx(wanted, rel=1e-9)
    assert found.run["coupling"]["loops"] == [["a.u", "a.y", "b.u", "b.y"]]


def test_a_loop_without_solution_is_named(tmp_path: Path, lag_library: Path) -> None:
    done = run(loop(tmp_path, lag_library, (1.0, 1.0)), tmp_path)
    assert done.returncode == 4
    assert "an algebraic loop do not settle: a.u -> a.y -> b.u -> b.y; give one" in done.stderr


class _Adder:
    """y = u + 1 at once; counts how often its input is set."""

    def __init__(self, values: np.ndarray, output: np.ndarray) -> None:
        self.inputs = [SimpleNamespace(name="u", start="0")][: len(values)]
        self.outputs = [SimpleNamespace(name="y")]
        self._u, self._y, self.count = values, output, 0

    def feedthrough(self, initial: bool) -> dict[str, set[str]]:
        return {"y": {"u"}} if initial else {}

    def set_inputs(self) -> None:
        self.count += 1

    def get_outputs(self) -> None:
        self._y[0] = self._u.sum() + 1


def test_a_chain_in_the_wrong_order_is_passed_once() -> None:
    count = 200
    world = np.zeros(count)
    sources = {f"c{k}.u": f"c{k + 1}.y" for k in range(count - 1)}  # the last one comes first
    members = {}
    for k in range(count):
        values = np.zeros(1 if k < count - 1 else 0)
        convert = Conversion(f"c{k}", ["u"], {})
        adder = _Adder(values, world[k : k + 1])
        members[f"c{k}"] = Member(adder, np.array([k + 1]), values, convert)
    levels = graph.levels(edges({name: m.fmu for name, m in members.items()}, sources))
    Initialization(members, levels, world).settle()
    assert world.tolist() == list(range(count, 0, -1))
    assert [m.fmu.count for m in members.values()] == [1] * (count - 1) + [0]


@pytest.mark.parametrize(("edges", "levels"), [
    ({}, []),
    ({"a": {"b"}, "c": {"b"}}, [[["a"], ["c"]], [["b"]]]),
    ({"a": {"b"}, "b": {"a", "c"}, "c": {"d"}, "d": {"c"}}, [[["a", "b"]], [["c", "d"]]]),
    ({"a": {"a"}}, [[["a"]]]),
    ({"a": {"b", "c"}, "b": {"c"}, "c": set()}, [[["a"]], [["b"]], [["c"]]]),
])  # fmt: skip
def test_parts_come_after_what_they_need(
    edges: dict[str, set[str]], levels: list[list[list[str]]]
) -> None:
    assert [sorted(level) for level in graph.levels(edges)] == levels


def test_parts_of_a_long_ring_are_found_without_a_deep_stack() -> None:
    ring = {str(k): {str((k + 1) % 5000)} for k in range(5000)}
    assert graph.loops(ring) == [sorted(ring)]
    del ring["0"]
    assert graph.loops(ring) == []
