"""What a host may throw at an FMU: each call is refused with a status, and the host lives on.

Black box by ctypes. Crashes and leaks under valgrind, threads and small stacks: `test_abi.py`;
random calls: `tests/fuzz`.
"""

from __future__ import annotations

import csv
import ctypes
import subprocess
import sys
from functools import cache

import pytest
from importer_cases import MODELS, ROOT, STEP
from raw_fmu import (
    CO_SIMULATION,
    DISCARD,
    ERROR,
    LARGEST,
    OK,
    Int,
    Pointer,
    RawFmu,
    Real,
    Size,
    Uint,
    loaded,
)

TABLE = ROOT / "src/fmi2/legal_calls.csv"
MANY = 5000  # instances at once
TYPES = ("Real", "Integer", "Boolean", "String")
every_model = pytest.mark.parametrize("model", MODELS)


@cache
def raw(model: str) -> RawFmu:
    return loaded(model)


# As careless importers load them: the symbols of each are in the way of all others.
ALL_GLOBAL = """
import ctypes
from importer_cases import MODELS, STEP
from raw_fmu import OK, loaded
raw = [loaded(model, ctypes.RTLD_GLOBAL) for model in MODELS]
components = [one.begun() for one in raw]
assert [one.step(c, 0.0, STEP) for one, c in zip(raw, components)] == [OK] * len(MODELS)
"""


