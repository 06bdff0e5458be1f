"""The order of coupling on the real FMUs: each one alone, fed with recorded rows, gives its rows.

Plant, observer, control step in this order. Over the step from row k to row k + 1 the plant has
the control's positions of row k; the observer has the plant's speeds of row k + 1 and the same
positions as the plant; the control has speeds and estimates of row k + 1; the scenario's signals
are those of row k.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from dct_harness import kpi, results
from fmu_instance import Instance
from harness_fixture.lag_fmu import run

STOP = "2.8"  # s: clutch 1 slips and locks up
STARTS = ("--set", "plant.vehicle.speed_start=3.0")
FRESH = {"plant": (), "observer": ("plant",), "control": ("plant", "observer")}
MODELS = {"plant": "DctPlant", "observer": "DctObserver", "control": "DctClutchControl"}


@pytest.fixture(scope="module")
def loop(repo_root: Path, tmp_path_factory: pytest.TempPathFactory) -> results.Results:
    """Torque tracking of a vehicle that rolls at the start."""
    folder, examples = tmp_path_factory.mktemp("coupling"), repo_root / "examples/closed_loop"
    text = (examples / "torque_tracking_case1.toml").read_text(encoding="utf-8")
    text = text.replace("stop = 30.0", f"stop = {STOP}").replace(
        "scenarios/", f"{examples}/scenarios/"
    )
    (folder / "s.toml").write_text(text, encoding="utf-8")
    done = run(folder / "s.toml", repo_root / "target/fmu", *STARTS)
    assert done.returncode == 0, done.stderr
    return results.load(folder / "out")


def inputs(loop: results.Results, component: str, k: int, late: bool = False) -> dict[str, float]:
    """Return what a component had over the step to row `k`; row 0 is the initialisation.

    `late`: as a master would feed it that takes every signal from the row before.
    """
    before, found = max(k - 1, 0), {}
    for wire in loop.run["wiring"]:
        target, _, name = wire["to"].partition(".")
        if target == component:
            fresh = wire["from"].partition(".")[0] in FRESH[component] and not late
            found[name] = float(loop[wire["from"]][k if fresh else before])
    return found


def set_all(fmu: Instance, values: dict[str, float]) -> None:
    """Set inputs, each as its type."""
    kinds = {"Real": float, "Integer": int, "Boolean": bool}
    for name, value in values.items():
        fmu.set(name, kinds[fmu.variables[name].type](value))


def replay(loop: results.Results, component: str, fmu: Path, late: bool = False) -> np.ndarray:
    """Return the outputs of one FMU alone, shape (rows, outputs)."""
    with Instance(fmu) as alone:
        for name, value in loop.run["system"]["components"][component]["parameters"].items():
            alone.set(name, value)
        set_all(alone, inputs(loop, component, 0))
        alone.start(0.0, float(STOP))
        rows = [list(alone.outputs().values())]
        for k in range(1, len(loop.time)):
            set_all(alone, inputs(loop, component, k, late))
            alone.step(loop.time[k - 1], loop.time[k] - loop.time[k - 1])
            rows.append(list(alone.outputs().values()))
        return np.array(rows, dtype=float)


def recorded(loop: results.Results, component: str, fmu: Path) -> np.ndarray:
    """Return the recorded outputs of a component in the order of its description."""
    with Instance(fmu) as alone:
        return np.column_stack([loop[f"{component}.{n}"] for n in alone.names("output")])


@pytest.mark.parametrize("component", MODELS)
def test_each_fmu_alone_repeats_its_rows_bit_for_bit(
    repo_root: Path, loop: results.Results, component: str
) -> None:
    fmu = repo_root / f"target/fmu/{MODELS[component]}.fmu"
    assert (replay(loop, component, fmu) == recorded(loop, component, fmu)).all()


@pytest.mark.parametrize("component", ["observer", "control"])
def test_another_order_would_be_noticed(
    repo_root: Path, loop: results.Results, component: str
) -> None:
    fmu = repo_root / f"target/fmu/{MODELS[component]}.fmu"
    assert (replay(loop, component, fmu, late=True) != recorded(loop, component, fmu)).any()


def test_initial_values_arrive_before_the_first_step(
    repo_root: Path, loop: results.Results
) -> None:
    """The observer's first load torque is that of the plant's first speed, not of zero speed."""
    with Instance(repo_root / "target/fmu/DctObserver.fmu") as alone:
        values = inputs(loop, "observer", 0)
        assert values["wheel.speed"] == pytest.approx(3.0 / 0.3)
        set_all(alone, {**values, "wheel.speed": 0.0})
        alone.start()
        assert alone.get("load.torque") != loop["observer.load.torque"][0]


def test_events_are_the_changes_of_the_state_columns(loop: results.Results) -> None:
    expected = []
    for clutch in ("clutch1", "clutch2"):
        column = loop[f"plant.{clutch}.state"].astype(int)
        for k in np.flatnonzero(np.diff(column)) + 1:
            expected.append((loop.time[k], f"{clutch}.state", column[k - 1], column[k]))
    events = [(e["time"], e["variable"], e["from"], e["to"]) for e in loop.run["events"]
              if e["component"] == "plant"]  # fmt: skip
    assert sorted(events) == sorted(expected)
    assert {(2, 3), (1, 2)} <= {(e[2], e[3]) for e in events}


def test_kpis_of_the_run_are_those_of_its_files(loop: results.Results) -> None:
    stored = json.loads((loop.path / "kpis.json").read_text(encoding="utf-8"))
    assert stored["rows"]
    assert stored == kpi.compute(loop, loop.run)
