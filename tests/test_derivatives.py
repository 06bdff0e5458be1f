"""Directional derivatives and output derivatives of the FMUs against finite differences."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from closed_loop_runs import FMUS, SYSTEMS
from dct_harness.system import scenario
from fmu_instance import Instance

STEP = 1e-3  # s
TINY = 1e-6  # s, of the difference by time; the fastest eigenvalue is 42 673 1/s
BY_TIME = 5e-3  # relative: what the second order of that difference leaves
BY_INPUT = 1e-5  # relative: the outputs are linear in all inputs but the grade
DELTA = {"engine.torque": 1.0, "brake.torque": 1.0, "road.grade": 1e-4,
         "clutch1.position": 1e-6, "clutch2.position": 1e-6}  # fmt: skip
STATES = {0.5: (1, 1), 1.5: (2, 1), 5.0: (3, 1), 9.0: (3, 2), 10.0: (1, 2), 13.0: (1, 3),
          17.3: (2, 2)}  # fmt: skip


@pytest.fixture(params=[False, True], ids=["compliant", "rigid"])
def plant(request: pytest.FixtureRequest) -> Iterator[Instance]:
    """The plant at the start of the paper"s scenario."""
    with Instance(FMUS / "DctPlant.fmu") as instance:
        instance.set("transmission.rigid", request.param)
        instance.set("engine.speed_start", 90.0)
        instance.start()
        yield instance


def _drive(plant: Instance) -> Iterator[tuple[float, tuple[int, int]]]:
    """Drive the scenario; yields at each time of `STATES` with the states of the clutches."""
    script = scenario.load(SYSTEMS / "scenarios" / "positions.csv")
    last = round(max(STATES) / STEP)
    times = np.arange(last + 1) * STEP
    rows = {name: script.sample(name, times, hold=False).tolist() for name in DELTA}
    stops = {round(time / STEP): expected for time, expected in STATES.items()}
    for k in range(last + 1):
        if k in stops:
            yield k * STEP, stops[k]
        for name, values in rows.items():
            plant.set(name, values[k])
        plant.step(k * STEP, STEP)


def _reals(plant: Instance) -> list[str]:
    return [n for n in plant.names("output") if plant.variables[n].type == "Real"]


def _values(plant: Instance, names: list[str]) -> np.ndarray:
    return np.array([plant.get(name) for name in names])


def _references(plant: Instance, names: list[str]) -> list[int]:
    return [plant.variables[name].valueReference for name in names]


def _by_input(plant: Instance, known: str, names: list[str]) -> np.ndarray:
    """Return the difference of outputs by an input.

    It is central for the grade alone: the outputs are linear in the others, which have a least
    value, and a map has corners; what is asked for is the side to which the input moves.
    """
    value, delta, found = plant.get(known), DELTA[known], []
    left = delta if known == "road.grade" else 0.0
    for moved in (value + delta, value - left):
        plant.set(known, moved)
        found.append(_values(plant, names))
    plant.set(known, value)
    return (found[0] - found[1]) / (delta + left)


def _close(ours: np.ndarray, theirs: np.ndarray, share: float, names: list[str]) -> None:
    wrong = np.abs(ours - theirs) > share * np.maximum(1.0, np.abs(theirs))
    assert not wrong.any(), [
        (n, a, b) for n, a, b, w in zip(names, ours, theirs, wrong, strict=True) if w
    ]


def test_derivatives_by_inputs_and_time_are_those_of_differences(plant: Instance) -> None:
    names, count = _reals(plant), 0
    references = _references(plant, names)
    for time, expected in _drive(plant):
        state = (plant.get("clutch1.state"), plant.get("clutch2.state"))
        assert state == expected, time
        for known in DELTA:
            found = plant.slave.getDirectionalDerivative(
                references, _references(plant, [known]), [1.0]
            )
            _close(np.array(found), _by_input(plant, known, names), BY_INPUT, names)
        rates = np.array(plant.slave.getRealOutputDerivatives(references, [1] * len(names)))
        saved, now = plant.saved(), _values(plant, names)
        plant.step(time, TINY)
        then = _values(plant, names)
        plant.step(time + TINY, TINY)
        difference = (4 * then - _values(plant, names) - 3 * now) / (2 * TINY)
        plant.restore(saved)
        _close(rates, difference, BY_TIME, names)
        count += 1
    assert count == len(STATES)


def test_a_direction_is_the_sum_of_its_parts(plant: Instance) -> None:
    names = _reals(plant)
    unknowns = _references(plant, names)
    drive = _drive(plant)
    assert [next(drive)[1] for _ in range(4)][-1] == (3, 2)
    knowns, direction = _references(plant, list(DELTA)), [2.0, -3.0, 0.1, 1e-4, 2e-4]
    whole = np.array(plant.slave.getDirectionalDerivative(unknowns, knowns, direction))
    parts = [np.array(plant.slave.getDirectionalDerivative(unknowns, [k], [d]))
             for k, d in zip(knowns, direction, strict=True)]  # fmt: skip
    assert np.abs(whole).max() > 1.0
    assert np.allclose(whole, sum(parts), rtol=1e-12, atol=1e-12)


def test_a_held_vehicle_does_not_accelerate_with_its_inputs() -> None:
    with Instance(FMUS / "DctPlant.fmu") as plant:
        plant.set("brake.torque", 500.0)
        plant.set("road.grade", 0.05)
        plant.start()
        assert plant.get("wheel.held")
        references = _references(plant, ["vehicle.acceleration", "load.torque"])
        for known in ("brake.torque", "road.grade"):
            found = plant.slave.getDirectionalDerivative(
                references, _references(plant, [known]), [1.0]
            )
            assert list(found) == [0.0, 0.0]


@pytest.mark.parametrize("model", ["DctPlant", "DctObserver", "DctClutchControl"])
def test_the_description_says_so_and_states_alone_have_no_derivative(model: str) -> None:
    with Instance(FMUS / f"{model}.fmu") as fmu:
        assert fmu.description.coSimulation.providesDirectionalDerivative
        order = fmu.description.coSimulation.maxOutputDerivativeOrder
        assert int(order or 0) == (1 if model == "DctPlant" else 0)
        fmu.set("engine.speed", 90.0) if model == "DctObserver" else None
        fmu.start()
        inputs = [n for n in fmu.names("input") if fmu.variables[n].type == "Real"]
        ones = [1.0] * len(inputs)
        found = fmu.slave.getDirectionalDerivative(
            _references(fmu, _reals(fmu)), _references(fmu, inputs), ones
        )
        assert model == "DctPlant" or not np.any(found)


@pytest.mark.parametrize(("unknown", "known", "said"), [
    ("engine.torque", "engine.torque", "engine.torque is not what a directional derivative takes"),
    ("clutch1.torque", "engine.inertia", "engine.inertia is not what a directional derivative"),
    ("clutch1.state", "engine.torque", "no Real variable"),
])  # fmt: skip
def test_other_derivatives_are_refused(unknown: str, known: str, said: str) -> None:
    with Instance(FMUS / "DctPlant.fmu") as plant:
        plant.start()
        with pytest.raises(Exception, match="fmi2GetDirectionalDerivative"):
            plant.slave.getDirectionalDerivative(
                _references(plant, [unknown]), _references(plant, [known]), [1.0]
            )
        assert said in plant.log[-1].message
