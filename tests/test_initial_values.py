"""Initial values: what InitialUnknowns say is true, and orders the coupled FMUs without a loop."""

from __future__ import annotations

import math
import random
import re
from collections import defaultdict
from contextlib import ExitStack
from graphlib import CycleError, TopologicalSorter

import pytest
from dct_harness.system import parameters
from fmpy.fmi1 import FMICallException
from fmpy.model_description import ScalarVariable
from fmu_instance import Instance, Value
from importer_cases import LOOP_STARTS, MODELS, ROOT, fmu

SETS = ROOT / "examples/closed_loop/parameters"
PAIRS = 40  # of one drawn vehicle, one sample and another
DRAWS = 100  # for one of them; a model refuses some
INPUTS = {
    "N.m": (-200.0, 300.0), "rad/s": (-50.0, 600.0), "m": (0.0, 0.012), "Pa": (0.0, 2e6),
    "rad": (-0.3, 0.3), "1": (0.0, 0.5), "N/m": (0.0, 3e5),
}  # fmt: skip
STARTS = {
    "engine.speed_start": (0.0, 600.0), "vehicle.speed_start": (-5.0, 40.0),
    "clutch1.temperature_start": (0.0, 500.0), "clutch2.temperature_start": (0.0, 500.0),
}  # fmt: skip
# Who reads whose outputs of the same name; engine torque and requests come from outside.
READS = {
    "DctPlant": ("DctClutchControl",),
    "DctObserver": ("DctPlant", "DctClutchControl"),
    "DctClutchControl": ("DctPlant", "DctObserver"),
}
ROUNDING = 5e-11  # rad/s, less than what counts as slip
ENGAGED = 3  # of ClutchState
Signal = tuple[str, str]


def _listed(instance: Instance) -> dict[str, frozenset[str]]:
    """Return output -> what it says its initial value depends on, where it says so."""
    return {
        unknown.variable.name: frozenset(v.name for v in unknown.dependencies)
        for unknown in instance.description.initialUnknowns
        if unknown.dependencies is not None
    }


def _start(variable: ScalarVariable) -> Value:
    if variable.type == "Boolean":
        return variable.start == "true"
    return float(variable.start) if variable.type == "Real" else int(variable.start)


class Draw:
    """Draws what can be set of a model: a vehicle of some preset, every number of it off a bit."""

    def __init__(self, instance: Instance, seed: int) -> None:
        self._given = {
            v.name: v for v in instance.variables.values() if v.causality in ("input", "parameter")
        }
        self._types = {kind.name: kind for kind in instance.description.typeDefinitions}
        role = instance.description.modelName.removeprefix("Dct").removeprefix("Clutch").lower()
        self._sets = [parameters.read(path) for path in sorted(SETS.glob(f"*_{role}.ssv"))]
        self._random = random.Random(seed)

    def values(self) -> dict[str, Value]:
        """Return a value of each."""
        preset = self._random.choice(self._sets)
        shares: dict[str, float] = defaultdict(lambda: self._random.uniform(0.8, 1.25))
        found: dict[str, Value] = {}
        for name, variable in self._given.items():
            if variable.type == "Real":
                table = re.sub(r"\[\d+\]", "", name)  # the points of a table stay in order
                share = 1.0 if table.endswith(".factor") else shares[table]
                found[name] = self._real(variable, preset.get(name), share)
            else:
                found[name] = self._random.choice(self._whole(variable))
        return found

    def _real(self, variable: ScalarVariable, preset: Value | None, share: float) -> float:
        low, high = (float(x) if x else d for x, d in
                     ((variable.min, -math.inf), (variable.max, math.inf)))  # fmt: skip
        span = STARTS.get(variable.name)
        if variable.causality == "input":
            span = INPUTS[variable.unit]
        value = self._random.uniform(*span) if span else float(
            variable.start if preset is None else preset) * share  # fmt: skip
        return min(max(value, low), high)

    def _whole(self, variable: ScalarVariable) -> list[Value]:
        if variable.type == "Boolean":
            return [False, True]
        if variable.type == "Enumeration":
            return [int(item.value) for item in self._types[variable.declaredType.name].items]
        return list(range(int(variable.min), int(variable.max) + 1))


