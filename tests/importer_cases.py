"""What every importer is given to run, and fmpy's answer to it.

The communication step is 2^-9 s, a whole number of nanoseconds and of bits: importers that count
time in integers, sums or differences all make the same steps. At 1 ms and 10 ms their steps and
times differ in the last bits; the loop shall give the same bits all the same.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import cache
from pathlib import Path

from fmpy import read_model_description
from fmu_instance import Instance

ROOT = Path(__file__).resolve().parent.parent
FMUS = ROOT / "target" / "fmu"
STEP = 2.0**-9  # s
STEPS = 512  # 1 s: clutch 1 slips, the shaft winds up, the vehicle starts to move
LOOP_STEPS = (STEP, 1e-3, 1e-2)  # s, each for 1 s
HALF = STEPS // 2  # after it, inputs change
TIMEOUT = 600  # s, for a program that takes two

# Start values by model and variable, SI: a launch in first gear with a request of 40 N·m.
STARTS: dict[str, dict[str, float | int | bool]] = {
    "DctPlant": {
        "engine.speed_start": 90.0, "engine.torque": 60.0, "clutch1.position": 0.0062,
        "road.grade": 0.02, "shaft1.gear": 1, "shaft2.gear": 2, "transmission.rigid": False,
    },
    "DctObserver": {
        "engine.torque": 60.0, "engine.speed": 90.0, "clutch1.position": 0.0062,
        "clutch2.speed": 10.0, "wheel.speed": 1.0, "adaptation.enabled": True,
    },
    "DctClutchControl": {"clutch1.torqueRequest": 40.0, "feedback.enabled": False},
}  # fmt: skip
# Inputs that change in mid-run.
LATER: dict[str, dict[str, float | int | bool]] = {
    "DctPlant": {"clutch1.position": 0.007, "clutch2.position": 0.004},
    "DctObserver": {"clutch1.position": 0.007, "clutch2.position": 0.004, "wheel.speed": 2.0},
    "DctClutchControl": {
        "clutch1.torqueRequest": 90.0, "clutch2.torqueRequest": 20.0, "feedback.enabled": True,
        "clutch1.friction": 0.25, "engine.speed": 150.0, "clutch1.torque": 60.0,
        "clutch2.torque": 15.0,
    },
}  # fmt: skip
MODELS = tuple(STARTS)

# Outputs that feed inputs of equal name, by component; components in the order plant, observer,
# control. Everything they carry is a function of states: every Jacobi master gets the same bits.
CONNECTIONS: tuple[tuple[str, str, str], ...] = (
    *(("DctPlant", "DctObserver", name)
      for name in ("engine.speed", "clutch1.speed", "clutch2.speed", "wheel.speed")),
    *(("DctObserver", "DctClutchControl", f"clutch{i}.{name}")
      for i in (1, 2) for name in ("friction", "muF")),
    *(("DctClutchControl", model, f"clutch{i}.position")
      for i in (1, 2) for model in ("DctPlant", "DctObserver")),
)  # fmt: skip
LOOP_STARTS: dict[str, dict[str, float | int | bool]] = {
    "DctPlant": {"engine.speed_start": 90.0, "engine.torque": 60.0},
    "DctObserver": {"engine.torque": 60.0},
    "DctClutchControl": {"clutch1.torqueRequest": 40.0, "feedback.enabled": True},
}


def fmu(model: str) -> Path:
    """Return the FMU of a model as `cargo fmu build` left it."""
    return FMUS / f"{model}.fmu"


@contextmanager
def started(model: str, values: dict[str, float | int | bool]) -> Iterator[Instance]:
    """Give a started instance with start values set; frees it afterwards."""
    with Instance(fmu(model)) as instance:
        for name, value in values.items():
            instance.set(name, value)
        instance.start()
        yield instance


def advance(instance: Instance, first: int, last: int) -> None:
    """Make the steps `first` to `last`, with the inputs of `LATER` from the middle on."""
    for k in range(first, last):
        if k == HALF:
            for name, value in LATER[instance.description.modelName].items():
                instance.set(name, value)
        instance.step(k * STEP, STEP)


@cache
def expected(model: str, steps: int = STEPS) -> dict[str, float]:
    """Return fmpy's outputs of a model alone after so many steps, by name."""
    with started(model, STARTS[model]) as instance:
        advance(instance, 0, steps)
        return instance.outputs()


@cache
def expected_loop(step: float = STEP) -> dict[str, dict[str, float]]:
    """Return fmpy's outputs of the three FMUs after 1 s, coupled as a Jacobi master does it."""
    with ExitStack() as stack:
        loop = {model: stack.enter_context(Instance(fmu(model))) for model in MODELS}
        _initialize(loop)
        for k in range(round(1.0 / step)):
            _transfer(loop)
            for instance in loop.values():
                instance.step(k * step, step)
        return {model: instance.outputs() for model, instance in loop.items()}


def _initialize(loop: dict[str, Instance]) -> None:
    for model, instance in loop.items():
        for name, value in LOOP_STARTS[model].items():
            instance.set(name, value)
        instance.slave.setupExperiment()
        instance.slave.enterInitializationMode()
    for _ in loop:
        _transfer(loop)
    for instance in loop.values():
        instance.slave.exitInitializationMode()


def _transfer(loop: dict[str, Instance]) -> None:
    values = [loop[source].get(name) for source, _, name in CONNECTIONS]
    for value, (_, target, name) in zip(values, CONNECTIONS, strict=True):
        loop[target].set(name, value)


def of_states_only(model: str, step: float = STEP) -> dict[str, float]:
    """Return the outputs of `expected_loop` that depend on no input at that instant."""
    outputs = read_model_description(str(fmu(model))).outputs
    names = [unknown.variable.name for unknown in outputs if not unknown.dependencies]
    return {name: expected_loop(step)[model][name] for name in names}


@cache
def ran_in(importer: str, what: str, step: float = STEP) -> dict[str, dict[str, float]]:
    """Return what `run_in_IMPORTER.py` prints: outputs by model and name after 1 s."""
    program = ROOT / "tests" / f"run_in_{importer}.py"
    command = [sys.executable, str(program), what, repr(step)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=TIMEOUT)
    assert done.returncode == 0, done.stdout + done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def differences(found: dict[str, float], wanted: dict[str, float]) -> dict[str, tuple]:
    """Return found and wanted values of outputs that are not equal to the last bit.

    Enumerations are left out: neither ecos nor libcosim offers them.
    """
    names = [name for name in wanted if not name.endswith((".state", ".phase"))]
    assert names
    pairs = {name: (found.get(name), wanted[name]) for name in names}
    return {name: pair for name, pair in pairs.items() if pair[0] != pair[1]}