def test_libraries_whose_symbols_are_global_keep_apart() -> None:
    """In a process of its own: there they would be in the way of the FMUs of other tests, too."""
    command = [sys.executable, "-c", ALL_GLOBAL]
    done = subprocess.run(command, cwd=ROOT / "tests", capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


@every_model
@pytest.mark.parametrize("resources", [
    None, b"", b"no URI", b"file:///a%20b/%ZZ", b"file://\xff\xfe", b"C:\\a b\\c",
    b"http://host/" + b"x" * 100_000,
])  # fmt: skip
def test_no_resource_location_matters(model: str, resources: bytes | None) -> None:
    component = raw(model).instantiate(resources=resources)
    assert component
    raw(model).free(component)


@every_model
@pytest.mark.parametrize("name", [b"\xff\xfe\x80", b"%s%n", b"two\nlines", b"x" * 1_000_000])
def test_messages_bring_back_any_name_as_it_was_given(model: str, name: bytes) -> None:
    component = raw(model).instantiate(name=name)
    assert raw(model).step(component, 0.0, STEP) == ERROR
    assert raw(model).log[-1].instance == name
    raw(model).free(component)


@every_model
@pytest.mark.parametrize(("request_", "said"), [
    ({"name": None}, "instanceName"), ({"name": b""}, "instanceName"),
    ({"guid": None}, "fmuGUID"), ({"guid": b"{0}"}, "GUID"), ({"guid": b"\xff" * 1000}, "GUID"),
    ({"kind": CO_SIMULATION - 1}, "fmuType"), ({"kind": -1}, "fmuType"),
])  # fmt: skip
def test_what_is_not_for_this_fmu_makes_no_instance(model: str, request_: dict, said: str) -> None:
    for logged in (True, False):
        assert not raw(model).instantiate(**request_, logged=logged)
    assert said in raw(model).log[-1].text


@every_model
def test_guids_are_compared_to_the_last_character(model: str) -> None:
    guid = raw(model).guid
    for other in (guid[:-1], guid + b" ", guid[1:-1], guid.upper()):
        assert not raw(model).instantiate(guid=other)


@every_model
def test_categories_that_are_none_change_nothing(model: str) -> None:
    fmu, names = raw(model), ctypes.c_char_p * 6
    component = fmu.instantiate()
    for count, categories in ((1, names(b"logAll")), (2, names(b"logEvents", b"")),
                              (1, names(None)), (6, names(*[b"logEvents"] * 6)),
                              (LARGEST, names(b"logEvents")), (1, None)):  # fmt: skip
        before = len(fmu.log)
        assert fmu("SetDebugLogging", component, 0, Size(count), categories) == ERROR
        assert len(fmu.log) == before + 1
    assert fmu("SetDebugLogging", component, 0, Size(1), names(b"logAll")) == ERROR
    assert "logEvents logStatusWarning" in fmu.log[-1].text
    fmu.free(component)


@every_model
@pytest.mark.parametrize("kind", TYPES)
def test_no_count_and_no_pointer_leads_astray(model: str, kind: str) -> None:
    fmu, component = raw(model), raw(model).begun()
    references, values = (Uint * 2)(), (Real * 2)()
    odd = Pointer(ctypes.addressof(references) + 1)
    for name in (f"Get{kind}", f"Set{kind}"):
        for count in (len(fmu.variables) + 1, 2**31, 2**32, 2**61, 2**63, LARGEST):
            assert fmu(name, component, references, Size(count), values) == ERROR
        assert f"{LARGEST} value references" in fmu.log[-1].text
        for wrong in ((None, values), (references, None), (None, None), (odd, values)):
            assert fmu(name, component, wrong[0], Size(1), wrong[1]) == ERROR
        for unknown in (len(fmu.variables), 2**31, 2**32 - 1):
            assert fmu(name, component, (Uint * 1)(unknown), Size(1), values) == ERROR
        assert fmu(name, component, None, Size(0), None) == OK
    fmu.free(component)


@every_model
def test_types_do_not_mix(model: str) -> None:
    fmu, component, value = raw(model), raw(model).instantiate(), (Real * 1)()
    for variable in fmu.variables.values():
        own = "Integer" if variable.type == "Enumeration" else variable.type
        reference = (Uint * 1)(variable.valueReference)
        for kind in TYPES:
            status = fmu(f"Get{kind}", component, reference, Size(1), value)
            assert status == (OK if kind == own else ERROR), (variable.name, kind)
            if kind != own:
                assert fmu(f"Set{kind}", component, reference, Size(1), value) == ERROR
    fmu.free(component)


@every_model
def test_places_for_states_that_are_none_are_refused(model: str) -> None:
    fmu, component = raw(model), raw(model).begun()
    state, none, size = fmu.state(component), Pointer(), Size()
    room = ctypes.create_string_buffer(1 << 20)
    for name, *arguments in (
        ("GetFMUstate", None), ("SetFMUstate", None), ("FreeFMUstate", None),
        ("SerializedFMUstateSize", None, ctypes.byref(size)),
        ("SerializedFMUstateSize", state, None),
        ("SerializeFMUstate", None, room, Size(len(room))),
        ("SerializeFMUstate", state, None, Size(len(room))),
        ("SerializeFMUstate", state, room, Size(1)),
        ("DeSerializeFMUstate", None, Size(0), ctypes.byref(none)),
        ("DeSerializeFMUstate", room, Size(LARGEST), ctypes.byref(none)),
    ):  # fmt: skip
        assert fmu(name, component, *arguments) == ERROR, name
        assert not none, name
    assert fmu("FreeFMUstate", component, ctypes.byref(none)) == OK
    assert fmu("FreeFMUstate", component, ctypes.byref(state)) == OK
    fmu.free(component)


@every_model
def test_bytes_of_a_state_are_taken_whole_and_from_this_fmu_only(model: str) -> None:
    fmu, component = raw(model), raw(model).begun()
    data = fmu.serialised(component)
    for length in range(0, len(data), 7):
        assert fmu.deserialise(component, data[:length]) == ERROR
    assert fmu.deserialise(component, data + b"\0") == ERROR
    for other in MODELS:
        theirs = raw(other).begun()
        status = fmu.deserialise(component, raw(other).serialised(theirs))
        assert status == (OK if other == model else ERROR)
        raw(other).free(theirs)
    assert fmu.serialised(component) == data
    fmu.free(component)


def test_instances_and_states_of_one_fmu_are_none_of_another() -> None:
    made = {model: raw(model).begun() for model in MODELS}
    for model, component in made.items():
        for other in MODELS:
            if other != model:
                state = raw(model).state(component)
                assert raw(other)("Reset", component) == ERROR
                assert raw(other)("SetFMUstate", made[other], state) == ERROR
                assert raw(other)("FreeFMUstate", made[other], ctypes.byref(state)) == ERROR
                raw(other).free(component)
                assert raw(model)("FreeFMUstate", component, ctypes.byref(state)) == OK
    for model, component in made.items():
        assert raw(model).step(component, 0.0, STEP) == OK
        raw(model).free(component)


@every_model
def test_thousands_of_instances_live_at_once(model: str) -> None:
    fmu = raw(model)
    made = [fmu.begun() for _ in range(MANY)]
    assert len({component.value for component in made}) == MANY
    for component in made:
        assert fmu.step(component, 0.0, STEP) == OK
    first, last = fmu.serialised(made[0]), fmu.serialised(made[-1])
    assert first == last
    for component in made:
        fmu.free(component)
        assert fmu.step(component, STEP, STEP) == ERROR


def _arguments(fmu: RawFmu, name: str, state: Pointer) -> tuple[object, ...]:
    """Return what to call a function with after the instance; no more than it needs to be legal."""
    nothing = (None, Size(0), None)
    if name.endswith("Derivatives"):
        return (None, Size(0), None, None)
    if name == "GetDirectionalDerivative":
        return (None, Size(0), None, Size(0), None, None)
    if name.removeprefix("Get").removeprefix("Set") in TYPES:
        return nothing
    if name.endswith("Status"):
        return (Int(0), None)
    return {
        "SetDebugLogging": (1, Size(0), None), "SetFMUstate": (state,),
        "SetupExperiment": (0, Real(0), Real(0), 0, Real(0)),
        "DoStep": (Real(0), Real(STEP), 1), "GetFMUstate": (ctypes.byref(Pointer()),),
        "FreeFMUstate": (ctypes.byref(Pointer()),),
        "SerializedFMUstateSize": (state, ctypes.byref(Size())),
        "SerializeFMUstate": (state, ctypes.create_string_buffer(1 << 20), Size(1 << 20)),
        "DeSerializeFMUstate": (b"", Size(0), ctypes.byref(Pointer())),
    }.get(name, ())  # fmt: skip


def _in_state(fmu: RawFmu, state: str) -> Pointer:
    """Return an instance in a state of the standard's life cycle."""
    component = fmu.instantiate()
    if state == "instantiated":
        return component
    if state == "error":  # a map that does not ascend
        point = fmu.variables["clutch1.map.position[2]"].valueReference
        assert fmu("SetReal", component, (Uint * 1)(point), Size(1), (Real * 1)(1.0)) == OK
    assert fmu("EnterInitializationMode", component) == OK
    if state == "initializationMode":
        return component
    assert fmu("ExitInitializationMode", component) == (ERROR if state == "error" else OK)
    if state == "terminated":
        assert fmu("Terminate", component) == OK
    return component


def _table() -> list[dict[str, str]]:
    lines = [line for line in TABLE.read_text("utf-8").splitlines() if not line.startswith("#")]
    return list(csv.DictReader(lines))


# Beyond the standard: importers read start values before they initialise.
GETTERS = tuple(f"fmi2Get{kind}" for kind in TYPES)
STATES = ("instantiated", "initializationMode", "stepComplete", "terminated", "error")
# What legal calls answer that have nothing to say, or were given no bytes; all others: OK.
ANSWERS = {
    "DeSerializeFMUstate": (ERROR,),
    **{f"Get{kind}Status": (DISCARD,) for kind in ("", "Real", "Integer", "Boolean", "String")},
}  # fmt: skip
# They have no state, or make or end it.
OUTSIDE = ("fmi2GetTypesPlatform", "fmi2GetVersion", "fmi2Instantiate", "fmi2FreeInstance")


@every_model
@pytest.mark.parametrize("state", STATES)
def test_every_function_is_legal_where_the_standard_says(model: str, state: str) -> None:
    fmu = raw(model)
    other = fmu.begun()
    saved = fmu.state(other)
    rows = [row for row in _table() if row["function"] not in OUTSIDE]
    assert len(rows) == 30
    for row in rows:
        component, name = _in_state(fmu, state), row["function"].removeprefix("fmi2")
        fmu.log.clear()
        status = fmu(name, component, *_arguments(fmu, name, saved))
        legal = bool(row[state]) or (row["function"] in GETTERS and state == "instantiated")
        illegal = any(f"is illegal in state {state}" in message.text for message in fmu.log)
        assert illegal == (not legal), (name, status, fmu.log)
        fine = (ERROR,) if illegal else ANSWERS.get(name, (OK,))
        assert status in fine, (name, status, fmu.log)
        fmu.free(component)
    assert fmu("FreeFMUstate", other, ctypes.byref(saved)) == OK
    fmu.free(other)


@every_model
@pytest.mark.parametrize("state", STATES)
def test_a_reset_from_any_state_is_a_fresh_start(model: str, state: str) -> None:
    fmu = raw(model)
    fresh = fmu.instantiate()
    component = _in_state(fmu, state)
    assert fmu("Reset", component) == OK
    assert fmu.serialised(component) == fmu.serialised(fresh)
    for one in (fresh, component):
        fmu.free(one)


@every_model
def test_a_step_the_model_cannot_make_leads_to_no_number(model: str) -> None:
    fmu = raw(model)
    for size in (0.0, -STEP, float("nan"), float("inf"), float("-inf")):
        component = fmu.begun()
        assert fmu.step(component, 0.0, size) == ERROR
        assert fmu.step(component, 0.0, STEP) == OK
        fmu.free(component)
    for size, refusal in (
        (5e-324, ERROR),
        (1e-300, ERROR),
        (1e9, DISCARD),
        (1e300, DISCARD),
        (1.7e308, DISCARD),
    ):
        component = fmu.begun()
        status = fmu.step(component, 0.0, size)
        assert status in (OK, refusal)
        if status != OK:
            assert len(fmu.log[-1].text) < 100, fmu.log[-1]
        if status == DISCARD:
            assert fmu.step(component, 0.0, STEP) == OK
        fmu.free(component)
