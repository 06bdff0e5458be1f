"""Connections of a system: sources found, refused, and carried over without change."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from dct_harness import results
from harness_fixture.lag_fmu import LAG, PARAMETERS, run, variable, write_fmu, write_system

WHOLE = (variable("n", 0, "input", "0", "Integer"), variable("m", 1, "output", None, "Integer"))
LOGICAL = (variable("b", 0, "input", "0", "Boolean"), variable("c", 1, "output", None, "Boolean"))
SECOND = '[components.observer]\nfmu = "Second.fmu"\n'
LINK = '[[connections]]\nfrom = "{}"\nto = "{}"\n'


def pair(folder: Path, library: Path, second: tuple[str, ...], connections: str) -> Path:
    """Write the lag as plant, a lag with other variables as observer, and a system of both."""
    write_fmu(folder / "Lag.fmu", library, (*LAG, *WHOLE, *LOGICAL))
    write_fmu(folder / "Second.fmu", library, second)
    system = write_system(folder, "0.01", "time,u,n,b\n0,2,3,1\n0.0045,4,-5,0\n")
    system.write_text(system.read_text() + SECOND + connections)
    return system


def refused(system: Path) -> str:
    """Return the sentence with which a system is refused."""
    done = run(system, system.parent)
    assert done.returncode == 2, done.stderr
    return done.stderr


@pytest.mark.parametrize(("source", "target", "hint"), [
    ("plant.y", "observer.v", "no 'plant.y'. Did you mean 'plant.x'?"),
    ("plant.x", "observer.w", "no 'observer.w'. Did you mean 'observer.v'?"),
    ("scenario.uu", "observer.v", "no 'scenario.uu'. Did you mean 'scenario.u'?"),
    ("plant.tau", "observer.v", "no 'plant.tau'."),  # a parameter is no signal
])  # fmt: skip
def test_unknown_end_is_refused_with_the_nearest_name(
    tmp_path: Path, lag_library: Path, source: str, target: str, hint: str
) -> None:
    second = (variable("v", 0, "input", "0"), variable("w1", 1, "output"))
    assert hint in refused(pair(tmp_path, lag_library, second, LINK.format(source, target)))


@pytest.mark.parametrize(("source", "target"), [
    ("plant.x", "observer.k"), ("plant.x", "observer.l"), ("plant.m", "observer.v"),
    ("plant.c", "observer.v"), ("plant.m", "observer.l"), ("plant.c", "observer.k"),
])  # fmt: skip
def test_types_of_a_connection_must_match(
    tmp_path: Path, lag_library: Path, source: str, target: str
) -> None:
    kinds = {"v": "Real", "k": "Integer", "l": "Boolean"}
    second = (variable(target[-1], 0, "input", "0", kinds[target[-1]]),)
    said = refused(pair(tmp_path, lag_library, second, LINK.format(source, target)))
    assert f"'{source}' is" in said
    assert f"but '{target}' is {kinds[target[-1]]}" in said


@pytest.mark.parametrize(("kind", "cell"), [("Integer", "1.5"), ("Boolean", "2")])
def test_scenario_cell_that_an_input_cannot_take_is_refused(
    tmp_path: Path, lag_library: Path, kind: str, cell: str
) -> None:
    write_fmu(tmp_path / "Lag.fmu", lag_library, (variable("k", 0, "input", "0", kind),))
    said = refused(write_system(tmp_path, "1.0", f"time,k\n0,1\n0.25,{cell}\n"))
    assert f"column 'k' is {float(cell)} at t = 0.25 s, but 'plant.k' is {kind}" in said


def test_input_without_source_names_the_remedies(tmp_path: Path, lag_library: Path) -> None:
    write_fmu(tmp_path / "Lag.fmu", lag_library)
    said = refused(write_system(tmp_path, "1.0", "time,v\n0,1\n"))
    assert "'plant.u' has no source: add a column 'u'" in said
    assert "A plant with names of its own needs --map" in said


def test_equal_name_of_two_components_must_be_chosen(tmp_path: Path, lag_library: Path) -> None:
    third = '[components.third]\nfmu = "Third.fmu"\n'
    write_fmu(tmp_path / "Third.fmu", lag_library, (variable("x", 0, "input", "0"),))
    second = (variable("x", 1, "output"),)
    said = refused(pair(tmp_path, lag_library, second, third))
    assert "'third.x' has several sources (plant.x, observer.x)" in said


def test_two_sources_of_one_input_are_refused(tmp_path: Path, lag_library: Path) -> None:
    twice = LINK.format("plant.x", "observer.v") + LINK.format("scenario.u", "observer.v")
    said = refused(pair(tmp_path, lag_library, (variable("v", 0, "input", "0"),), twice))
    assert "s.toml:15:1: connections: 'observer.v' has two sources (the other one: " in said


def test_integers_and_booleans_arrive_as_they_are(tmp_path: Path, lag_library: Path) -> None:
    second = (variable("k", 0, "input", "0", "Integer"), variable("l", 0, "input", "0", "Boolean"),
              variable("kk", 1, "output", None, "Integer"),
              variable("ll", 1, "output", None, "Boolean"))  # fmt: skip
    links = LINK.format("plant.m", "observer.k") + LINK.format("plant.c", "observer.l")
    done = run(pair(tmp_path, lag_library, second, links), tmp_path)
    assert done.returncode == 0, done.stderr
    found = results.load(tmp_path / "out")
    held = np.where(found.time < 0.0045, 3, -5)  # integers are held, never interpolated
    assert found["scenario.n"].tolist() == held.tolist()
    assert found["scenario.b"].tolist() == (found.time < 0.0045).tolist()
    stepped = slice(1, None)  # the fixture computes in doStep only
    before = held[:-1]  # inputs are those at the start of the step
    assert found["plant.m"][stepped].tolist() == (2 * before).tolist()
    assert found["observer.kk"][stepped].tolist() == (4 * before).tolist()  # in the same step
    assert found["plant.c"][stepped].tolist() == (before < 0).tolist()
    assert found["observer.ll"][stepped].tolist() == (before > 0).tolist()


def test_events_are_the_changes_of_integer_outputs(tmp_path: Path, lag_library: Path) -> None:
    write_fmu(tmp_path / "Lag.fmu", lag_library, (*WHOLE, *PARAMETERS))
    assert run(write_system(tmp_path, "0.01", "time,n\n0,3\n0.0045,-5\n"), tmp_path).returncode == 0
    events = results.load(tmp_path / "out").run["events"]
    assert [(e["time"], e["from"], e["to"]) for e in events] == [(0.001, 0, 6), (0.006, 6, -10)]


def test_a_tunable_parameter_follows_its_scenario_column(tmp_path: Path, lag_library: Path) -> None:
    """tau jumps from 1 s to 0.5 s half-way; the lag then answers twice as fast."""
    tunable = variable("tau", 2, "parameter", "1").replace('"fixed"', '"tunable"')
    write_fmu(tmp_path / "Lag.fmu", lag_library, (*LAG[:2], tunable, *LAG[3:]))
    scenario = "time,u,tau\n0,2,1\n0.499,2,1\n0.5,2,0.5\n"
    done = run(write_system(tmp_path, "1.0", scenario), tmp_path)
    assert done.returncode == 0, done.stderr
    found = results.load(tmp_path / "out")
    exponent = np.minimum(found.time, 0.5) + 2 * np.maximum(found.time - 0.5, 0)
    assert np.abs(found["plant.x"] - 2 * (1 - np.exp(-exponent))).max() < 1e-12
    assert {"from": "scenario.tau", "to": "plant.tau"} in found.run["wiring"]


def test_a_fixed_parameter_has_no_scenario_column(tmp_path: Path, lag_library: Path) -> None:
    write_fmu(tmp_path / "Lag.fmu", lag_library)
    done = run(write_system(tmp_path, "0.01", "time,u,tau\n0,2,9\n"), tmp_path)
    assert done.returncode == 0, done.stderr
    assert [w["to"] for w in results.load(tmp_path / "out").run["wiring"]] == ["plant.u"]
