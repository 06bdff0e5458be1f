"""fmpy loads, validates and runs each FMU, and every rule of the life cycle holds there."""

from __future__ import annotations

import json
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu
from fmu_instance import Instance
from importer_cases import HALF, MODELS, STARTS, STEP, STEPS, advance, expected, fmu, started
from lxml import etree

DISCARD, ERROR = 2, 3  # fmi2Status
STEP_EFFECT = 1e-4  # the plant is exact for held inputs, but for the load torque over a step
JERK_EFFECT = (2 * STEP / 0.02) ** 2 / 12  # a ramp over the longest step into filters of 20 ms
XSD = Path(fmpy.__file__).parent / "schema" / "fmi2" / "fmi2ModelDescription.xsd"

every_model = pytest.mark.parametrize("model", MODELS)


def _refusal(call: Callable[[], object]) -> int:
    """Return the status with which a call is refused."""
    with pytest.raises(FMICallException) as refused:
        call()
    return refused.value.status


@every_model
def test_fmpy_finds_no_problem(model: str) -> None:
    assert validate_fmu(str(fmu(model))) == []


@every_model
def test_the_description_is_valid_against_the_schema_of_the_standard(model: str) -> None:
    schema = etree.XMLSchema(etree.parse(str(XSD)))
    with zipfile.ZipFile(fmu(model)) as archive, archive.open("modelDescription.xml") as file:
        schema.assertValid(etree.parse(file))


@every_model
def test_simulate_fmu_runs_it_alone(model: str) -> None:
    """First with a step given, then with nothing but what the FMU itself says."""
    result = fmpy.simulate_fmu(str(fmu(model)), start_values=STARTS[model],
                               stop_time=HALF * STEP, output_interval=STEP)  # fmt: skip
    assert len(result) == HALF + 1
    assert {name: result[name][-1] for name in result.dtype.names[1:]} == expected(model, HALF)
    whole = fmpy.simulate_fmu(str(fmu(model)))
    assert whole["time"][-1] == 30.0
    assert all(np.isfinite(whole[name]).all() for name in whole.dtype.names)


HEAT = {f"clutch{i}.{name}": value for i in (1, 2)
        for name, value in (("thermal.capacity", 5e3), ("thermal.conductance", 50.0),
                            ("specificWear", 1e-14))}  # fmt: skip


@every_model
def test_every_real_output_moves(model: str) -> None:
    """What the importers are compared with is a run in which something happens.

    Some outputs of the observer belong to the method `calibrating` alone, which learns nothing for
    a second where it begins with a pressed clutch, some of the plant to the brake, to heat, or to a
    gear that is preselected.
    """
    still = _still(model, {})
    if model == "DctObserver":
        still &= _still(model, {"observer.method": 5, "clutch1.position": 0.0})
    if model == "DctPlant":
        still &= _still(model, {"brake.torque": 50.0} | HEAT)
        still -= _moved_by_a_gear()
    assert still == set()


