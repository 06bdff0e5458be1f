"""Friction over the position in the report: learnt, believed at first, and the truth."""

from __future__ import annotations

import base64
import dataclasses
from typing import Any

import closed_loop_runs
import numpy as np
import pytest
from dct_harness.report import friction_map, runs

DRIVEN = (4.5, 8.0)  # mm, where both clutches slip alone
NOMINAL = (0.4, 0.1)


@pytest.fixture(scope="module")
def view(tmp_path_factory: pytest.TempPathFactory) -> runs.View:
    """A drive with clutches that are worn where they touch."""
    folder = tmp_path_factory.mktemp("worn")
    closed_loop_runs.run("calibration_worn", (), folder)
    (view,) = runs.load([folder])
    return view


def line(panel: dict[str, Any], role: str) -> tuple[np.ndarray, np.ndarray]:
    """Return position [mm] and friction of the last line of a role."""
    found = [t for t in panel["traces"] if t["role"] == role][-1]
    x, y = (np.frombuffer(base64.b64decode(found[k]["bdata"]), "<f4") for k in "xy")
    return x, y


def test_learnt_friction_is_the_true_one_where_it_was_driven(view: runs.View) -> None:
    (figure,) = friction_map.drawn(view)
    assert figure["across"] == "position [mm]"
    for panel, nominal in zip(figure["panels"], NOMINAL, strict=True):
        (x, truth), (_, learnt) = line(panel, "truth"), line(panel, "observer")
        driven = (x >= DRIVEN[0]) & (x <= DRIVEN[1])
        assert np.abs(learnt / truth - 1)[driven].max() < 0.05
        assert np.ptp(truth[driven]) > 0.02
        assert line(panel, "map")[1] == pytest.approx(nominal)
        upper = line(panel, "band")[1]
        assert (upper - learnt)[driven].min() < 0.01
        assert (upper - learnt)[-1] > 0.05, "nobody drove there"


def test_no_figure_without_a_friction_that_was_learnt(view: runs.View) -> None:
    told = view.results.signals
    bare = {n: v for n, v in told.items() if "frictionMap[" not in n}
    known = {n: 0 * v if "frictionMapDeviation" in n else v for n, v in told.items()}
    for signals in (bare, known):  # of an older FMU, of another method
        changed = dataclasses.replace(view.results, signals=signals)
        assert friction_map.drawn(dataclasses.replace(view, results=changed)) == []


def test_the_truth_of_a_piston_is_its_friction(view: runs.View) -> None:
    told = view.run["parameters"]["plant"]
    told["clutch1.pistonArea"] = {"value": 0.001, "unit": "m2"}
    (figure,) = friction_map.drawn(view)
    _, truth = line(figure["panels"][0], "truth")
    assert truth == pytest.approx(told["clutch1.kineticFriction"]["value"])
