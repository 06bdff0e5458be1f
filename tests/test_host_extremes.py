"""Numbers at the edge of a double, as start values and inputs: refused, or no harm done."""

from __future__ import annotations

import ctypes
import math
from functools import cache

import pytest
from importer_cases import MODELS, STEP
from raw_fmu import DISCARD, ERROR, OK, Pointer, RawFmu, Real, Size, Uint, loaded

TINY, LEAST, LARGEST = 5e-324, 2.2250738585072014e-308, 1.7976931348623157e308
NONE = (math.nan, math.inf, -math.inf)
ODD = (TINY, -TINY, LEAST / 2, 1e-300, -1e-300, -0.0, 1e300, -1e300, LARGEST, -LARGEST)
STEPS = 3
every_model = pytest.mark.parametrize("model", MODELS)


@cache
def raw(model: str) -> RawFmu:
    return loaded(model)


def _reals(fmu: RawFmu, *causalities: str) -> list[int]:
    return [v.valueReference for v in fmu.variables.values()
            if v.type == "Real" and v.causality in causalities]  # fmt: skip


def _set(fmu: RawFmu, component: Pointer, references: list[int], values: list[float]) -> int:
    count = len(references)
    return fmu("SetReal", component, (Uint * count)(*references), Size(count),
               (Real * count)(*values))  # fmt: skip


def _outputs_are_numbers(fmu: RawFmu, component: Pointer) -> bool:
    """Read each output by itself: the status is fine, the value is a number."""
    found = Real()
    for reference in _reals(fmu, "output", "local"):
        status = fmu("GetReal", component, ctypes.byref(Uint(reference)), Size(1),
                     ctypes.byref(found))  # fmt: skip
        if status != OK or not math.isfinite(found.value):
            return False
    return True


def _runs(fmu: RawFmu, component: Pointer, first: int = 0) -> bool:
    """Make steps: each leaves numbers in all outputs, or ends the run with a sentence."""
    for step in range(first, first + STEPS):
        status = fmu.step(component, step * STEP, STEP)
        if status != OK:
            assert status in (DISCARD, ERROR)
            assert fmu.log[-1].text
            return False
        assert _outputs_are_numbers(fmu, component)
    return True


@every_model
def test_start_values_at_the_edge_start_a_run_or_are_refused_with_a_sentence(model: str) -> None:
    fmu, taken, ran = raw(model), 0, 0
    for reference in _reals(fmu, "parameter", "input"):
        for value in (*NONE, *ODD):
            component = fmu.instantiate()
            status = _set(fmu, component, [reference], [value])
            assert status in ((DISCARD,) if value in NONE else (OK, DISCARD))
            assert fmu("EnterInitializationMode", component) == OK
            if status == OK:
                taken += 1
                started = fmu("ExitInitializationMode", component)
                assert started in (OK, ERROR)
                ran += started == OK and _runs(fmu, component)
            else:
                assert fmu("ExitInitializationMode", component) == OK
                assert _runs(fmu, component)
            assert fmu("Reset", component) == OK
            fmu.free(component)
    assert 0 < ran < taken


@every_model
def test_inputs_at_the_edge_are_stepped_with_or_refused_with_a_sentence(model: str) -> None:
    fmu = raw(model)
    inputs = _reals(fmu, "input")
    for value in (*NONE, *ODD):
        for references in (*([one] for one in inputs), inputs):
            component = fmu.begun()
            status = _set(fmu, component, references, [value] * len(references))
            if value in NONE:
                assert status == DISCARD
                assert _runs(fmu, component)
            else:
                assert status in (OK, DISCARD)
                _runs(fmu, component)
            fmu.free(component)