def _initial(instance: Instance, values: dict[str, Value]) -> dict[str, Value] | None:
    """Return the initial outputs; nothing if the model refuses the values together."""
    instance.slave.reset()
    try:
        for name, value in values.items():
            instance.set(name, value)
        instance.slave.setupExperiment()
        instance.slave.enterInitializationMode()
        return instance.outputs()
    except FMICallException:
        return None


def _pair(instance: Instance, draw: Draw, kept: frozenset[str]) -> list[dict[str, Value]]:
    """Return the outputs of two draws that have in common what is `kept`, and no more."""
    for _ in range(DRAWS):
        one, other = draw.values(), draw.values()
        found = [_initial(instance, one),
                 _initial(instance, other | {name: one[name] for name in kept})]  # fmt: skip
        if None not in found:
            return found
    raise AssertionError(f"{DRAWS} draws were refused")


@pytest.mark.parametrize("model", MODELS)
def test_nothing_moves_an_initial_value_that_it_does_not_depend_on(model: str) -> None:
    alike: dict[frozenset[str], list[str]] = defaultdict(list)
    with Instance(fmu(model)) as instance:
        for output, names in _listed(instance).items():
            alike[names].append(output)
        draw = Draw(instance, seed=1)
        for kept, outputs in alike.items():
            for _ in range(PAIRS):
                one, other = _pair(instance, draw, kept)
                assert {o: one[o] for o in outputs} == {o: other[o] for o in outputs}


@pytest.mark.parametrize("model", MODELS)
def test_the_draws_move_all_initial_values_that_depend_on_something(model: str) -> None:
    with Instance(fmu(model)) as instance:
        moving = [name for name, names in _listed(instance).items() if names]
        draw = Draw(instance, seed=2)
        pairs = [_pair(instance, draw, frozenset()) for _ in range(PAIRS)]
    assert len(moving) >= 2
    assert [name for name in moving if all(one[name] == other[name] for one, other in pairs)] == []


def _edges(loop: dict[str, Instance]) -> dict[Signal, set[Signal]]:
    """Return signal -> signals that have to be known first."""
    before: dict[Signal, set[Signal]] = {}
    for model, instance in loop.items():
        inputs = set(instance.names("input"))
        for source in READS[model]:
            for name in inputs.intersection(loop[source].names("output")):
                before[model, name] = {(source, name)}
        listed = _listed(instance)
        for output in instance.names("output"):
            before[model, output] = {(model, n) for n in listed.get(output, inputs) if n in inputs}
    return before


def _loop(stack: ExitStack) -> dict[str, Instance]:
    """Return the three FMUs in initialisation mode."""
    loop = {model: stack.enter_context(Instance(fmu(model))) for model in MODELS}
    for model, instance in loop.items():
        for name, value in LOOP_STARTS[model].items():
            instance.set(name, value)
        instance.slave.setupExperiment()
        instance.slave.enterInitializationMode()
    return loop


@pytest.mark.parametrize("engaged", [False, True])
def test_the_loop_of_the_fmus_has_its_initial_values_after_one_pass(engaged: bool) -> None:
    """Also where engine and clutch start alike but for rounding, so that the clutch is engaged."""
    with ExitStack() as stack:
        loop = _loop(stack)
        plant = loop["DctPlant"]
        if engaged:
            plant.set("vehicle.speed_start", 7.3)
            plant.set("engine.speed_start", plant.get("clutch1.speed") + ROUNDING)
        before = _edges(loop)
        for model, name in TopologicalSorter(before).static_order():
            for source, output in before.get((model, name), ()):
                if source != model:
                    loop[model].set(name, loop[source].get(output))
        wired = [(signal, *sources) for signal, sources in before.items()
                 if any(source != signal[0] for source, _ in sources)]  # fmt: skip
        assert len(wired) == 19
        for (model, name), (source, output) in wired:
            assert loop[model].get(name) == loop[source].get(output), (model, name)
        assert (plant.get("clutch1.state") == ENGAGED) == engaged


def test_with_no_lists_the_loop_would_be_one() -> None:
    with ExitStack() as stack:
        loop = _loop(stack)
        for instance in loop.values():
            instance.description.initialUnknowns.clear()
        with pytest.raises(CycleError):
            TopologicalSorter(_edges(loop)).prepare()