def _moved_by_a_gear() -> set[str]:
    """Return the real outputs of the plant that differ after the second gear has been put in."""
    found = []
    for gear in (0, 2):
        with started("DctPlant", STARTS["DctPlant"] | {"shaft2.gear": 0}) as instance:
            advance(instance, 0, HALF // 2)
            instance.set("shaft2.gear", gear)
            advance(instance, HALF // 2, HALF)
            found.append(instance.outputs())
    return {n for n, v in found[0].items() if type(v) is float and v != found[1][n]}


def _still(model: str, more: dict[str, float | int]) -> set[str]:
    """Return the real outputs that do not move with these start values as well."""
    with started(model, STARTS[model] | more) as instance:
        before = {n: v for n, v in instance.outputs().items() if type(v) is float}
        advance(instance, 0, STEPS)
        after = instance.outputs()
    return {name for name in before if before[name] == after[name]}


@every_model
def test_a_saved_state_continues_bit_for_bit(model: str) -> None:
    with started(model, STARTS[model]) as instance:
        advance(instance, 0, HALF)
        saved, before = instance.saved(), instance.values()
        advance(instance, HALF, STEPS)
        assert instance.outputs() == expected(model)
        instance.restore(saved)
        assert instance.values() == before
        assert instance.saved() == saved
        advance(instance, HALF, STEPS)
        assert instance.outputs() == expected(model)


CONTINUE = """
import json, sys
from pathlib import Path
from importer_cases import HALF, STEPS, advance, started
model, data = sys.argv[1], Path(sys.argv[2]).read_bytes()
with started(model, {}) as instance:
    instance.restore(data)
    advance(instance, HALF, STEPS)
    print(json.dumps(instance.outputs()))
"""


@every_model
def test_a_saved_state_continues_in_another_process(
    model: str, tmp_path: Path, repo_root: Path
) -> None:
    with started(model, STARTS[model]) as instance:
        advance(instance, 0, HALF)
        (tmp_path / "state").write_bytes(instance.saved())
    command = [sys.executable, "-c", CONTINUE, model, tmp_path / "state"]
    done = subprocess.run(command, cwd=repo_root / "tests", capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == expected(model)


@every_model
def test_a_damaged_state_is_refused_and_changes_nothing(model: str) -> None:
    with started(model, STARTS[model]) as instance:
        advance(instance, 0, 2)
        saved, before = instance.saved(), instance.values()
        flipped = bytes([*saved[:-1], saved[-1] ^ 1])
        for data in (flipped, saved[:-1], b"", b"x" * len(saved)):
            assert _refusal(lambda data=data: instance.restore(data)) == ERROR
        assert instance.values() == before
        advance(instance, 2, STEPS)
        assert instance.outputs() == expected(model)


@every_model
def test_a_reset_instance_is_a_fresh_one(model: str) -> None:
    with Instance(fmu(model)) as fresh:
        values, state = fresh.values(), fresh.saved()
    with started(model, STARTS[model]) as instance:
        advance(instance, 0, STEPS)
        instance.slave.reset()
        assert (instance.values(), instance.saved()) == (values, state)
        for name, value in STARTS[model].items():
            instance.set(name, value)
        instance.start()
        advance(instance, 0, STEPS)
        assert instance.outputs() == expected(model)


@every_model
def test_instances_do_not_see_each_other(model: str) -> None:
    with started(model, STARTS[model]) as one, started(model, {}) as other:
        untouched = other.values()
        advance(one, 0, STEPS)
        assert one.outputs() == expected(model)
        assert other.values() == untouched


@every_model
def test_start_values_are_those_of_the_description(model: str) -> None:
    with Instance(fmu(model)) as instance:
        texts = {n: v.start for n, v in instance.variables.items() if v.start is not None}
        assert {n: v.start for n, v in instance.variables.items()
                if v.causality in ("input", "parameter")} == texts  # fmt: skip
        for name, text in texts.items():
            number = float({"false": "0", "true": "1"}.get(text, text))
            assert instance.get(name) == number, name


@every_model
def test_every_parameter_and_input_keeps_what_it_is_given(model: str) -> None:
    with Instance(fmu(model)) as instance:
        given = {n: _other(instance, n) for c in ("parameter", "input") for n in instance.names(c)}
        for name, value in given.items():
            instance.set(name, value)
        assert {name: instance.get(name) for name in given} == given


def _other(instance: Instance, name: str) -> float | int | bool:
    """Return a legal value that is not the start value."""
    variable, start = instance.variables[name], instance.get(name)
    if variable.type == "Boolean":
        return not start
    if variable.type == "Enumeration":
        return int(variable.declaredType.items[-1].value)
    low, high = (float(text) if text else None for text in (variable.min, variable.max))
    if variable.type == "Integer":
        return int(start) - 1 if high is not None and start >= high else int(start) + 1
    if low is None or high is None:
        return start + max(1.0, abs(start)) / 8
    return (start + (high if start < high else low)) / 2


@every_model
@pytest.mark.parametrize("side", ["min", "max"])
def test_a_value_beyond_its_limit_is_discarded(model: str, side: str) -> None:
    with Instance(fmu(model)) as instance:
        limits = {n: getattr(v, side) for n, v in instance.variables.items()
                  if getattr(v, side) is not None and v.causality != "output"}  # fmt: skip
        assert limits
        for name, text in limits.items():
            before = instance.get(name)
            assert _refusal(lambda n=name, t=text: instance.set(n, _beyond(t, side))) == DISCARD
            assert instance.get(name) == before
            assert name in instance.log[-1].message


def _beyond(limit: str, side: str) -> float | int:
    """Return the nearest value outside a limit."""
    sign = 1 if side == "max" else -1
    exact = float(limit)
    if "." in limit or "e" in limit:
        return float(np.nextafter(exact, sign * np.inf))
    return int(exact) + sign


@every_model
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_values_that_are_not_finite_are_discarded(model: str, value: float) -> None:
    with Instance(fmu(model)) as instance:
        names = [n for n in instance.names("input") if instance.variables[n].type == "Real"]
        for name in names:
            before = instance.get(name)
            assert _refusal(lambda n=name: instance.set(n, value)) == DISCARD
            assert instance.get(name) == before


def test_a_set_call_with_one_bad_value_writes_none() -> None:
    with Instance(fmu("DctPlant")) as plant:
        names = ("engine.torque", "clutch1.position", "road.grade")
        references = [plant.variables[name].valueReference for name in names]
        assert _refusal(lambda: plant.slave.setReal(references, [5.0, 1e-3, 9.0])) == DISCARD
        assert [plant.get(name) for name in names] == [0.0, 0.0, 0.0]


def _fixed(instance: Instance) -> str:
    return next(n for n, v in instance.variables.items()
                if v.variability == "fixed" and v.type == "Real")  # fmt: skip


def _real(instance: Instance) -> int:
    return instance.variables[instance.names("output")[0]].valueReference


# Calls on a running instance that stands at t = STEP.
ILLEGAL: dict[str, Callable[[Instance], object]] = {
    "set an output": lambda i: i.set(i.names("output")[0], 1.0),
    "set a fixed parameter": lambda i: i.set(_fixed(i), i.get(_fixed(i))),
    "set up twice": lambda i: i.slave.setupExperiment(),
    "initialise twice": lambda i: i.slave.enterInitializationMode(),
    "leave initialisation twice": lambda i: i.slave.exitInitializationMode(),
    "read an unknown reference": lambda i: i.slave.getReal([len(i.variables)]),
    "read a Real as Boolean": lambda i: i.slave.getBoolean([_real(i)]),
    "read a String": lambda i: i.slave.getString([_real(i)]),
    "repeat a step": lambda i: i.step(0.0, STEP),
    "skip a step": lambda i: i.step(2 * STEP, STEP),
    "step by 0": lambda i: i.step(STEP, 0.0),
    "step back": lambda i: i.step(STEP, -STEP),
    "step by NaN": lambda i: i.step(STEP, np.nan),
    "step without end": lambda i: i.step(STEP, np.inf),
    "step from NaN": lambda i: i.step(np.nan, STEP),
    "a derivative of order 2": lambda i: i.slave.setRealInputDerivatives([0], [2], [0.0]),
    "cancel a step": lambda i: i.slave.cancelStep(),
    "ask for Jacobians": lambda i: i.slave.getDirectionalDerivative([0], [0], [1.0]),
}


@every_model
@pytest.mark.parametrize("what", ILLEGAL)
def test_an_illegal_call_is_an_error_with_a_sentence(model: str, what: str) -> None:
    with started(model, STARTS[model]) as instance:
        advance(instance, 0, 1)
        before, said = instance.values(), len(instance.log)
        assert _refusal(lambda: ILLEGAL[what](instance)) == ERROR
        assert len(instance.log) == said + 1
        assert instance.values() == before


@every_model
def test_nothing_steps_before_initialisation_or_after_the_end(model: str) -> None:
    with Instance(fmu(model)) as instance:
        assert _refusal(lambda: instance.step(0.0, STEP)) == ERROR
        assert _refusal(instance.slave.exitInitializationMode) == ERROR
        assert _refusal(instance.slave.terminate) == ERROR
    with started(model, STARTS[model]) as instance:
        instance.slave.terminate()
        assert _refusal(lambda: instance.step(0.0, STEP)) == ERROR


@every_model
def test_a_step_past_the_stop_time_is_an_error_but_rounding_is_not(model: str) -> None:
    with Instance(fmu(model)) as instance:
        instance.start(stop=0.03)
        instance.step(0.0, 0.01)
        instance.step(0.01, 0.01 * (1 + 1e-12))
        instance.step(0.02 * (1 + 1e-12), 0.01)
        assert _refusal(lambda: instance.step(0.03, 0.01)) == ERROR


def test_another_guid_makes_no_instance() -> None:
    with Instance(fmu("DctPlant")) as plant:
        plant.slave.guid = "{00000000-0000-0000-0000-000000000000}"
        kept = plant.slave.component
        with pytest.raises(Exception, match="Failed to instantiate"):
            plant.slave.instantiate(callbacks=plant.slave.callbacks)
        plant.slave.component = kept
        assert "GUID" in plant.log[-1].message


@pytest.mark.parametrize("model", ["DctPlant", "DctObserver"])
def test_a_tunable_parameter_acts_from_the_next_step(model: str) -> None:
    name, value = {"DctPlant": ("clutch1.kineticFriction", 0.1),
                   "DctObserver": ("gain.L11", 0.0)}[model]  # fmt: skip
    with started(model, STARTS[model]) as instance:
        advance(instance, 0, HALF)
        instance.set(name, value)
        advance(instance, HALF, STEPS)
        assert instance.outputs() != expected(model)


@every_model
def test_steps_may_vary(model: str) -> None:
    with started(model, STARTS[model]) as instance:
        sizes = [STEP / 2, STEP / 2, STEP, 2 * STEP] * (HALF // 4)
        times = np.concatenate([[0.0], np.cumsum(sizes)])
        for time, size in zip(times[:-1], sizes, strict=True):
            instance.step(time, size)
        assert times[-1] == HALF * STEP
        if model == "DctPlant":
            found, wanted = instance.outputs(), dict(expected(model, HALF))
            jerk = wanted.pop("vehicle.jerk")
            assert found.pop("vehicle.jerk") == pytest.approx(jerk, rel=JERK_EFFECT)
            assert found == pytest.approx(wanted, rel=STEP_EFFECT, abs=STEP_EFFECT)
